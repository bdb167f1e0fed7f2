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
from damperlab.studies.store.coding import coordinate_key, describe_cube
from damperlab.studies.store.cube import block_grid
from damperlab.studies.store.faults import StoreFault, StudyNotFound, cannot_use
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
            connection.execute(insert(studies).values({**row._asdict(), **free}))
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
    grid = block_grid(record.shape, record.chunk)
    try:
        metadata = here.get("zarr.json")
        described = describe_cube(metadata)
        first = [f"{name}/zarr.json" for name in (*described.arrays, *described.coordinates)]
        first += [coordinate_key(name) for name in described.coordinates]
        first += parse_study(record.definition).attached
        found = {"zarr.json": metadata, **{key: here.get(key) for key in first}}
    except (OSError, ValueError) as error:
        raise damaged(here, None, "zarr.json", str(error)) from error
    size = 0
    try:
        there.clear()
        there.fill(found)
        for mark in marks:
            place = [int(at) for at in np.unravel_index(mark.block, grid)]
            files = {}
            for variable in described.arrays:
                key = chunk_file(chunk_key(variable, place), mark.generation)
                files[key] = _chunk(here, key, mark.block, variable)
            there.put_all(files)
            size += sum(map(len, files.values()))
    except OSError as error:
        raise cannot_use(there.address, error) from error
    return size


def _chunk(shelf: Shelf, key: str, block: int, variable: str) -> bytes:
    try:
        return shelf.get(key)
    except FileNotFoundError as error:
        raise damaged(shelf, block, variable, "its file is lost") from error
    except OSError as error:
        raise cannot_use(shelf.address, error) from error
