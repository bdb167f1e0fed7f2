"""Self-check of a worker: it computes points with known values, and the time of a file shows the last success."""

import asyncio
from collections.abc import Callable
from pathlib import Path

import numpy as np

from damperlab.studies.definition import Study, parse_study
from damperlab.studies.plan import Block
from damperlab.worker.block import solve_block

EVERY_SECONDS = 10.0
"""Interval between computations of the known block, which take milliseconds."""

_DAMPING_RATIO = 0.0038
_METRIC = "relative_amplitude_ratio"
KNOWN = {
    # at r = 1 without friction it is 1/(2ζ)
    0.0: 1.0 / (2.0 * _DAMPING_RATIO),
    # Den Hartog's exact solution of slip without stops, eight digits
    0.6: 31.059792,
}
"""Relative amplitude over that of the base at r = 1 and ζ = 0.0038, by the friction ratio."""
_TOLERANCE = 1e-6


def known_study() -> Study:
    """Give the study of the known block: one block, two points."""
    axes = {"friction_ratio": list(KNOWN), "frequency_ratio": 1.0}
    document = {"particle": False, "damping_ratio": _DAMPING_RATIO, "axes": axes}
    found = parse_study(document)
    assert isinstance(found, Study)
    return found


def wrong_answers(solve: Callable[[Study, Block], dict[str, np.ndarray]] = solve_block) -> str:
    """Compute the known block; describe wrong values, or return an empty text.

    Parameters
    ----------
    solve : callable
        Computes a block.
    """
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
    tell: Callable[[str], None],
    solve: Callable[[Study, Block], dict[str, np.ndarray]] = solve_block,
) -> None:
    """Touch a file as long as the known block is right; otherwise call `tell` with the error."""
    loop = asyncio.get_running_loop()
    while True:
        # in a thread, so that this worker answers requests meanwhile
        wrong = await loop.run_in_executor(None, wrong_answers, solve)
        if wrong:
            tell(f"it computes wrong values for known points: {wrong}")
            return
        file.touch()
        await asyncio.sleep(EVERY_SECONDS)
