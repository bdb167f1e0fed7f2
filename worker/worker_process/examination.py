"""Tests before a worker computes for a study: its code, its access to the data, and a few points."""

import hashlib
from collections import Counter
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from damperlab.studies.kind import AnyStudy
from damperlab.studies.plan import Block, Plan
from damperlab.studies.variables import Status
from damperlab.worker.provenance import computing, require_code
from damperlab.worker.worker_process.tasks import solve_stored

POINTS = 3
"""Number of points that every worker computes before its first block; for a continuation they are one row."""
_MEASURED = ("run_time",)


@dataclass(frozen=True)
class Answer:
    """A worker's answer.

    Parameters
    ----------
    facts : dict of str
        What `computing()` gives at the worker.
    bits : str
        Bits of the requested points, see `bits_of`; empty if none were requested.
    """

    facts: dict[str, str]
    bits: str


def examine(cube_path: str, digest: str, code: str, canary: Block | None) -> Answer:
    """Report this worker's solver, after reading the study from its cube. A Dask task calls this function.

    Parameters
    ----------
    cube_path, digest, code : str
        As for `damperlab.worker.worker_process.tasks.run_block`.
    canary : Block, optional
        A few points to compute.

    Raises
    ------
    WrongCode
        If this worker's sources differ from the coordinator's.
    OSError
        If the cube cannot be read.
    """
    require_code(code)
    try:
        values = solve_stored(cube_path, digest, canary)
        bits = "" if values is None else bits_of(values)
    except OSError:
        raise
    except Exception as error:
        # this is an answer like others: if all workers give it, the points are the cause
        bits = f"raises {type(error).__name__}: {error}"
    return Answer(computing(), bits)


def canary_of(plan: Plan, block: int) -> Block:
    """Choose points of a block that are cheap to compute.

    Parameters
    ----------
    plan : Plan
        Plan of the study.
    block : int
        Index of the block.

    Returns
    -------
    Block
        A box in its first corner: few points along the last dimension, or one complete row if it must not be
        divided.
    """
    box = plan.block(block)
    points = box.shape[-1] if plan.study.whole_rows else min(box.shape[-1], POINTS)
    return Block(box.index, box.start, (*(1 for _ in box.shape[:-1]), points))


def bits_of(values: Mapping[str, Any]) -> str:
    """Hash every bit of some values, except measured times; 16 hex digits."""
    digest = hashlib.sha256()
    for name in sorted(set(values) - set(_MEASURED)):
        digest.update(f"{name}\n".encode())
        digest.update(np.ascontiguousarray(values[name]).tobytes())
    return digest.hexdigest()[:16]


def stored_bits(cube: Any, study: AnyStudy, canary: Block, names: Collection[str]) -> str:
    """Hash the stored results of some points in the same way as `bits_of` does for a worker's.

    Empty if a point has no computed result: its block failed, or its file is missing, or is removed meanwhile.

    Parameters
    ----------
    cube : Dataset
        Cube of the study.
    study : AnyStudy
        The study.
    canary : Block
        Points of a block that is done.
    names : collection of str
        Names of the stored variables.
    """
    where = dict(zip(study.coordinates, canary.slices, strict=True))

    def known() -> bool:
        status = cube["status"].isel(where).values
        return bool(((status >= 0) & (status < Status.BLOCK_FAILED)).all())

    if not known():
        return ""
    bits = bits_of({name: cube[name].isel(where).values for name in names})
    return bits if known() else ""


def majority(answers: Mapping[str, str]) -> str | None:
    """Give the answer of a majority; None if there is none.

    Parameters
    ----------
    answers : mapping
        Answers by worker; a single one counts as a majority.
    """
    if not answers:
        return None
    answer, count = Counter(answers.values()).most_common(1)[0]
    return answer if 2 * count > len(answers) else None
