"""Where the cubes of a catalogue are: it remembers, and a bucket remembers whose cubes it holds.

Two catalogues that shared one place would take each other's cubes for garbage. So a catalogue has an id, and a bucket
that is used for the first time gets an object with it, by a put that fails where there is one already.
"""

import json
import uuid
from pathlib import Path

from sqlalchemy import Connection, delete, insert, select

from damperlab.studies.faults import Fault
from damperlab.studies.store.catalogue import Catalogue
from damperlab.studies.store.faults import StoreFault, cannot_use
from damperlab.studies.store.folder import Folder
from damperlab.studies.store.rows import ALIVE
from damperlab.studies.store.shelf import Shelf
from damperlab.studies.store.tables import facts, studies

MARKER = "damperlab.json"
"""The object that says whose cubes a bucket holds."""

CUBES = "cubes"
"""The shelf of the cubes, in the data directory or under the bucket's prefix."""


def shelf_of(catalogue: Catalogue, data_dir: Path, address: str | None) -> Shelf:
    """Give the shelf of a catalogue's cubes.

    Parameters
    ----------
    catalogue : Catalogue
        Asked, and told where it is the first time.
    data_dir : Path
        Where the cubes are unless another place is named or remembered.
    address : str, optional
        `s3://bucket/prefix`.

    Raises
    ------
    StoreFault
        If the place cannot be used, belongs to another catalogue, or is not the one where the cubes are.
    """
    with catalogue.reading() as connection:
        known = _fact(connection, "cubes")
        used = connection.execute(select(studies.c.number).where(ALIVE).limit(1)).first() is not None
    if address is None and known is None:
        return Folder(data_dir / CUBES)
    # here, for it needs a library that not every installation has
    from damperlab.studies.store.bucket import Bucket, open_bucket

    bucket: Bucket = open_bucket(address or known or "")
    if bucket.address == known:
        return bucket.at(CUBES)
    if known is None and used:
        raise StoreFault(
            Fault(
                "store",
                bucket.address,
                f"the data directory {data_dir}, where the studies of this catalogue are",
                "leave it out; or copy them: `damperlab backup FOLDER`, and `damperlab restore FOLDER` with "
                "a new data directory and this store",
            )
        )
    with catalogue.writing() as connection:
        mine = _fact(connection, "id") or _remember(connection, "id", uuid.uuid4().hex)
    _take(bucket, mine, known if used else None)
    with catalogue.writing() as connection:
        _remember(connection, "cubes", bucket.address)
    return bucket.at(CUBES)


def _take(bucket: "Shelf", mine: str, elsewhere: str | None) -> None:
    """Make sure that a bucket holds this catalogue's cubes; `elsewhere` is where they were when last seen."""
    from damperlab.studies.store.bucket import Bucket

    assert isinstance(bucket, Bucket)
    try:
        try:
            found = bucket.get(MARKER)
        except FileNotFoundError:
            found = None
        if found is None and elsewhere is not None:
            raise StoreFault(
                Fault(
                    "store",
                    f"{bucket.address}, which holds none of this catalogue's cubes",
                    elsewhere,
                    "leave it out; or copy everything there first, and name it then",
                )
            )
        content = json.dumps({"catalogue": mine}).encode()
        if found is None and not bucket.put_new(MARKER, content):
            found = bucket.get(MARKER)
    except OSError as error:
        raise cannot_use(bucket.address, error) from error
    if found is not None and found != content:
        raise StoreFault(
            Fault(
                "store",
                f"{bucket.address}, which holds the cubes of another catalogue",
                "a bucket, or a prefix in one, of this catalogue's own",
                "name the data directory or DAMPERLAB_CATALOGUE that belongs to it, or another prefix",
            )
        )


def _fact(connection: Connection, key: str) -> str | None:
    found = connection.execute(select(facts.c.value).where(facts.c.key == key)).scalar()
    return None if found is None else str(found)


def _remember(connection: Connection, key: str, value: str) -> str:
    connection.execute(delete(facts).where(facts.c.key == key))
    connection.execute(insert(facts).values(key=key, value=value))
    return value
