"""The latest studies of a family that are done: what they have taken tells what another one will."""

from sqlalchemy import select

from damperlab.studies.store.catalogue.rows import ALIVE, record_of
from damperlab.studies.store.catalogue.tables import studies
from damperlab.studies.store.record import Record
from damperlab.studies.store.store import Store

MOST_STUDIES = 8
"""Studies of the family that are looked at, the latest first."""


def done_of_family(store: Store, family: str) -> list[Record]:
    """Look up the latest studies of a family that are done.

    Parameters
    ----------
    store : Store
        Where the studies are.
    family : str
        As `damperlab.studies.digest.family_digest` names it; there is none of the empty one.
    """
    c = studies.c
    query = select(studies).where(c.family == family, c.family != "", ALIVE, c.state == "done")
    with store.catalogue.reading() as connection:
        rows = connection.execute(query.order_by(c.number.desc()).limit(MOST_STUDIES)).all()
    return [record_of(row) for row in rows]
