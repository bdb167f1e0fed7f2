"""A copy of a store that is consistent while studies run: what the catalogue says at one moment, and its files.

A backup is a data directory like any other. Files are copied before the catalogue's rows are written, and those
in one transaction: a backup that was cut short holds no study, and never a study without its files.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from sqlalchemy import Row, func, insert, select, text

from damperlab.studies.definition import parse_study
from damperlab.studies.faults import Fault
from damperlab.studies.store.chunks import chunk_file, chunk_key, damaged
from damperlab.studies.store.description import DESCRIPTION, Description, describe_cube
from damperlab.studies.store.faults import StoreFault, StudyNotFound, cannot_use
from damperlab.studies.store.manifest import keep_marks
from damperlab.studies.store.packed import BLOCKS, block_key
from damperlab.studies.store.rows import ALIVE, record_of
from damperlab.studies.store.shelf import Shelf
from damperlab.studies.store.store import Store
from damperlab.studies.store.tables import done_blocks, events, keys, studies

_AT_ONCE = 1000  # rows in one statement
_TRIES = 5  # at a study whose blocks are taken back while it is copied


@dataclass(frozen=True)
class Copied:
    """What a backup holds.

    Parameters
    ----------
    studies, blocks, bytes : int
        Counts.
    """

    studies: int
    blocks: int
    bytes: int


def copy_store(source: Store, target: Store) -> Copied:
    """Copy every study with its done blocks, the keys and the events into an empty store.

    Studies that run are queued in the copy, with the blocks that they have; nobody holds a claim there.

    Parameters
    ----------
    source : Store
        May be in use.
    target : Store
        Holds no study yet.

    Returns
    -------
    Copied
        What was copied.

    Raises
    ------
    StoreFault
        If the target holds studies, a file cannot be written, or a block of the source is damaged.
    """
    if target.page(limit=1).records:
        raise StoreFault(
            Fault(
                "data_dir",
                f"{target.data_dir}, which holds studies",
                "a data directory without studies",
                "name another folder",
            )
        )
    with source.catalogue.reading() as connection:
        ids = connection.execute(select(studies.c.id).where(ALIVE).order_by(studies.c.number)).scalars().all()
    copies = [copy for study_id in ids if (copy := _copy_study(source, target, study_id)) is not None]
    with source.catalogue.reading() as connection:
        kept = {
            table: [row._asdict() for row in connection.execute(select(table))] for table in (keys, events)
        }
    with target.catalogue.writing() as connection:
        for row, marks, _ in copies:
            state = "queued" if row.state == "running" else row.state
            free = {"state": state, "claim_owner": None, "claim_expires": None}
            connection.execute(insert(studies).values({**row._asdict(), **free, "crc": None}))
            for start in range(0, len(marks), _AT_ONCE):
                connection.execute(
                    insert(done_blocks), [mark._asdict() for mark in marks[start : start + _AT_ONCE]]
                )
        for table, rows in kept.items():
            for start in range(0, len(rows), _AT_ONCE):
                connection.execute(insert(table), rows[start : start + _AT_ONCE])
        if connection.dialect.name == "postgresql":
            for table in (studies, events):
                # its counters do not learn from numbers that were given
                last = select(func.max(table.c.number)).scalar_subquery()
                counter = func.pg_get_serial_sequence(text(f"'{table.name}'"), text("'number'"))
                connection.execute(select(func.setval(counter, func.coalesce(last, 1))))
    for row, _, _ in copies:
        if row.state in ("done", "cancelled", "failed"):
            try:
                keep_marks(target, row.id, {})
            except OSError as error:
                raise cannot_use(target.shelf.address, error) from error
    return Copied(len(copies), sum(len(marks) for _, marks, _ in copies), sum(size for _, _, size in copies))


def _copy_study(
    source: Store, target: Store, study_id: str
) -> tuple[Row[Any], Sequence[Row[Any]], int] | None:
    for last in range(1, _TRIES + 1):
        with source.catalogue.reading() as connection:
            row = connection.execute(select(studies).where(studies.c.id == study_id, ALIVE)).one_or_none()
            if row is None:
                return None  # deleted meanwhile
            marks = connection.execute(select(done_blocks).where(done_blocks.c.study == row.number)).all()
        try:
            return row, marks, _copy_files(source, target, row, marks)
        except StoreFault:
            try:
                same = source.find(study_id).revision == row.revision
            except StudyNotFound:
                return None
            if same or last == _TRIES:
                raise
    raise AssertionError("unreachable")


def _copy_files(source: Store, target: Store, row: Row[Any], marks: Sequence[Row[Any]]) -> int:
    record = record_of(row)
    here, there = source.cube_shelf(row.id, row.number), target.cube_shelf(row.id, row.number)
    try:
        metadata = here.get(DESCRIPTION)
        described = describe_cube(metadata)
        first = (*described.pieces[1:], *parse_study(record.definition).attached)
        found = {DESCRIPTION: metadata, **{key: here.get(key) for key in first}}
    except (OSError, ValueError) as error:
        raise damaged(here, None, "its description", str(error)) from error
    size = 0
    try:
        there.clear()
        there.fill(found, (BLOCKS,) if described.packed else ())
        for mark in marks:
            files = {key: _piece(here, key, mark.block) for key in block_files(described, mark)}
            there.put_all(files)
            size += sum(map(len, files.values()))
    except OSError as error:
        raise cannot_use(there.address, error) from error
    return size


def block_files(described: Description, mark: Row[Any]) -> list[str]:
    """Give the keys of a block's files."""
    if described.packed:
        return [block_key(mark.block, mark.generation)]
    place = [int(at) for at in np.unravel_index(mark.block, described.grid)]
    return [chunk_file(chunk_key(variable, place), mark.generation) for variable in described.arrays]


def _piece(shelf: Shelf, key: str, block: int) -> bytes:
    try:
        return shelf.get(key)
    except FileNotFoundError as error:
        raise damaged(shelf, block, key, "its file is lost") from error
    except OSError as error:
        raise cannot_use(shelf.address, error) from error
