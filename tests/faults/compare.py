"""What must hold of a data directory after a campaign, found without the code that the product would find it with."""

from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from sqlalchemy import Row, select
from tests.faults.attempts import Attempt
from tests.faults.report import Report

from damperlab.studies.definition import Study
from damperlab.studies.plan import Block
from damperlab.studies.store.care.verify import verify
from damperlab.studies.store.catalogue.home import MARKER
from damperlab.studies.store.catalogue.rows import study_row
from damperlab.studies.store.catalogue.tables import done_blocks
from damperlab.studies.store.record import Record
from damperlab.studies.store.store import Store
from damperlab.worker.block import solve_block


def compare(store: Store, record: Record, study: Study, report: Report) -> None:
    """Compare one ended study with what one undisturbed process computes in one piece; run times aside."""
    report.blocks += record.blocks_total
    report.counts_wrong += not _sums_agree(store, record)
    report.damaged_blocks += sum(1 for _ in verify(store, record))
    cube = store.cube(record.id)
    whole = solve_block(study, Block.whole(study.shape))
    report.unequal_variables += sum(
        name != "run_time" and cube[name].values.tobytes() != np.asarray(values).tobytes()
        for name, values in whole.items()
    )


def run_again(store: Store, record: Record, attempts: Iterable[Attempt]) -> int:
    """Count attempts at blocks of a study that began after the block had its done-mark."""
    marked = {row.block: row for row in _marks(store, record)}
    return sum(
        attempt.digest == record.digest
        and attempt.block in marked
        and attempt.generation != marked[attempt.block].generation
        and attempt.began > marked[attempt.block].at
        for attempt in attempts
    )


def _marks(store: Store, record: Record) -> Sequence[Row[Any]]:
    with store.catalogue.reading() as connection:
        number = study_row(connection, record.id).number
        return connection.execute(select(done_blocks).where(done_blocks.c.study == number)).all()


def _sums_agree(store: Store, record: Record) -> bool:
    rows = _marks(store, record)
    return (len(rows), sum(row.points for row in rows), sum(row.failed for row in rows)) == (
        record.blocks_done,
        record.points_done,
        record.points_failed,
    ) and record.points_done == record.points_total


def unexpected_files(store: Store) -> int:
    """Count by hand, without the code that sweeps: one file for each done block, and no others."""
    found: dict[str, Counter[str]] = {}
    for entry in store.shelf.entries():
        cube, _, key = entry.key.partition("/")
        folder, _, name = key.partition("/")
        if key and folder != "blocks":
            continue  # a cube's description, its coordinates and its marks
        found.setdefault(cube, Counter())[name.partition("~")[0] if key else entry.key] += 1
    # whose the cubes are
    found = {cube: names for cube, names in found.items() if cube != MARKER}
    extra = 0
    for record in store.page(limit=1000).records:
        names = found.pop(Path(store.cube_path(record.id)).name, Counter())
        expected = record.blocks_done
        extra += abs(names.total() - expected) + names.total() - len(names)
    return extra + sum(names.total() for names in found.values())
