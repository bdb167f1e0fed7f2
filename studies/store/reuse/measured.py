"""What blocks have taken that are done: of a study, and of the latest others of its family."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from sqlalchemy import ColumnElement, or_, select

from damperlab.studies.store.catalogue.rows import ALIVE, record_of
from damperlab.studies.store.catalogue.tables import done_blocks, studies
from damperlab.studies.store.record import Record
from damperlab.studies.store.store import Store

MOST_STUDIES = 8
"""Studies of the family that are looked at, the latest first."""
MOST_BLOCKS = 256
"""Blocks of each, taken evenly from all."""


@dataclass(frozen=True)
class Measured:
    """What blocks of one study have taken.

    Parameters
    ----------
    record : Record
        The study.
    indices : ndarray of int, (N,)
        Its blocks.
    kernel_seconds : ndarray of float, (N,)
        CPU time of each in kernels [s], above 0.
    """

    record: Record
    indices: NDArray[np.int64]
    kernel_seconds: NDArray[np.float64]


def measured_blocks(store: Store, study_id: str) -> list[Measured]:
    """Look up what blocks have taken of a study and of its family whose points were computed, all of them.

    Nothing that is computed depends on these numbers, so damaged ones are left out and not reported.

    Parameters
    ----------
    store : Store
        Where the studies are.
    study_id : str
        One study's whole id.
    """
    c = studies.c
    family = select(c.family).where(c.id == study_id, ALIVE).scalar_subquery()
    return _measured(store, or_((c.family == family) & (c.family != ""), c.id == study_id))


def measured_family(store: Store, family: str) -> list[Measured]:
    """Look up the same of a family, as `damperlab.studies.digest.family_digest` names it; nothing of the empty one."""
    return _measured(store, (studies.c.family == family) & (studies.c.family != ""))


def _measured(store: Store, which: ColumnElement[bool]) -> list[Measured]:
    c, b = studies.c, done_blocks.c
    found = []
    with store.catalogue.reading() as connection:
        query = select(studies).where(which, ALIVE, c.blocks_done > 0)
        for row in connection.execute(query.order_by(c.number.desc()).limit(MOST_STUDIES)).all():
            record = record_of(row)
            every = -(-record.blocks_done // MOST_BLOCKS)
            blocks = select(b.block, b.kernel_seconds).where(
                b.study == row.number, b.block % every == 0, b.reused == 0, b.message.is_(None)
            )
            told = [
                mark
                for mark in connection.execute(blocks)
                if all(isinstance(one, int | float) for one in mark)
            ]
            values = np.array(told, np.float64).reshape(-1, 2)
            known = np.isfinite(values).all(axis=1) & (values[:, 1] > 0.0) & (values[:, 0] < row.blocks_total)
            indices = values[known, 0].astype(np.int64)
            found.append(Measured(record, indices, values[known, 1]))
    return [one for one in found if one.indices.size]
