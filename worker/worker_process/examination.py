"""Tests of a worker.

Before its first block, a worker reads the study and computes a few points. Later, the worker checks itself.
"""

import asyncio
import hashlib
from collections import Counter
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from damperlab.studies.definition import Study, parse_study
from damperlab.studies.kind import AnyStudy
from damperlab.studies.plan import Block, Plan
from damperlab.studies.variables import Status
from damperlab.worker.block import solve_block
from damperlab.worker.provenance import computing, require_code
from damperlab.worker.worker_process.tasks import solve_stored

POINTS = 3
"""Number of points in the test of a worker. In a continuation study, the test has one row of points instead."""
_MEASURED = ("run_time",)

EVERY_SECONDS = 10.0
"""Interval between self-checks [s]. Each self-check takes milliseconds."""

_DAMPING_RATIO = 0.0038
KNOWN = {
    # without friction, the ratio at r = 1 is 1/(2ζ)
    0.0: 1.0 / (2.0 * _DAMPING_RATIO),
    # eight digits of Den Hartog's exact solution for slip without stops
    0.6: 31.059792,
}
"""Known ratio of the relative amplitude to the base amplitude at r = 1 and ζ = 0.0038, by friction ratio."""
_TOLERANCE = 1e-6


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
        # the exception is part of the answer: if it is the same at all workers, the points are the cause
        bits = f"raises {type(error).__name__}: {error}"
    return Answer(computing(), bits)


def canary_of(plan: Plan, block: int) -> Block:
    """Choose a few points of a block as a test of the workers.

    The test has the first `POINTS` points along the last dimension, at the first index of all other dimensions. If
    the study's property `whole_rows` is true, the test has the complete row.
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
    """Return the hash `bits_of` of the variables `names`, as stored at the points `canary` of a done block.

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


def wrong_answers() -> str:
    """Compute the points of the self-check; return a text that lists the wrong values, empty if none."""
    axes = {"friction_ratio": list(KNOWN), "frequency_ratio": 1.0}
    study = parse_study({"particle": False, "damping_ratio": _DAMPING_RATIO, "axes": axes})
    assert isinstance(study, Study)
    values = solve_block(study, Block.whole(study.shape))["relative_amplitude_ratio"].ravel()
    wrong = [
        f"{value:.9g} in place of {truth:.9g} at friction ratio {friction:g}"
        for value, (friction, truth) in zip(values, KNOWN.items(), strict=True)
        if not abs(value - truth) <= _TOLERANCE * truth
    ]
    return ", ".join(wrong)


async def show_alive(file: Path, give_up: Callable[[str], None]) -> None:
    """Repeat the self-check, and touch a file after each success. After a failure, call `give_up` and stop."""
    loop = asyncio.get_running_loop()
    while True:
        # a thread computes, so that this worker can answer requests in the meantime
        wrong = await loop.run_in_executor(None, wrong_answers)
        if wrong:
            give_up(f"it computes wrong values for known points: {wrong}")
            return
        file.touch()
        await asyncio.sleep(EVERY_SECONDS)
