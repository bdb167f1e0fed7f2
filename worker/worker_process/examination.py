"""Test of a worker before its first block. The test compares the code, reads the data and computes a few points."""

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
"""Number of points in the test of a worker. In a continuation study, the test has one row of points instead."""
_MEASURED = ("run_time",)


@dataclass(frozen=True)
class Answer:
    """Result of the test of a worker.

    Parameters
    ----------
    facts : dict of str
        Result of `computing()` at the worker.
    bits : str
        Hash of the results at the requested points, see `bits_of`; empty if no points were requested.
    """

    facts: dict[str, str]
    bits: str


def examine(cube_path: str, digest: str, code: str, canary: Block | None) -> Answer:
    """Read a study from its cube at a worker, compute a few points, and return the result of this test.

    Parameters
    ----------
    cube_path, digest, code : str
        Arguments of `damperlab.worker.worker_process.tasks.run_block`.
    canary : Block, optional
        Points to compute.

    Returns
    -------
    Answer
        This worker's solver, and the hash of the points' results. If the computation raises an exception, a description
        of the exception replaces the hash.

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
        # the answer contains the exception: if all workers give the same answer, the points are the cause
        bits = f"raises {type(error).__name__}: {error}"
    return Answer(computing(), bits)


def canary_of(plan: Plan, block: int) -> Block:
    """Choose a few points of a block as a test of the workers.

    The test has the first `POINTS` points along the last dimension, at the first index of all other dimensions. If the
    rows of the study must not be divided, the test has the complete row.
    """
    box = plan.block(block)
    points = box.shape[-1] if plan.study.whole_rows else min(box.shape[-1], POINTS)
    return Block(box.index, box.start, (*(1 for _ in box.shape[:-1]), points))


def bits_of(values: Mapping[str, Any]) -> str:
    """Return a hash of all values except measured times, as 16 hexadecimal digits."""
    digest = hashlib.sha256()
    for name in sorted(set(values) - set(_MEASURED)):
        digest.update(f"{name}\n".encode())
        digest.update(np.ascontiguousarray(values[name]).tobytes())
    return digest.hexdigest()[:16]


def stored_bits(cube: Any, study: AnyStudy, canary: Block, names: Collection[str]) -> str:
    """Return the hash of the stored results of some variables at points of a block that is done, see `bits_of`.

    The hash is empty if the result of a point is missing, because its block failed or its file was removed.
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
    """Return the answer that more than half of the workers give; None if there is no such answer."""
    if not answers:
        return None
    answer, count = Counter(answers.values()).most_common(1)[0]
    return answer if 2 * count > len(answers) else None
