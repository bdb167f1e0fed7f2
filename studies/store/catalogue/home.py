"""Location of a catalogue's cubes, and the check that the catalogue and the cubes belong together.

Each catalogue has an id, and the folder or bucket of the cubes contains an owner marker with this id. If the
ids differ, the store is not opened, because the garbage collection could remove cubes of another catalogue.
"""

import json
import re
import uuid
from collections.abc import Iterable
from pathlib import Path

from sqlalchemy import Connection, delete, insert, select

from damperlab.studies.store.catalogue.catalogue import SQLITE_FILE, Catalogue
from damperlab.studies.store.catalogue.rows import ALIVE, last_number
from damperlab.studies.store.catalogue.tables import facts, studies
from damperlab.studies.store.faults import StoreFault, cannot_use, using
from damperlab.studies.store.files.folder import Folder
from damperlab.studies.store.files.shelf import Entry, Shelf

MARKER = "damperlab.json"
"""Name of the owner marker: the file with the id of the catalogue to which the cubes belong."""

CUBES = "cubes"
"""Name of the folder of the cubes, in the data directory or under the bucket's prefix."""

BACKUP_OF = "backup_of"
"""Key in the table `facts` of a backup's catalogue; the value is the id of the catalogue that is backed up."""

UNKNOWN_RESULTS = "unknown_results"
"""Key in the table `facts`; the value is the name of a cube that has results but is not in the catalogue."""

_REBUILD = "make the catalogue again from the cubes with `damperlab store rebuild`"
_NAME_IT = "name the catalogue that belongs to the cubes (--data-dir, or DAMPERLAB_CATALOGUE for PostgreSQL)"


def cube_name(study_id: str, number: int) -> str:
    """Return the name of a cube's folder."""
    return f"{study_id}-{number}.zarr"


def parse_cube_name(name: str) -> tuple[str, int] | None:
    """Read the study's id and serial number from the name of a cube's folder; return None for any other name."""
    found = re.fullmatch(r"([0-9a-f]{12}(?:-[0-9]{1,9})?)-([0-9]{1,18})\.zarr", name)
    return (found[1], int(found[2])) if found else None


def require_catalogue(data_dir: Path) -> None:
    """Check that a SQLite catalogue exists in a folder, or may be created there.

    Raises
    ------
    StoreFault
        If the folder has an owner marker or holds cubes, but has no SQLite catalogue.
    """
    cubes, catalogue = data_dir / CUBES, data_dir / SQLITE_FILE
    try:
        if catalogue.exists():
            return
        marked = any((place / MARKER).exists() for place in (data_dir, cubes))
        holds = _holds_cubes(Folder(cubes).shelves())
        # look for the catalogue again: another process may just have created both catalogue and owner marker
        if not (marked or holds) or catalogue.exists():
            return
    except OSError:
        return  # opening the catalogue will fail with a better message
    if not holds:
        raise StoreFault(
            "catalogue",
            f"no {SQLITE_FILE} in {data_dir}, which belongs to a catalogue that is elsewhere",
            "the catalogue that the folder belongs to",
            f"set DAMPERLAB_CATALOGUE to the address of the PostgreSQL database; if the database is lost, {_REBUILD}",
            f"The data folder {data_dir} belongs to a catalogue that is not in it.",
        )
    raise _without_catalogue(str(cubes), f"{catalogue} is missing")


def _without_catalogue(cubes: str, why: str) -> StoreFault:
    return StoreFault(
        "data_dir",
        f"cubes in {cubes} without their catalogue: {why}",
        "the catalogue that the cubes belong to",
        f"{_NAME_IT}; if it is lost, {_REBUILD}",
        f"There are cubes in {cubes} without their catalogue: {why}.",
    )


def shelf_of(catalogue: Catalogue, data_dir: Path, address: str | None) -> Shelf:
    """Return the storage location of a catalogue's cubes.

    Parameters
    ----------
    catalogue : Catalogue
        The catalogue, which stores the location.
    data_dir : Path
        The data directory, which contains the cubes if `address` is None and the catalogue has no stored address.
    address : str, optional
        Location of the cubes in an object store, `s3://bucket/prefix`; by default the stored address.

    Raises
    ------
    StoreFault
        If the location cannot be used, belongs to another catalogue, does not contain the cubes, or contains results
        that the catalogue does not have.
    """
    with catalogue.reading() as connection:
        known = fact(connection, "cubes")
        used = connection.execute(select(studies.c.number).where(ALIVE).limit(1)).first() is not None
    if address is None and known is None:
        folder = Folder(data_dir / CUBES)
        if owner_of(Folder(data_dir)) is not None:
            _own(Folder(data_dir), catalogue)
        _own_folder(catalogue, folder, used)
        return folder
    # imported here, because it needs an optional library
    from damperlab.studies.store.files.bucket import Bucket, open_bucket

    bucket: Bucket = open_bucket(address or known or "")
    if bucket.address == known:
        _own(Folder(data_dir), catalogue)
        return bucket.at(CUBES)
    if known is None and used:
        raise StoreFault(
            "store",
            bucket.address,
            f"the data directory {data_dir}, where the studies of this catalogue are",
            "leave `store` out; or copy the studies: `damperlab store backup FOLDER`, and `damperlab store restore FOLDER` "
            "with a new data directory and this store",
            f"The studies of this catalogue are in the data directory {data_dir}, not in {bucket.address}.",
        )
    if known is not None and used and owner_of(bucket) is None:
        raise StoreFault(
            "store",
            f"{bucket.address}, which holds none of this catalogue's cubes",
            known,
            "leave `store` out, or copy everything there first",
            f"{bucket.address} holds none of this catalogue's cubes; they are in {known}.",
        )
    _own(bucket, catalogue)
    with catalogue.writing() as connection:
        remember(connection, "cubes", bucket.address)
    _own(Folder(data_dir), catalogue)
    return bucket.at(CUBES)


def _own(place: Shelf, catalogue: Catalogue) -> None:
    """Write a missing owner marker; raise `StoreFault` if the location belongs to another catalogue."""
    found = owner_of(place)
    if found is None:
        with using(place.address):
            if mark_owner(place, catalogue_id(catalogue)):
                return
        found = owner_of(place)
    with catalogue.reading() as connection:
        if found == fact(connection, "id"):
            return
    raise StoreFault(
        "data_dir" if isinstance(place, Folder) else "store",
        f"{place.address}, which belongs to a catalogue other than {catalogue.name}",
        "a location that belongs to this catalogue, or to none",
        f"{_NAME_IT}, or another location; if that catalogue is lost, {_REBUILD}",
        f"{place.address} belongs to a catalogue other than {catalogue.name}.",
    )


def catalogue_id(catalogue: Catalogue) -> str:
    """Return the id of a catalogue. The first call creates the id."""
    with catalogue.reading() as connection:
        known = fact(connection, "id")
    if known is not None:
        return known
    with catalogue.writing() as connection:
        return fact(connection, "id") or remember(connection, "id", uuid.uuid4().hex)


def owner_of(place: Shelf) -> str | None:
    """Return the id in the owner marker of a location; None if there is no marker.

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
        f"{place.address}/{MARKER}",
        "an owner marker that is damaged",
        "the id of the catalogue that the cubes belong to",
        f"if the cubes belong to the catalogue of this data directory, remove the file and {_REBUILD}",
        f"The owner marker {place.address}/{MARKER}, which says what catalogue the cubes belong to, is damaged.",
    )


def mark_owner(place: Shelf, owner: str) -> bool:
    """Write a missing owner marker. Return whether the location now belongs to the catalogue with the id `owner`."""
    return place.put_new(MARKER, _marker(owner))


def _marker(owner: str) -> bytes:
    return json.dumps({"catalogue": owner}).encode()


def _own_folder(catalogue: Catalogue, folder: Folder, used: bool) -> None:
    # list the folder before reading the catalogue, because other processes change the catalogue first
    names = list(folder.shelves())
    with catalogue.reading() as connection:
        marked = fact(connection, "marked") is not None
        copied = fact(connection, BACKUP_OF) is not None
        last = last_number(connection)
    # read the marker last, because other processes write it before "marked" in the catalogue and before the first cube
    if owner_of(folder) is None:
        _require_own_cubes(catalogue, folder, _holds_cubes(names), used, marked)
    _own(folder, catalogue)
    # skip this check for a backup, because an interrupted backup has copied files without copying the rows
    for name in () if copied else names:
        parsed = parse_cube_name(name)
        # a cube without results may come from an interrupted submission, and does not show that the catalogue is old
        if parsed and parsed[1] > last and holds_results(folder.at(name)):
            raise older_copy(f"{folder.address}/{name}", catalogue.name)
    if not marked:
        with catalogue.writing() as connection:
            remember(connection, "marked", "yes")


def _require_own_cubes(catalogue: Catalogue, folder: Folder, holds: bool, used: bool, marked: bool) -> None:
    """Raise `StoreFault` if a folder without an owner marker cannot belong to this catalogue."""
    if holds and not used and not marked:
        raise _without_catalogue(folder.address, f"{catalogue.name} has no study")
    if marked and used and not holds:
        raise no_cubes(catalogue, folder)
    if marked and not catalogue.is_file:
        # all cubes of a catalogue must be in one folder
        raise StoreFault(
            "data_dir",
            f"{folder.address}, which does not belong to {catalogue.name}",
            "the data folder of this catalogue",
            "name that folder with --data-dir; if it is lost, run `damperlab store rebuild` to use this "
            "folder instead",
            f"The cubes of {catalogue.name} are in a different data folder from {folder.address}.",
        )


def no_cubes(catalogue: Catalogue, folder: Folder) -> StoreFault:
    """Return the error for a folder of cubes that has lost its owner marker and all cubes."""
    return StoreFault(
        "data_dir",
        f"none of the cubes of {catalogue.name} in {folder.address}",
        "the folder that holds the cubes",
        "check that its disk is mounted; if the cubes are lost for good, restore a backup",
        f"{folder.address} holds none of the cubes of {catalogue.name}.",
    )


def _holds_cubes(shelves: Iterable[str]) -> bool:
    return any(name.endswith(".zarr") for name in shelves)


def disk_gone(shelf: Shelf) -> str | None:
    """Return a message if the folder of the cubes has no owner marker, as after an unmount; else None."""
    if not isinstance(shelf, Folder):
        return None
    try:
        shelf.stamp(MARKER)
    except OSError as error:
        return f"{shelf.address} is not the folder that was opened ({error}): check that its disk is mounted"
    return None


def older_copy(cube: str, catalogue: str) -> StoreFault:
    """Return the error for a cube with results that the catalogue does not have."""
    return StoreFault(
        "catalogue",
        f"results in {cube} that {catalogue} does not have: the catalogue is an older copy",
        "the newest state of the catalogue",
        "put the newest catalogue back, or add the missing studies to this one with `damperlab store "
        "rebuild`",
        f"{cube} holds results that {catalogue} does not have: the catalogue is an older copy.",
    )


def holds_results(cube: Shelf) -> bool:
    """Whether a cube contains the file of a block, with or without a done-mark."""
    return any(map(is_of_block, cube.entries()))


def is_of_block(entry: Entry) -> bool:
    """Whether a file of a cube belongs to a block. The name of such a file ends with a tilde and the name of the
    attempt to compute the block.
    """
    return "~" in entry.key


def fact(connection: Connection, key: str) -> str | None:
    """Return the value of a key in the table `facts`; None if there is no such key."""
    found = connection.execute(select(facts.c.value).where(facts.c.key == key)).scalar()
    return None if found is None else str(found)


def forget(connection: Connection, key: str) -> None:
    """Remove a key and its value from the table `facts`."""
    connection.execute(delete(facts).where(facts.c.key == key))


def remember(connection: Connection, key: str, value: str) -> str:
    """Store the value of a key in the table `facts`, replacing an earlier value, and return the value."""
    forget(connection, key)
    connection.execute(insert(facts).values(key=key, value=value))
    return value
