"""The trace of a metered run, with one row per half cycle, and the totals over a stretch of rows."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from damperlab.worker.jit import inlined, kernel
from damperlab.worker.solver.observe.meter import (
    ACCELERATION_PEAK,
    ACCELERATION_SQUARE,
    FRICTION_LOSS,
    IMPACT_LOSS,
    PARTICLE_LOSS,
    PEAK,
    RELATIVE_PEAK,
    SLIDING,
    SPEED,
    SQUARE,
    STUCK,
    VISCOUS_LOSS,
    WORK_IN,
    Meter,
)

# Columns of a trace. The first columns describe one half cycle alone.
HALF_PEAK = 0
HALF_RELATIVE_PEAK = 1
HALF_SPEED = 2
HALF_ACCELERATION = 3
# The next columns are totals since the start of metering, and the energy stored at the end of the half cycle.
IMPACTS_SO_FAR = 4
STORED = 5
_TOTALS = 6  # first column of the totals from the meter, in the order of `_METERED`
_ACCELERATION_SQUARE = _TOTALS + 8
COLUMNS = _TOTALS + 9
"""Number of columns of a trace."""
LOSSES = (_TOTALS + 1, _TOTALS + 2, _TOTALS + 3, _TOTALS + 6)
"""Columns of the losses: viscous, friction, impact, friction of the particle."""
_METERED = (
    WORK_IN,
    VISCOUS_LOSS,
    FRICTION_LOSS,
    IMPACT_LOSS,
    SQUARE,
    STUCK,
    PARTICLE_LOSS,
    SLIDING,
    ACCELERATION_SQUARE,
)


class Stretch(NamedTuple):
    """Totals over metered half cycles of a trace, from row `first` to row `last`.

    Attributes
    ----------
    first, last : int
        First and last row.
    impacts : float
    work, viscous, friction, impact : float
        Work of the excitation, and losses, over k Z².
    square, stuck : float
        ∫u² dτ, and the time in which friction holds the mass.
    rubbing, sliding : float
        Energy lost by the friction of the particle, over k Z², and the time in which the particle slides.
    stored_before, stored_after : float
        Energy stored at the beginning and at the end.
    speed, peak, relative_peak : float
        Largest impact speed, |u| and |v|.
    """

    first: int
    last: int
    impacts: float
    work: float
    viscous: float
    friction: float
    impact: float
    square: float
    stuck: float
    rubbing: float
    sliding: float
    stored_before: float
    stored_after: float
    speed: float
    peak: float
    relative_peak: float


@inlined
def clear_peaks(meter: Meter) -> None:
    """Reset peaks and speeds before a half cycle."""
    for peak in (PEAK, RELATIVE_PEAK, SPEED, ACCELERATION_PEAK):
        meter.sums[peak] = 0.0


@inlined
def note_half(line: NDArray[np.float64], meter: Meter, impacts: float, stored: float) -> None:
    """Write one row of a trace."""
    sums = meter.sums
    line[HALF_PEAK] = sums[PEAK]
    line[HALF_RELATIVE_PEAK] = sums[RELATIVE_PEAK]
    line[HALF_SPEED] = sums[SPEED]
    line[HALF_ACCELERATION] = sums[ACCELERATION_PEAK]
    line[IMPACTS_SO_FAR] = impacts
    line[STORED] = stored
    for i in range(len(_METERED)):
        line[_TOTALS + i] = sums[_METERED[i]]


@kernel
def stretch_of(trace: NDArray[np.float64], first: int, last: int) -> Stretch:
    """Totals over the half cycles of the rows first + 1 … last."""
    before = trace[first]
    after = trace[last]
    return Stretch(
        first,
        last,
        after[IMPACTS_SO_FAR] - before[IMPACTS_SO_FAR],
        after[_TOTALS] - before[_TOTALS],
        after[_TOTALS + 1] - before[_TOTALS + 1],
        after[_TOTALS + 2] - before[_TOTALS + 2],
        after[_TOTALS + 3] - before[_TOTALS + 3],
        after[_TOTALS + 4] - before[_TOTALS + 4],
        after[_TOTALS + 5] - before[_TOTALS + 5],
        after[_TOTALS + 6] - before[_TOTALS + 6],
        after[_TOTALS + 7] - before[_TOTALS + 7],
        before[STORED],
        after[STORED],
        largest_in(trace, first, last, HALF_SPEED),
        largest_in(trace, first, last, HALF_PEAK),
        largest_in(trace, first, last, HALF_RELATIVE_PEAK),
    )


@kernel
def largest_in(trace: NDArray[np.float64], first: int, last: int, column: int) -> float:
    """Largest value of a column over the half cycles of the rows first + 1 … last."""
    found: float = trace[first + 1, column]
    for row in range(first + 2, last + 1):
        found = max(found, trace[row, column])
    return found


@kernel
def cycle_peaks(trace: NDArray[np.float64], rows: int, peaks: NDArray[np.float64]) -> None:
    """Compute the peaks of each cycle from the metered half cycles, the rows 1 … `rows` of a trace.

    Two intervals of one cycle begin in each cycle, one at each half cycle. `peaks`, shape (2, ≥ rows // 2), receives
    the mean of the two interval peaks, so that a motion and its mirror image have equal peaks. If no half cycle
    follows the last cycle, only the first interval of this cycle is used.
    """
    for column in range(2):
        for i in range(rows // 2):
            peaks[column, i] = _peak_of_cycle(trace, rows, column, i)


@inlined
def _peak_of_cycle(trace: NDArray[np.float64], rows: int, column: int, i: int) -> float:
    """Mean of the peaks in a column over the two one-cycle intervals that begin in cycle i.

    If only one of the two intervals is metered, its peak is returned.
    """
    first = trace[2 * i + 1, column]
    second = trace[2 * i + 2, column]
    peak: float = max(first, second)
    if 2 * i + 3 <= rows:
        peak = 0.5 * (peak + max(second, trace[2 * i + 3, column]))
    return peak


@kernel
def mean_peak_of_period(trace: NDArray[np.float64], column: int, period_halves: int) -> float:
    """Mean of the peaks in a column over one period, the rows 1 … period_halves.

    The mean is over intervals of one cycle. An interval begins at every half cycle, so that a motion and its mirror
    image have the same mean.
    """
    total = 0.0
    for i in range(period_halves):
        total += max(trace[i + 1, column], trace[(i + 1) % period_halves + 1, column])
    return total / period_halves


@kernel
def acceleration_of_run(
    trace: NDArray[np.float64], first: int, last: int, metered: bool | None
) -> tuple[float, float] | None:
    """Mean peak of |u''|, over the intervals of `cycle_peaks`, and ∫u''² dτ over the cycles first … last − 1.

    The result is None if u'' was not metered.
    """
    if metered is None:
        return None
    total = 0.0
    for i in range(first, last):
        total += _peak_of_cycle(trace, 2 * last, HALF_ACCELERATION, i)
    square = trace[2 * last, _ACCELERATION_SQUARE] - trace[2 * first, _ACCELERATION_SQUARE]
    return total / (last - first), square


@kernel
def acceleration_of_period(
    trace: NDArray[np.float64], period_halves: int, halves: int, metered: bool | None
) -> tuple[float, float] | None:
    """Mean peak of |u''| over one period of `period_halves` half cycles, and ∫u''² dτ over the rows 1 … halves.

    The result is None if u'' was not metered.
    """
    if metered is None:
        return None
    return mean_peak_of_period(trace, HALF_ACCELERATION, period_halves), trace[halves, _ACCELERATION_SQUARE]
