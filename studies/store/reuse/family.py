"""The latest completed studies of a family, from which the run time of a new study is predicted."""

from sqlalchemy import select

from damperlab.studies.store.catalogue.rows import ALIVE, record_of
from damperlab.studies.store.catalogue.tables import studies
from damperlab.studies.store.record import Record
from damperlab.studies.store.store import Store

MOST_STUDIES = 8
"""Largest number of studies that `done_of_family` returns."""


def done_of_family(store: Store, family: str) -> list[Record]:
    """Find the latest completed studies of a family.

    Parameters
    ----------
    store : Store
        The store.
    family : str
        Digest of the family, from `damperlab.studies.digest.family_digest`; no study is found for an empty text.
    """
    c = studies.c
    query = select(studies).where(c.family == family, c.family != "", ALIVE, c.state == "done")
    with store.catalogue.reading() as connection:
        rows = connection.execute(query.order_by(c.number.desc()).limit(MOST_STUDIES)).all()
    return [record_of(row) for row in rows]
