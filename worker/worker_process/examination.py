"""Before a worker computes for a study: its code, its way to the data, and a few points whose bits are known."""

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
"""Points that every worker computes before its first block; those of a continuation are one row."""
_MEASURED = ("run_time",)


@dataclass(frozen=True)
class Answer:
    """What a worker answers.

    Parameters
    ----------
    facts : dict of str
        Its `computing()`.
    bits : str
        Of the points that it was asked for, see `bits_of`; empty where none were asked for.
    """

    facts: dict[str, str]
    bits: str


def examine(cube_path: str, digest: str, code: str, canary: Block | None) -> Answer:
    """Say what this worker computes with, having read the study at its place; the value of a Dask task.

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
        # where all do the same it is the points' doing, and an answer like others
        bits = f"raises {type(error).__name__}: {error}"
    return Answer(computing(), bits)


def canary_of(plan: Plan, block: int) -> Block:
    """Choose points of a block that are cheap to compute.

    Parameters
    ----------
    plan : Plan
        Of the study.
    block : int
        Index of the block.

    Returns
    -------
    Block
        A box in its first corner: few points along the last dimension, or one row of what must stay whole.
    """
    box = plan.block(block)
    points = box.shape[-1] if plan.study.whole_rows else min(box.shape[-1], POINTS)
    return Block(box.index, box.start, (*(1 for _ in box.shape[:-1]), points))


def bits_of(values: Mapping[str, Any]) -> str:
    """Hash every bit of some values, but what was measured; 16 hex digits."""
    digest = hashlib.sha256()
    for name in sorted(set(values) - set(_MEASURED)):
        digest.update(f"{name}\n".encode())
        digest.update(np.ascontiguousarray(values[name]).tobytes())
    return digest.hexdigest()[:16]


def stored_bits(cube: Any, study: AnyStudy, canary: Block, names: Collection[str]) -> str:
    """Hash the stored answer of some points as `bits_of` does a worker's.

    Empty where one of them has no computed result: its block was given up, or its file is not there, or goes meanwhile.

    Parameters
    ----------
    cube : Dataset
        The study's.
    study : AnyStudy
        The study.
    canary : Block
        Points of a block that is done.
    names : collection of str
        What is stored.
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
    """Give what most answer, and more than half; None where there is no such answer.

    Parameters
    ----------
    answers : mapping
        By who gave them; one alone is believed.
    """
    if not answers:
        return None
    answer, count = Counter(answers.values()).most_common(1)[0]
    return answer if 2 * count > len(answers) else None
