"""Are stated standard errors honest? Responses that do not repeat, against far longer runs on the same attractor.

A point is covered where its long-run mean lies within 1.96 of its stated errors: a 95 % interval. Run with
`python -m tests.benchmarks coverage`.
"""

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from tests.worker.designs_drawn import SETTINGS, Point, drawn_points
from tests.worker.plain_march import march_plainly

from damperlab.studies.variables import ResponseClass
from damperlab.worker.solver.state import ARRIVED
from damperlab.worker.steady.response import Response

HALF_WIDTH = 1.96
"""Stated errors on either side of a 95 % interval."""

_LONGEST_PERIOD = 32


class Compared(NamedTuple):
    """One modulated point and its truth.

    Attributes
    ----------
    point : Point
    response : Response
    truth : float
        Mean cycle peak of the long run that goes on where the response was measured.
    repeats : bool
        Whether that long run ended in a periodic motion: what was measured was a long transient.
    """

    point: Point
    response: Response
    truth: float
    repeats: bool

    @property
    def deviation(self) -> float:
        """Distance from the truth in stated errors."""
        return (self.response.amplitude_ratio - self.truth) / self.response.amplitude_error

    @property
    def covered(self) -> bool:
        """Whether the 95 % interval holds the truth."""
        return abs(self.deviation) <= HALF_WIDTH


def compared(count: int, seed: int, times: int) -> Iterator[Compared]:
    """The first points of a draw whose response does not repeat, each against a run of `times` the cycle limit."""
    peaks = np.empty((times * SETTINGS.max_cycles, 2))
    for point in drawn_points(seed, near_resonance=True, damping=(0.0038, 0.0038, 0.01, 0.03)):
        if count == 0:
            return
        response, end = point.solve()
        if response.response_class not in (ResponseClass.MODULATED, ResponseClass.CHAOTIC):
            continue
        _, outcome = march_plainly(*point, end, 0, peaks)
        if outcome == ARRIVED:
            yield Compared(point, response, float(peaks[:, 0].mean()), _repeats(peaks[-400:, 0]))
            count -= 1


def _repeats(peaks: NDArray[np.float64]) -> bool:
    scale = 1e-6 * float(peaks.max())
    return any(np.abs(peaks[lag:] - peaks[:-lag]).max() <= scale for lag in range(1, _LONGEST_PERIOD + 1))


def run(count: int = 100, times: int = 50) -> dict[str, Any]:
    """Coverage of two draws of `count` points; the truth of each takes `times` the cycle limit."""
    figures: dict[str, Any] = {}
    for seed in (1, 2):
        points = list(compared(count, seed, times))
        figures[f"draw {seed}: points"] = len(points)
        figures[f"draw {seed}: 95 % interval holds the truth"] = sum(one.covered for one in points)
        figures[f"draw {seed}: within one error"] = sum(abs(one.deviation) <= 1.0 for one in points)
        figures[f"draw {seed}: transients that ended later"] = sum(one.repeats for one in points)
        worst = sorted((one for one in points if not one.covered), key=lambda one: -abs(one.deviation))
        figures[f"draw {seed}: missed, in errors"] = [round(one.deviation, 2) for one in worst]
    return figures
