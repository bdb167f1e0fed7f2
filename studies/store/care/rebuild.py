"""Reconstruction of the catalogue from the files of the cubes.

Missing studies are added one by one, each in one transaction. So `rebuild` may be killed at any moment and run again.
"""

import json
import math
import sqlite3
import time
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path
from typing import Any

from sqlalchemy import Connection, delete, func, insert, or_, select

from damperlab.studies.digest import family_digest
from damperlab.studies.kind import AnyStudy
from damperlab.studies.store.catalogue.catalogue import SQLITE_FILE, Catalogue, open_catalogue
from damperlab.studies.store.catalogue.home import (
    CUBES,
    catalogue_id,
    fact,
    mark_owner,
    no_cubes,
    owner_of,
    parse_cube_name,
    remember,
)
from damperlab.studies.store.catalogue.rows import (
    ALIVE,
    advance_counters,
    change_studies,
    last_event,
    rows_of_marks,
    sums_of_marks,
)
from damperlab.studies.store.catalogue.rowsum import is_sound
from damperlab.studies.store.catalogue.tables import access_keys, done_blocks, events, metadata, studies
from damperlab.studies.store.cube.block_file import BLOCKS, parse_block_key, read_header
from damperlab.studies.store.cube.definition import parse_stored
from damperlab.studies.store.cube.description import DESCRIPTION, Description, describe_cube
from damperlab.studies.store.faults import CatalogueDamaged, StoreFault, cannot_use
from damperlab.studies.store.files.folder import Folder
from damperlab.studies.store.files.shelf import Shelf
from damperlab.studies.store.life_cycle.entering import Submission
from damperlab.studies.store.life_cycle.manifest import (
    NOT_KEPT,
    lost_end,
    put_off_marks,
    read_marks,
    read_tombstone,
)
from damperlab.studies.store.provenance import asked_by
from damperlab.studies.store.record import BlockOutcome


@dataclass
class Rebuilt:
    """Result of `rebuild`.

    Parameters
    ----------
    studies, blocks : int
        Number of studies and of blocks that were added to the catalogue.
    known : int
        Number of studies that the catalogue already had.
    restored : int
        Number of known studies whose lost final state or provenance was restored.
    deleted : int
        Number of deleted studies whose files still exist. These studies stay deleted.
    trouble : list of str
        Cubes and files that could not be used, with the reasons.
    set_aside : str, optional
        New name of a damaged catalogue; None if the catalogue was intact or missing.
    """

    studies: int = 0
    blocks: int = 0
    known: int = 0
    restored: int = 0
    deleted: int = 0
    trouble: list[str] = field(default_factory=list)
    set_aside: str | None = None


def rebuild(data_dir: Path, address: str | None = None, cubes: str | None = None) -> Rebuilt:
    """Add every study that has a cube to the catalogue. Create the catalogue if it is missing.

    Parameters
    ----------
    data_dir : Path
        The data directory.
    address : str, optional
        Address of a PostgreSQL database for the catalogue; by default the catalogue is a SQLite file in `data_dir`.
    cubes : str, optional
        Location of the cubes, `s3://bucket/prefix`; by default the location in the catalogue, else `data_dir`.

    Raises
    ------
    StoreFault
        If the catalogue contains studies whose cubes are elsewhere, or the location of the cubes cannot be read.
    """
    data_dir = Path(data_dir).expanduser().absolute()
    found = Rebuilt()
    if address is None:
        found.set_aside = _set_damaged_aside(data_dir)
    try:
        catalogue = _opened(data_dir, address)
    except CatalogueDamaged:
        if address is not None:
            raise
        found.set_aside = _set_aside(data_dir / SQLITE_FILE)
        catalogue = open_catalogue(data_dir)
    try:
        shelf = _own(catalogue, data_dir, cubes)
        cubes_there = [(parsed, name) for name in shelf.shelves() if (parsed := parse_cube_name(name))]
        # start with the newest cube: if a study has two cubes, the older cube belongs to a deleted study
        for (study_id, number), name in sorted(cubes_there, key=lambda cube: cube[0][1], reverse=True):
            try:
                _add(catalogue, shelf.at(name), study_id, number, found)
            except (StoreFault, ValueError, FileNotFoundError) as error:
                found.trouble.append(f"{name}: {error}")
        _drop_damaged(catalogue)
    except OSError as error:
        raise cannot_use(str(data_dir), error) from error
    finally:
        catalogue.close()
    return found


def _opened(data_dir: Path, address: str | None) -> Catalogue:
    """Open a catalogue; raise `CatalogueDamaged` if its tables are damaged."""
    catalogue = open_catalogue(data_dir, address)
    try:
        with catalogue.reading() as connection:
            for table in metadata.sorted_tables:
                connection.execute(select(table).limit(1))
    except StoreFault:
        catalogue.close()
        raise
    return catalogue


def _set_damaged_aside(data_dir: Path) -> str | None:
    """Rename a damaged SQLite catalogue, and return the new name; None if the catalogue is intact or missing."""
    file = data_dir / SQLITE_FILE
    if not file.is_file():
        return None
    with suppress(sqlite3.DatabaseError, UnicodeDecodeError):
        connection = sqlite3.connect(file, timeout=60.0)
        try:
            if connection.execute("PRAGMA integrity_check(1)").fetchall() == [("ok",)]:
                return None
        finally:
            connection.close()
    return _set_aside(file)


def _set_aside(file: Path) -> str:
    aside = file.with_name(f"{SQLITE_FILE}.damaged-{time.strftime('%Y%m%dT%H%M%S')}")
    for suffix in ("-wal", "-shm", ""):
        with suppress(FileNotFoundError):
            file.with_name(file.name + suffix).rename(aside.with_name(aside.name + suffix))
    return str(aside)


def _own(catalogue: Catalogue, data_dir: Path, address: str | None) -> Shelf:
    """Record that the catalogue and the location of the cubes belong together, and return the location."""
    with catalogue.reading() as connection:
        address = address or fact(connection, "cubes")
        known = fact(connection, "id")
        marked = fact(connection, "marked") is not None
        used = connection.execute(select(studies.c.number).limit(1)).first() is not None
        alive = connection.execute(select(studies.c.number).where(ALIVE).limit(1)).first() is not None
    if address is None:
        folder = Folder(data_dir / CUBES)
        if marked and alive and owner_of(folder) is None and not any(map(parse_cube_name, folder.shelves())):
            # the disk of the cubes is probably not mounted; an owner marker must not be written into the empty folder
            raise no_cubes(catalogue, folder)
        place: Shelf = folder
        shelf: Shelf = folder
    else:
        from damperlab.studies.store.files.bucket import open_bucket

        place = open_bucket(address)
        shelf = place.at(CUBES)
    owner = owner_of(place)
    if owner is not None and used and known not in (None, owner):
        raise StoreFault(
            "catalogue",
            f"{catalogue.name}, which holds studies whose cubes are not those in {place.address}",
            "the catalogue of these cubes, an empty catalogue, or no catalogue",
            "move the catalogue away, or name an empty database, and run `damperlab store rebuild` again",
            f"{catalogue.name} holds studies whose cubes are not those in {place.address}.",
        )
    mine = owner or catalogue_id(catalogue)
    with catalogue.writing() as connection:
        remember(connection, "id", mine)
        if address is not None:
            remember(connection, "cubes", place.address)
        else:
            remember(connection, "marked", "yes")
    if owner is None:
        mark_owner(place, mine)
    if address is not None:
        mark_owner(Folder(data_dir), mine)
    return shelf


@dataclass(frozen=True)
class _Cube:
    """The data in a cube from which `rebuild` makes the study's rows in the catalogue."""

    described: Description
    study: AnyStudy
    provenance: dict[str, str]
    # columns of the study's row, written when the study ended
    kept: dict[str, Any]
    marks: list[dict[str, Any]]
    # time of the deletion of the study
    deleted: float | None


def _add(catalogue: Catalogue, shelf: Shelf, study_id: str, number: int, found: Rebuilt) -> None:
    """Add the study of a cube, or restore what the catalogue has lost about the study."""
    cube = _read(shelf, study_id, found)
    if cube is None:
        return
    with catalogue.writing() as connection:
        _remove_damaged(connection, study_id, number)
        row = connection.execute(select(studies).where(studies.c.number == number)).one_or_none()
        same = select(studies.c.number).where(studies.c.id == study_id, ALIVE)
        exists = connection.execute(same).first() is not None
        if row is not None and not row.id:
            # the row only reserves the number: the study was never entered, or the catalogue has lost the study
            if exists and not cube.marks:
                return  # the submission was interrupted, and repeated later
            connection.execute(delete(studies).where(studies.c.number == number))
            row = None
        restored = True
        if row is None:
            if exists and cube.deleted is None:
                raise ValueError(f"study {study_id} has another cube")
            _insert_study(connection, cube, study_id, number)
            if cube.deleted is not None:
                found.deleted += 1
                return  # `Deletion.bury` will remove the files
            found.studies += 1
        elif row.id != study_id:
            if cube.deleted is None and (cube.marks or not exists):
                raise ValueError(_taken(study_id, number, str(row.id)))
            return  # the cube of a deleted study or of an interrupted submission
        elif row.deleted is not None:
            return
        elif cube.deleted is not None:
            change_studies(connection, [number], {"deleted": cube.deleted})
            found.deleted += 1
            return
        else:
            found.known += 1
            restored = lost_end(cube.kept, row, last_event(connection, study_id))
            if not row.blocks_done and cube.provenance != json.loads(row.provenance):
                # a new solver is written to the cube before the catalogue, so the cube has the newer provenance
                said = {
                    "provenance": json.dumps(cube.provenance),
                    **asked_by(cube.provenance),
                    "family": family_digest(cube.study, cube.provenance),
                }
                change_studies(connection, [number], said)
                found.restored += 1
        total = math.prod(cube.described.grid)
        have, lost = _sound_marks(connection, number)
        fresh = [mark for mark in cube.marks if 0 <= mark["block"] < total and mark["block"] not in have]
        if fresh or lost or restored:
            _insert_marks(connection, number, fresh)
            found.blocks += len(fresh)
            found.restored += row is not None and restored
            _sum_up(connection, study_id, number, total, cube.kept, restored)


def _read(shelf: Shelf, study_id: str, found: Rebuilt) -> _Cube | None:
    """Read a cube. If the removal of the cube was interrupted, complete the removal, count the deletion, and return
    None.
    """
    deleted = read_tombstone(shelf)
    try:
        described = describe_cube(shelf.get(DESCRIPTION))
    except FileNotFoundError:
        if deleted is None:
            raise
        shelf.clear()
        found.deleted += 1
        return None
    study = parse_stored(json.loads(str(described.attributes["study"])), described.digest)
    if study.digest[:12] != study_id.partition("-")[0]:
        raise ValueError(f"its description is that of study {study.digest[:12]}")
    kept, marks = read_marks(shelf) or ({}, [])
    known = {int(mark["block"]) for mark in marks}
    provenance = json.loads(str(described.attributes["provenance"]))
    headers = _headers(shelf, described, provenance.get("identity", ""), found)
    marks += [mark for mark in headers if mark["block"] not in known]
    return _Cube(described, study, provenance, kept, marks, deleted)


def _remove_damaged(connection: Connection, study_id: str, number: int) -> None:
    """Remove damaged rows of a study and their done-marks. The cube contains the same data."""
    query = select(studies).where(or_(studies.c.number == number, studies.c.id == study_id))
    for row in connection.execute(query).all():
        if not is_sound(studies, row):
            connection.execute(delete(done_blocks).where(done_blocks.c.study == row.number))
            connection.execute(delete(studies).where(studies.c.number == row.number))


def _insert_study(connection: Connection, cube: _Cube, study_id: str, number: int) -> None:
    described = cube.described
    chunk = next(iter(described.arrays.values())).chunks
    version = int(study_id.partition("-")[2] or 1)
    entry = Submission(cube.study, chunk, cube.provenance, described.reuse, version=version)
    created = datetime.fromisoformat(str(described.attributes["created"])).timestamp()
    values = {**entry.columns(), "number": number, "id": study_id, "created": created}
    values |= {name: value for name, value in cube.kept.items() if name in studies.c and name not in NOT_KEPT}
    connection.execute(insert(studies).values({**values, "deleted": cube.deleted}))
    advance_counters(connection)


def _sound_marks(connection: Connection, number: int) -> tuple[set[int], int]:
    """Remove the damaged done-marks of a study. Return the blocks of the intact done-marks, and the number of removed
    done-marks.
    """
    sound, lost = set(), 0
    for mark in rows_of_marks(connection, number):
        if is_sound(done_blocks, mark):
            sound.add(mark.block)
        else:
            place = done_blocks.c.study == number, done_blocks.c.block == mark.block
            connection.execute(delete(done_blocks).where(*place))
            lost += 1
    return sound, lost


def _drop_damaged(catalogue: Catalogue) -> None:
    """Remove damaged rows that cannot be restored from a cube: events and access keys."""
    with catalogue.writing() as connection:
        for table in (events, access_keys):
            own = next(iter(table.primary_key.columns))
            for row in connection.execute(select(table)).all():
                if not is_sound(table, row):
                    connection.execute(delete(table).where(own == row._mapping[own.name]))


def _headers(shelf: Shelf, described: Description, identity: str, found: Rebuilt) -> Iterator[dict[str, Any]]:
    """Yield the done-marks in the headers of the blocks' files. If a block has several files, use the file whose name
    sorts first.

    Blocks of another solver are left out, because a cube must not contain results of two solvers.
    """
    seen: set[int] = set()
    for entry in sorted(shelf.at(BLOCKS).entries(), key=lambda entry: entry.key):
        key = f"{BLOCKS}/{entry.key}"
        parsed = parse_block_key(key)
        if parsed is None or key.endswith(".partial") or parsed[0] in seen:
            continue
        try:
            header, _ = read_header(shelf, key)
            header.require(described.digest, *parsed)
        except (ValueError, FileNotFoundError) as error:
            found.trouble.append(f"{shelf.name}/{key}: {error}")
            continue
        if header.mark.get("message") is None and header.mark.get("identity", "") in ("", identity):
            seen.add(parsed[0])
            yield dict(header.mark)


def _taken(study_id: str, number: int, other: str) -> str:
    return (
        f"its number, {number}, belongs to study {other}: rename its folder to {study_id}-N.zarr with a "
        "number N that no cube has, and run `damperlab store rebuild` again"
    )


def _insert_marks(connection: Connection, number: int, marks: list[dict[str, Any]]) -> None:
    names = [column.name for column in done_blocks.c if column.name not in ("study", "crc")]
    untold = {**vars(BlockOutcome(index=0, points=0, failed=0)), "revision": 0, "at": 0.0}
    told = ({**untold, **mark} for mark in marks)
    rows = [{"study": number, **{name: mark[name] for name in names}} for mark in told]
    if rows:
        connection.execute(insert(done_blocks), rows)


def _sum_up(
    connection: Connection, study_id: str, number: int, total: int, kept: dict[str, Any], restored: bool
) -> None:
    change = sums_of_marks(connection, number)
    # use a revision above all revisions of the lost catalogue
    columns = studies.c.revision, studies.c.state
    before = connection.execute(select(*columns).where(studies.c.number == number)).one()
    revision = max(int(kept.get("revision", 0)), before.revision, 0) + total + 1
    change |= {"revision": revision, "taken_back": revision}
    if change["blocks_done"] == total:
        last = connection.execute(
            select(func.max(done_blocks.c.at)).where(done_blocks.c.study == number)
        ).scalar()
        complete = kept.get("state") in ("done", "failed")
        change |= {"state": kept["state"] if complete else "done", "finished": kept.get("finished") or last}
        if not complete:  # the list of marks in the cube is missing, or lacks the last blocks
            put_off_marks(connection, study_id)
    elif restored and kept.get("state") in ("cancelled", "failed"):
        change |= {name: kept.get(name) for name in ("state", "finished", "message")}
    elif restored or before.state == "done":
        change |= {"state": "queued", "finished": None}
    change_studies(connection, [number], change)
