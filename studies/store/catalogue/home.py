"""Location and ownership of a catalogue's cubes: the catalogue and the location each store the other's identity.

A catalogue would take the cubes of another one for garbage, so each catalogue has an id. The location of its cubes, a
folder or a bucket, holds an owner marker with that id, which is written once and never replaced. A mismatch is refused
before anything is read or removed. It shows that the catalogue is another one, an empty one or an older copy, or that
a disk is not mounted.
"""

import json
import re
import uuid
from collections.abc import Iterable
from pathlib import Path

from sqlalchemy import Connection, delete, func, insert, select

from damperlab.studies.faults import Fault
from damperlab.studies.store.catalogue.catalogue import SQLITE_FILE, Catalogue
from damperlab.studies.store.catalogue.rows import ALIVE
from damperlab.studies.store.catalogue.tables import facts, studies
from damperlab.studies.store.faults import StoreFault, cannot_use, using
from damperlab.studies.store.files.folder import Folder
from damperlab.studies.store.files.shelf import Entry, Shelf

MARKER = "damperlab.json"
"""The piece with the owner of a location's cubes."""

CUBES = "cubes"
"""The shelf of the cubes, in the data directory or under the bucket's prefix."""

BACKUP_OF = "backup_of"
"""The fact, in the catalogue of a copy, that names the catalogue whose studies are copied there."""

UNKNOWN_RESULTS = "unknown_results"
"""The fact that names a cube with results that the catalogue lacks; the catalogue is then an older copy."""

_REBUILD = "make the catalogue again from the cubes with `damperlab store rebuild`"
_NAME_IT = "name the catalogue that belongs to them (--data-dir, or DAMPERLAB_CATALOGUE for PostgreSQL)"


def cube_name(study_id: str, number: int) -> str:
    """Give the name of a cube's shelf."""
    return f"{study_id}-{number}.zarr"


def parse_cube_name(name: str) -> tuple[str, int] | None:
    """Read the study's id and number from the name of a cube's shelf; None for any other name."""
    found = re.fullmatch(r"([0-9a-f]{12}(?:-[0-9]{1,9})?)-([0-9]{1,18})\.zarr", name)
    return (found[1], int(found[2])) if found else None


def require_catalogue(data_dir: Path) -> None:
    """Refuse to create a SQLite catalogue in a folder that belongs to some catalogue already.

    Raises
    ------
    StoreFault
        If the folder has an owner marker or holds cubes, but has no SQLite catalogue.
    """
    cubes, catalogue = data_dir / CUBES, data_dir / SQLITE_FILE
    try:
        marked = any((place / MARKER).exists() for place in (data_dir, cubes))
        holds = _holds_cubes(Folder(cubes).shelves())
        owned = not catalogue.exists() and (marked or holds)
        # checked again: a process that opens a new folder creates the catalogue before its marker and its first cube
        if not owned or catalogue.exists():
            return
    except OSError:
        return  # opening the catalogue gives a better message
    if not holds:
        raise StoreFault(
            Fault(
                "catalogue",
                f"no {SQLITE_FILE} in {data_dir}, which belongs to a catalogue that is elsewhere",
                "the catalogue that the folder belongs to",
                f"set DAMPERLAB_CATALOGUE to the address of its PostgreSQL database; if it is lost, {_REBUILD}",
                f"The data folder {data_dir} belongs to a catalogue that is not in it.",
            )
        )
    raise StoreFault(
        Fault(
            "data_dir",
            f"cubes in {cubes} without their catalogue",
            f"the catalogue that the cubes belong to, {data_dir / SQLITE_FILE} or a PostgreSQL database",
            f"{_NAME_IT}; if it is lost, {_REBUILD}",
            f"There are cubes in {cubes} without their catalogue, which is {data_dir / SQLITE_FILE} or a PostgreSQL database.",
        )
    )


def shelf_of(catalogue: Catalogue, data_dir: Path, address: str | None) -> Shelf:
    """Give the shelf of a catalogue's cubes.

    Parameters
    ----------
    catalogue : Catalogue
        The catalogue; the first call stores the location in it.
    data_dir : Path
        Location of the cubes unless another one is named or stored.
    address : str, optional
        `s3://bucket/prefix`.

    Raises
    ------
    StoreFault
        If the location cannot be used, belongs to another catalogue, does not hold the cubes, or holds results that the
        catalogue lacks.
    """
    with catalogue.reading() as connection:
        known = fact(connection, "cubes")
        used = connection.execute(select(studies.c.number).where(ALIVE).limit(1)).first() is not None
    if address is None and known is None:
        folder = Folder(data_dir / CUBES)
        _own_data_folder(catalogue, data_dir, mark=False)
        _own_folder(catalogue, folder, used)
        return folder
    # imported here, because it needs an optional library
    from damperlab.studies.store.files.bucket import Bucket, open_bucket

    bucket: Bucket = open_bucket(address or known or "")
    if bucket.address == known:
        _own_data_folder(catalogue, data_dir)
        return bucket.at(CUBES)
    if known is None and used:
        raise StoreFault(
            Fault(
                "store",
                bucket.address,
                f"the data directory {data_dir}, where the studies of this catalogue are",
                "leave it out; or copy them: `damperlab store backup FOLDER`, and `damperlab store restore FOLDER` with "
                "a new data directory and this store",
                f"The studies of this catalogue are in the data directory {data_dir}, not in {bucket.address}.",
            )
        )
    _own_bucket(bucket, catalogue_id(catalogue), known if used else None)
    with catalogue.writing() as connection:
        remember(connection, "cubes", bucket.address)
    _own_data_folder(catalogue, data_dir)
    return bucket.at(CUBES)


def _own_data_folder(catalogue: Catalogue, data_dir: Path, mark: bool = True) -> None:
    """Check that a data folder belongs to this catalogue.

    A catalogue may have several data folders if its cubes are in a bucket.
    """
    folder = Folder(data_dir)
    if not mark and owner_of(folder) is None:
        return
    others = Fault(
        "data_dir",
        f"{data_dir}, which belongs to a catalogue other than {catalogue.name}",
        "a new folder, or one of this catalogue's",
        "name the folder of this catalogue (--data-dir), or the catalogue of this folder (DAMPERLAB_CATALOGUE)",
        f"The data folder {data_dir} belongs to a catalogue other than {catalogue.name}.",
    )
    _own(folder, catalogue_id(catalogue), others)


def _own(place: Shelf, mine: str, others: Fault) -> None:
    """Write the owner marker if there is none; raise `StoreFault` with a fault if the location belongs to another
    catalogue.
    """
    found = owner_of(place)
    with using(place.address):
        if found is None and not mark_owner(place, mine):
            found = owner_of(place)
    if found not in (None, mine):
        raise StoreFault(others)


def catalogue_id(catalogue: Catalogue) -> str:
    """Give the id of a catalogue; the first call creates it."""
    with catalogue.reading() as connection:
        known = fact(connection, "id")
    if known is not None:
        return known
    with catalogue.writing() as connection:
        return fact(connection, "id") or remember(connection, "id", uuid.uuid4().hex)


def owner_of(place: Shelf) -> str | None:
    """Give the id of the catalogue that owns a location; None if there is no marker.

    Raises
    ------
    StoreFault
        If the marker cannot be read.
    """
    try:
        content = place.get(MARKER)
    except FileNotFoundError:
        return None
    except OSError as error:
        raise cannot_use(place.address, error) from error
    try:
        found = json.loads(content)["catalogue"]
        if isinstance(found, str) and re.fullmatch("[0-9a-f]{32}", found) and content == _marker(found):
            return found
    except (ValueError, KeyError, TypeError):
        pass
    raise StoreFault(
        Fault(
            f"{place.address}/{MARKER}",
            "an owner marker that is damaged",
            "the id of the catalogue that the cubes belong to",
            f"if the cubes belong to the catalogue of this data directory, remove the file and {_REBUILD}",
            f"The owner marker {place.address}/{MARKER}, which says what catalogue the cubes belong to, is damaged.",
        )
    )


def mark_owner(place: Shelf, owner: str) -> bool:
    """Write the owner marker if there is none; say whether the location belongs to this owner now."""
    return place.put_new(MARKER, _marker(owner))


def _marker(owner: str) -> bytes:
    return json.dumps({"catalogue": owner}).encode()


def _own_folder(catalogue: Catalogue, folder: Folder, used: bool) -> None:
    # the folder is read first, then the catalogue, because a writer writes the catalogue first
    found = owner_of(folder)
    names = list(folder.shelves())
    holds = _holds_cubes(names)
    if found is None and holds:
        # a process that opens a new folder marks it before its first cube
        found = owner_of(folder)
    with catalogue.reading() as connection:
        mine = fact(connection, "id")
        marked = fact(connection, "marked") is not None
        copied = fact(connection, BACKUP_OF) is not None
        last = int(connection.execute(select(func.coalesce(func.max(studies.c.number), 0))).scalar_one())
    if found is None and marked:
        # a process that opens a new folder writes the marker before it records it in the catalogue
        found = owner_of(folder)
    if found is None:
        _require_own_cubes(catalogue, folder, holds, used, marked)
        mine = catalogue_id(catalogue)
    others = Fault(
        "data_dir",
        f"cubes in {folder.address} that belong to a catalogue other than {catalogue.name}",
        "the catalogue that they belong to",
        f"{_NAME_IT}; if it is lost, {_REBUILD}",
        f"The cubes in {folder.address} belong to a catalogue other than {catalogue.name}.",
    )
    _own(folder, mine or "", others)
    # a copy's files come before its rows, so an interrupted copy can be continued
    for name in () if copied else names:
        parsed = parse_cube_name(name)
        # an interrupted submission leaves a cube that its catalogue does not have, but without results
        if parsed and parsed[1] > last and holds_results(folder.at(name)):
            raise older_copy(f"{folder.address}/{name}", catalogue.name)
    if not marked:
        with catalogue.writing() as connection:
            remember(connection, "marked", "yes")


def _require_own_cubes(catalogue: Catalogue, folder: Folder, holds: bool, used: bool, marked: bool) -> None:
    """Refuse a folder without a marker if it cannot belong to this catalogue."""
    if holds and not used and not marked:
        raise StoreFault(
            Fault(
                "data_dir",
                f"cubes in {folder.address}, and {catalogue.name}, which has no study",
                "the catalogue that the cubes belong to",
                f"{_NAME_IT}; if it is lost, {_REBUILD}",
                f"There are cubes in {folder.address}, but {catalogue.name} has no study.",
            )
        )
    if marked and used and not holds:
        raise no_cubes(catalogue, folder)
    if marked and not catalogue.is_file:
        # otherwise the catalogue would look for its cubes in two folders
        raise StoreFault(
            Fault(
                "data_dir",
                f"{folder.address}, which {catalogue.name} does not have",
                "the data folder of this catalogue",
                "name that folder with --data-dir; if it is lost, let the catalogue continue here with "
                "`damperlab store rebuild`",
                f"The cubes of {catalogue.name} are in a different data folder from {folder.address}.",
            )
        )


def no_cubes(catalogue: Catalogue, folder: Folder) -> StoreFault:
    """Make the fault for a folder of a catalogue's cubes that has lost its marker and all cubes."""
    return StoreFault(
        Fault(
            "data_dir",
            f"none of the cubes of {catalogue.name} in {folder.address}",
            "the folder that holds them",
            "check that its disk is mounted; if the cubes are lost for good, restore a backup",
            f"{folder.address} holds none of the cubes of {catalogue.name}.",
        )
    )


def _holds_cubes(shelves: Iterable[str]) -> bool:
    return any(name.endswith(".zarr") for name in shelves)


def disk_gone(shelf: Shelf) -> str | None:
    """Report that the folder of the cubes was exchanged since it was opened, for example by unmounting. None if it
    was not, and for a bucket.
    """
    if not isinstance(shelf, Folder):
        return None
    try:
        shelf.stamp(MARKER)
    except OSError as error:
        return f"{shelf.address} is not the folder that was opened ({error}): check that its disk is mounted"
    return None


def older_copy(cube: str, catalogue: str) -> StoreFault:
    """Make the fault for a cube with results that is missing from the catalogue."""
    return StoreFault(
        Fault(
            "catalogue",
            f"results in {cube} that {catalogue} does not have: it is an older copy",
            "the newest state of the catalogue",
            "put the newest catalogue back, or add the missing studies to this one with `damperlab store "
            "rebuild`",
            f"{cube} holds results that {catalogue} does not have: the catalogue is an older copy.",
        )
    )


def holds_results(cube: Shelf) -> bool:
    """Whether a cube holds the file of any block, done or not."""
    return any(map(is_of_block, cube.entries()))


def is_of_block(entry: Entry) -> bool:
    """Whether a piece of a cube belongs to a block: the name of such a piece contains a generation."""
    return "~" in entry.key


def _own_bucket(bucket: Shelf, mine: str, elsewhere: str | None) -> None:
    """Check that a bucket holds this catalogue's cubes; `elsewhere` is their last known location."""
    if elsewhere is not None and owner_of(bucket) is None:
        raise StoreFault(
            Fault(
                "store",
                f"{bucket.address}, which holds none of this catalogue's cubes",
                elsewhere,
                "leave `store` out, or copy everything there first",
                f"{bucket.address} holds none of this catalogue's cubes; they are in {elsewhere}.",
            )
        )
    others = Fault(
        "store",
        f"{bucket.address}, which holds the cubes of another catalogue",
        "a bucket, or a prefix in one, of this catalogue's own",
        f"{_NAME_IT}, or another prefix; if the catalogue is lost, {_REBUILD}",
        f"{bucket.address} holds the cubes of another catalogue.",
    )
    _own(bucket, mine, others)


def fact(connection: Connection, key: str) -> str | None:
    """Give the catalogue's own fact under a key."""
    found = connection.execute(select(facts.c.value).where(facts.c.key == key)).scalar()
    return None if found is None else str(found)


def forget(connection: Connection, key: str) -> None:
    """Remove a key and its value from the catalogue."""
    connection.execute(delete(facts).where(facts.c.key == key))


def remember(connection: Connection, key: str, value: str) -> str:
    """Store a fact about the catalogue itself, replacing the one under that key."""
    forget(connection, key)
    connection.execute(insert(facts).values(key=key, value=value))
    return value
