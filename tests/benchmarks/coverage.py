"""Are stated standard errors honest? Responses that do not repeat, against far longer runs on the same attractor.

The runs stop where the default tolerance lets them: a rule for stopping can bias what it stops. A point is covered where its
long-run mean lies within 1.96 of its stated errors: a 95 % interval. Run with `python -m tests.benchmarks coverage`.
"""

from collections.abc import Iterator
from itertools import islice
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.variables import ResponseClass, Status
from damperlab.worker.accuracy.march import march_halves
from damperlab.worker.accuracy.steady_answers import HALF_WIDTH, SETTINGS, Point, points
from damperlab.worker.solver.events import ARRIVED
from damperlab.worker.steady.response.measures import Response
from damperlab.worker.steady.response.standard_errors import mean_and_error
from damperlab.worker.steady.settle import settle

_LONGEST_PERIOD = 64  # half cycles


class Compared(NamedTuple):
    """One modulated point and its truth.

    Attributes
    ----------
    point : Point
    response : Response
    truth, error : float
        Mean peak of the long run that goes on where the response was measured, and its own standard error.
    impacts, impacts_error : float
        The same of its impacts per cycle.
    repeats : bool
        Whether that long run ended in a periodic motion: what was measured was a long transient.
    """

    point: Point
    response: Response
    truth: float
    error: float
    impacts: float
    impacts_error: float
    repeats: bool

    @property
    def deviation(self) -> float:
        """Distance from the truth in standard errors."""
        return (self.response.amplitude_ratio - self.truth) / _both(self.response.amplitude_error, self.error)

    @property
    def deviation_of_impacts(self) -> float:
        """The same of impacts per cycle; 0 where they are counted."""
        error = _both(self.response.impacts_error, self.impacts_error)
        return (self.response.impacts_per_cycle - self.impacts) / error if error > 0.0 else 0.0

    @property
    def covered(self) -> bool:
        """Whether the 95 % interval holds the truth."""
        return abs(self.deviation) <= HALF_WIDTH


def _both(one: float, other: float) -> float:
    return float(np.hypot(one, other))


def compared(count: int, seed: int, cycles: int) -> Iterator[Compared]:
    """The first points of a draw from the whole cube whose response does not repeat, each against a run of so many cycles."""
    halves = np.empty((2 * cycles, 3))
    found = 0
    for point in points(seed, ("instant",)):
        if found == count:
            return
        response, end = settle(*point, SETTINGS, point.rest())
        if response.response_class not in (ResponseClass.MODULATED, ResponseClass.CHAOTIC):
            continue
        _, outcome = march_halves(*point, end, 0, halves)
        if outcome != ARRIVED:
            continue
        windows = np.maximum(halves[:-1, 0], halves[1:, 0])
        peaks = windows[: 2 * (cycles - 1)].reshape(-1, 2).mean(axis=1)
        hits = halves[:, 2].reshape(-1, 2).sum(axis=1)
        truth, error = mean_and_error(peaks, 0, peaks.size)
        impacts, impacts_error = mean_and_error(hits, 0, hits.size)
        yield Compared(point, response, truth, error, impacts, impacts_error, _repeats(halves[-800:, 0]))
        found += 1


def _repeats(peaks: NDArray[np.float64]) -> bool:
    scale = 1e-6 * float(peaks.max())
    return any(np.abs(peaks[lag:] - peaks[:-lag]).max() <= scale for lag in range(1, _LONGEST_PERIOD + 1))


def run(count: int = 300, cycles: int = 60_000, seed: int = 1) -> dict[str, Any]:
    """Coverage of `count` points of the cube; the truth of each takes `cycles`."""
    answers = list(islice(compared(count, seed, cycles), count))
    steady = [one for one in answers if not one.repeats]
    off = np.array([one.deviation for one in steady])
    counts = np.array([one.deviation_of_impacts for one in steady])
    worst = sorted(off[np.abs(off) > HALF_WIDTH], key=lambda one: -abs(one))
    return {
        "points": len(answers),
        "transients that ended later": len(answers) - len(steady),
        "stopped before the cycle limit": sum(one.response.status == Status.CONVERGED for one in steady),
        "95 % interval holds the truth, %": 100.0 * float(np.mean(np.abs(off) <= HALF_WIDTH)),
        "within one error, %": 100.0 * float(np.mean(np.abs(off) <= 1.0)),
        "missed, in errors": [round(float(one), 2) for one in worst],
        "95 % interval of impacts per cycle holds the truth, %": 100.0
        * float(np.mean(np.abs(counts) <= HALF_WIDTH)),
    }
