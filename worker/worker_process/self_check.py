"""Self-check of a worker. The worker computes points with known results, and touches a file after each success."""

import asyncio
from collections.abc import Callable
from pathlib import Path

import numpy as np

from damperlab.studies.definition import Study, parse_study
from damperlab.studies.plan import Block
from damperlab.worker.block import solve_block

EVERY_SECONDS = 10.0
"""Interval between self-checks [s]. Each self-check takes milliseconds."""

_DAMPING_RATIO = 0.0038
_METRIC = "relative_amplitude_ratio"
KNOWN = {
    # without friction, the ratio at r = 1 is 1/(2ζ)
    0.0: 1.0 / (2.0 * _DAMPING_RATIO),
    # eight digits of Den Hartog's exact solution for slip without stops
    0.6: 31.059792,
}
"""Known ratio of the relative amplitude to the base amplitude at r = 1 and ζ = 0.0038, by friction ratio."""
_TOLERANCE = 1e-6


def known_study() -> Study:
    """Return the study of the self-check, which has two points in one block."""
    axes = {"friction_ratio": list(KNOWN), "frequency_ratio": 1.0}
    document = {"particle": False, "damping_ratio": _DAMPING_RATIO, "axes": axes}
    found = parse_study(document)
    assert isinstance(found, Study)
    return found


def wrong_answers(solve: Callable[[Study, Block], dict[str, np.ndarray]] = solve_block) -> str:
    """Compute the points of the self-check, and describe the wrong values; empty if all values are right."""
    study = known_study()
    values = solve(study, Block.whole(study.shape))[_METRIC].ravel()
    wrong = [
        f"{value:.9g} in place of {truth:.9g} at friction ratio {friction:g}"
        for value, (friction, truth) in zip(values, KNOWN.items(), strict=True)
        if not abs(value - truth) <= _TOLERANCE * truth
    ]
    return ", ".join(wrong)


async def show_alive(
    file: Path,
    give_up: Callable[[str], None],
    solve: Callable[[Study, Block], dict[str, np.ndarray]] = solve_block,
) -> None:
    """Repeat the self-check, and touch a file after each success. After a failure, call `give_up` and stop."""
    loop = asyncio.get_running_loop()
    while True:
        # a thread computes, so that this worker can answer requests in the meantime
        wrong = await loop.run_in_executor(None, wrong_answers, solve)
        if wrong:
            give_up(f"it computes wrong values for known points: {wrong}")
            return
        file.touch()
        await asyncio.sleep(EVERY_SECONDS)
