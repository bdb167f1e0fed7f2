"""Backup of a store. The copy is consistent even if studies run meanwhile.

A backup is a data directory, too. Files are copied first; then one transaction writes all rows of the catalogue. So an
interrupted backup contains no study without its files.
"""

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from sqlalchemy import Row, delete, insert, select

from damperlab.studies.design.shelf import DESIGNS, REQUEST
from damperlab.studies.design.shelf import Shelf as Designs
from damperlab.studies.ground.shelf import Shelf as Records
from damperlab.studies.store.catalogue.home import (
    BACKUP_OF,
    catalogue_id,
    cube_name,
    fact,
    forget,
    parse_cube_name,
    remember,
)
from damperlab.studies.store.catalogue.rows import (
    ALIVE,
    advance_counters,
    record_of,
    rows_of_marks,
    study_row,
)
from damperlab.studies.store.catalogue.tables import done_blocks, events, keys, studies
from damperlab.studies.store.cube.block_file import BLOCKS, block_key, read_whole
from damperlab.studies.store.cube.definition import parse_stored
from damperlab.studies.store.cube.description import DESCRIPTION, Description, describe_cube
from damperlab.studies.store.faults import (
    BlockDamaged,
    CatalogueDamaged,
    StoreFault,
    StudyNotFound,
    reporting_damage,
    using,
)
from damperlab.studies.store.files.folder import Folder
from damperlab.studies.store.files.shelf import Shelf
from damperlab.studies.store.life_cycle.manifest import keep_marks
from damperlab.studies.store.record import Record
from damperlab.studies.store.store import Store
from damperlab.studies.vocabulary import ENDED

RECORDS = "records"
"""Name of the folder of the uploaded ground-motion records in the data directory."""

_Copy = tuple[Row[Any], Sequence[Row[Any]], int]
"""Row of a study, rows of the study's done-marks, and number of copied bytes."""


@dataclass(frozen=True)
class Copied:
    """Content of a backup.

    Parameters
    ----------
    studies, blocks : int
        Number of studies and of blocks in the backup.
    bytes : int
        Number of bytes that this backup copied.
    damaged : tuple of str
        One message for each damaged item that could not be copied. The target keeps an earlier copy of the item.
    """

    studies: int
    blocks: int
    bytes: int
    damaged: tuple[str, ...] = ()


def copy_store(source: Store, target: Store, *, for_good: bool = False) -> Copied:
    """Copy every study with its done blocks, the idempotency keys, the events, the uploaded records and the designs.

    A study that is running in the source is queued in the copy. If the target is an earlier backup of the same store,
    only new files are copied. Every copied file is compared with its checksums. A damaged study is reported, and the
    target keeps the earlier copy of this study. An interrupted backup can be repeated.

    Parameters
    ----------
    source : Store
        The store to copy, which may be in use.
    target : Store
        A store without studies, or an earlier backup of `source` to which no study was submitted.
    for_good : bool
        Whether the copy becomes an independent store, which no later backup can update.

    Returns
    -------
    Copied
        The content of the backup, and the number of copied bytes.

    Raises
    ------
    StoreFault
        If the target contains studies of another store or studies that the source has lost, or if a file
        cannot be written.
    """
    mine = catalogue_id(source.catalogue)
    _require_target(source, target, mine)
    _require_nothing_lost(source, target)
    with target.catalogue.writing() as connection:
        remember(connection, BACKUP_OF, mine)
    records, damaged_records = _copy_records(source, target)
    designs, damaged_designs = _copy_designs(source, target)
    with source.catalogue.reading() as connection:
        ids = connection.execute(select(studies.c.id).where(ALIVE).order_by(studies.c.number)).scalars().all()
    copies: list[_Copy] = []
    damages = [*damaged_records, *damaged_designs]
    for study_id in ids:
        try:
            copy = _copy_study(source, target, study_id)
        except (BlockDamaged, CatalogueDamaged) as error:
            damages.append(str(error))
            copy = _earlier(source, target, study_id)
        if copy is not None:
            copies.append(copy)
    with source.catalogue.reading() as connection:
        kept = {
            table: [row._asdict() for row in connection.execute(select(table))] for table in (keys, events)
        }
    with target.catalogue.writing() as connection:
        for table in (done_blocks, studies, keys, events):
            connection.execute(delete(table))
        for row, marks, _ in copies:
            state = "queued" if row.state == "running" else row.state
            free = {"state": state, "claim_owner": None, "claim_expires": None}
            connection.execute(insert(studies).values({**row._asdict(), **free, "crc": None}))
            if marks:
                connection.execute(insert(done_blocks), [mark._asdict() for mark in marks])
        for table, rows in kept.items():
            if rows:
                connection.execute(insert(table), rows)
        advance_counters(connection)
        if for_good and not damages:
            forget(connection, BACKUP_OF)
    with using(target.shelf.address):
        for row, _, _ in copies:
            if row.state in ENDED:
                keep_marks(target, row.id, {})
        # remove the cubes of studies that were deleted in the source after the earlier backup
        names = {cube_name(row.id, row.number) for row, _, _ in copies}
        for name in list(target.shelf.shelves()):
            if parse_cube_name(name) and name not in names:
                target.shelf.at(name).clear()
    size = records + designs + sum(size for _, _, size in copies)
    return Copied(len(copies), sum(len(marks) for _, marks, _ in copies), size, tuple(damages))


def _require_target(source: Store, target: Store, mine: str) -> None:
    with target.catalogue.reading() as connection:
        other = fact(connection, BACKUP_OF)
        held = set(connection.execute(select(studies.c.id, studies.c.number)).all())
    if other != mine and (held or other is not None):
        with source.catalogue.reading() as connection:
            given = set(connection.execute(select(studies.c.id, studies.c.number).where(ALIVE)).all())
        if given == held:
            told = f"{target.data_dir} holds these studies already."
            raise StoreFault(
                "data_dir",
                f"{target.data_dir}, which holds these studies already",
                "a data directory without studies",
                "use this folder as it is, or name another folder",
                told,
            )
        raise StoreFault(
            "data_dir",
            f"{target.data_dir}, which holds other studies",
            "a data directory without studies, or an earlier backup of the same data directory",
            "name another folder",
            f"{target.data_dir} holds other studies; a backup goes into a folder without studies, or into an earlier "
            "backup of the same data directory.",
        )


def _require_nothing_lost(source: Store, target: Store) -> None:
    """Raise `StoreFault` if the target contains studies that the source does not have and has never deleted."""
    with source.catalogue.reading() as connection:
        rows = connection.execute(select(studies.c.id, studies.c.number)).all()
    known = {cube_name(row.id, row.number) for row in rows}
    with using(target.shelf.address):
        held = sorted(target.shelf.shelves())
    lost = [name for name in held if parse_cube_name(name) and name not in known]
    if lost:
        place = f"{target.shelf.address}/{lost[0]}"
        more = f" and {len(lost) - 1} more" if len(lost) > 1 else ""
        raise StoreFault(
            "data_dir",
            f"{place}{more}, which {source.data_dir} has lost: it has neither the study nor a record of "
            "its deletion",
            "a backup whose studies all exist in the source or were deleted there",
            f"copy the folder into {source.shelf.address} and run `damperlab store rebuild` to have the study again; else "
            "back up into a new folder",
            f"The backup holds {place}{more}, which {source.data_dir} has lost; it would be removed from the backup.",
        )


def _copy_records(source: Store, target: Store) -> tuple[int, list[str]]:
    """Copy the uploaded records. Return the number of copied bytes, and a message for each damaged record."""
    here, there = source.data_dir / RECORDS, target.data_dir / RECORDS
    damaged_records = dict(Records(source.data_dir).damaged())
    size = 0
    with using(str(there)):
        for file in sorted(here.iterdir()) if here.is_dir() else ():
            if not file.is_file() or file.stem in damaged_records:
                continue
            content = file.read_bytes()
            copy = there / file.name
            if copy.is_file() and copy.read_bytes() == content:
                continue
            there.mkdir(parents=True, exist_ok=True)
            Folder(there).put(file.name, content)
            size += len(content)
    return size, list(damaged_records.values())


def _copy_designs(source: Store, target: Store) -> tuple[int, list[str]]:
    """Copy the designs. Return the number of copied bytes, and a message for each damaged design."""
    here, there = Designs(source.data_dir), Designs(target.data_dir)
    damaged_designs = dict(here.damaged())
    size = 0
    with using(str(target.data_dir / DESIGNS)):
        for design_id in sorted(here.ids() - damaged_designs.keys()):
            pieces = here.pieces(design_id)
            if REQUEST in pieces:  # otherwise the design was deleted meanwhile
                size += there.take_over(design_id, pieces)
    return size, list(damaged_designs.values())


def _earlier(source: Store, target: Store, study_id: str) -> _Copy | None:
    """Return the rows of a damaged study from an earlier backup; None if that backup does not contain the study."""
    with source.catalogue.reading() as connection:
        number = connection.execute(select(studies.c.number).where(studies.c.id == study_id, ALIVE)).scalar()
    with target.catalogue.reading() as connection:
        row = connection.execute(
            select(studies).where(studies.c.id == study_id, studies.c.number == number, ALIVE)
        ).one_or_none()
        if row is None:
            return None
        marks = rows_of_marks(connection, row.number)
    return row, marks, 0


def _copy_study(source: Store, target: Store, study_id: str) -> _Copy | None:
    def copy() -> _Copy:
        with source.catalogue.reading() as connection:
            row = study_row(connection, study_id)
            marks = rows_of_marks(connection, row.number)
        return row, marks, _copy_files(source, target, row, marks)

    try:
        return source.steadily([study_id], copy)
    except StudyNotFound:
        return None  # the study was deleted meanwhile


def _copy_files(source: Store, target: Store, row: Row[Any], marks: Sequence[Row[Any]]) -> int:
    record = record_of(row)
    here, there = source.cube_shelf(row.id, row.number), target.cube_shelf(row.id, row.number)
    described, found = _description(here, record)
    size = 0
    with using(there.address):
        sizes = {entry.key: entry.size for entry in here.entries()}
        # a file of the earlier backup is not copied again if it has the same size as the file in the source
        have = {entry.key for entry in there.entries() if entry.size == sizes.get(entry.key)}
        there.fill(found, (BLOCKS,))
        for mark in marks:
            key = block_key(mark.block, mark.generation)
            if key not in have:
                with reporting_damage(here, mark.block, key):
                    _, content = read_whole(here, described, mark.block, mark.generation)
                there.put(key, content)
                size += len(content)
    return size


def _description(shelf: Shelf, record: Record) -> tuple[Description, dict[str, bytes]]:
    """Read all files of a cube except the blocks, and check that the files are intact."""
    with reporting_damage(shelf, None, "the cube's description"):
        metadata = shelf.get(DESCRIPTION)
        described = describe_cube(metadata)
        if described.digest != record.digest:
            raise ValueError(f"it describes study {described.digest[:12]}")
    found = {DESCRIPTION: metadata}
    for one in described.coordinates.values():
        if one.value is None:
            with reporting_damage(shelf, None, f"the coordinates along {one.name}"):
                found[one.key] = shelf.get(one.key)
                one.decode(found[one.key])
    for key, sha256 in parse_stored(record.definition, record.digest).attached.items():
        with reporting_damage(shelf, None, key):
            found[key] = shelf.get(key)
            if hashlib.sha256(found[key]).hexdigest() != sha256:
                raise ValueError("it is not as it was written")
    return described, found
