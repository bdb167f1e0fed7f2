"""Recurrence of a run: distances between its section points, the states at the start of every (mirrored) half cycle."""

from math import inf, sqrt

import numpy as np
from numpy.typing import NDArray

from damperlab.worker.jit import kernel
from damperlab.worker.steady.section.coordinates import SECTION_SIZE

Array = NDArray[np.float64]

RING = 128
"""Half cycles remembered, each by its section coordinates."""

LONGEST = 64
"""Longest period searched, in half cycles; it is 32 excitation periods of an asymmetric response."""

SAME = 1e-6
"""Relative recurrence below which a settled response has this period instead of a multiple of it."""

# These values are chosen in the same way as those of `orbits.candidate`.
_ROUNDING = 1e-13  # recurrence of a settled response, relative
_NEAR = 0.05  # relative recurrence below which Newton's method is tried
# n times a period is taken instead of the period if its recurrence is below this share, divided by n, of the period's.
_FAR_BETTER = 0.4


@kernel
def recurrence(ring: Array, now: int, period_halves: int) -> float:
    """Distance between the section points `now` and `now − period_halves`, indices counted from the start of the
    run.
    """
    here = now % RING
    there = (now - period_halves) % RING
    total = 0.0
    for i in range(SECTION_SIZE):
        total += (ring[here, i] - ring[there, i]) ** 2
    return sqrt(total)


@kernel
def note_recurrences(ring: Array, now: int, apart: Array, before: Array) -> None:
    """Write the distances of a section point from those up to `LONGEST` half cycles ago into `apart`; move the former
    values to `before`.
    """
    for period_halves in range(1, min(LONGEST, now // 2) + 1):
        before[period_halves] = apart[period_halves]
        apart[period_halves] = recurrence(ring, now, period_halves)


@kernel
def extent(ring: Array, now: int) -> float:
    """Size of the section point `now`, at least 1: the reference of distances."""
    total = 1.0
    for i in range(SECTION_SIZE):
        total += ring[now % RING, i] ** 2
    return sqrt(total)


@kernel
def settled_period(
    ring: Array, now: int, apart: Array, before: Array, stretch: int, scale: float, tolerance: float
) -> tuple[int, float]:
    """Shortest period [half cycles] to which the run has settled, or 0, and the remaining distance from it.

    The recurrence of a settling response falls by the factor λ per period, and the remaining distance is the sum of the
    geometric series, d λ/(1 − λ). The recurrences `apart` now and `before`, `stretch` half cycles ago, give λ.
    """
    found = 0
    way_left = inf
    for period_halves in range(1, min(LONGEST, now // 2) + 1):
        d = apart[period_halves]
        earlier = before[period_halves]
        if d <= _ROUNDING * scale and earlier <= 10.0 * _ROUNDING * scale:
            found, way_left = period_halves, d
        elif d < earlier and earlier <= 0.01 * scale:
            # one of many periods may come near by chance, so a fall faster than by half is not extrapolated
            rate = max((d / earlier) ** (period_halves / stretch), 0.5)
            if d * rate / (1.0 - rate) <= tolerance * scale:
                found, way_left = period_halves, d * rate / (1.0 - rate)
        elif d <= tolerance * scale and earlier <= tolerance * scale:
            # under a slow base rounding exceeds `_ROUNDING`: it suffices that the recurrence stays below the tolerance
            if stays_closed(ring, now, period_halves, tolerance * scale):
                found, way_left = period_halves, d
        if found > 0:
            break
    for shorter in range(1, found):
        if found % shorter == 0 and apart[shorter] <= SAME * scale:
            return shorter, way_left
    return found, way_left


@kernel
def stays_closed(ring: Array, now: int, period_halves: int, distance: float) -> bool:
    """Whether the run has repeated within a distance, by the period and all its multiples, for half of the memory."""
    if now < RING:
        return False
    for i in range(LONGEST):
        for multiple in range(period_halves, LONGEST + 1, period_halves):
            if recurrence(ring, now - i, multiple) > distance:
                return False
    return True


@kernel
def near_period(apart: Array, longest: int, scale: float) -> int:
    """Shortest period [half cycles] with which the run almost repeats, or 0.

    A multiple of the period is taken if the run repeats far better with it. Near a period doubling, the shorter orbit
    lies close by but is unstable. The higher the multiple, the better it must repeat: a run that spirals into an orbit
    turns around it, and after some number of periods it has made about a whole number of turns by chance.
    """
    found = 0
    nearest = _NEAR * scale
    for period_halves in range(1, longest + 1):
        if found == 0:
            closest = nearest
        elif period_halves % found == 0:
            closest = _FAR_BETTER * nearest * found / period_halves
        else:
            continue
        d = apart[period_halves]
        if d <= closest:
            found = period_halves
            nearest = d
    return found
