"""Recurrence of a run: distances between section points, which are states at the start of half cycles.

A relative recurrence is such a distance, divided by the size of the section point (`extent`).
"""

from math import inf, nan, sqrt

import numpy as np
from numpy.typing import NDArray

from damperlab.worker.jit import inlined, kernel
from damperlab.worker.solver.array_loops import zero_counts
from damperlab.worker.steady.section.coordinates import SECTION_SIZE

Array = NDArray[np.float64]

RING = 128
"""Number of half cycles whose section points are stored."""

LONGEST = 64
"""Longest period that is searched [half cycles], equal to 32 excitation cycles."""

PATH_COLUMNS = SECTION_SIZE + 1
"""Columns of the path of a run: the section coordinates, and the square of their `extent`."""

SQUARED_EXTENT = SECTION_SIZE
"""Column of the squared extent in a path."""

SAME = 1e-6
"""Largest relative recurrence at which a divisor of a settled period replaces the period."""

# The following values are chosen, not derived.
_ROUNDING = 1e-13  # A response with at most this relative recurrence counts as settled.
_NEAR = 0.05  # Relative recurrence below which Newton's method is tried.
# The period nT replaces T if the recurrence with nT is below `_FAR_BETTER`/n times the recurrence with T.
_FAR_BETTER = 0.4


@kernel
def recurrence(ring: Array, now: int, period_halves: int) -> float:
    """Distance between the section points `now` and `now − period_halves`, counted from the start of the run."""
    here = now % RING
    there = (now - period_halves) % RING
    total = 0.0
    for i in range(SECTION_SIZE):
        total += (ring[here, i] - ring[there, i]) ** 2
    return sqrt(total)


@kernel
def note_recurrences(ring: Array, now: int, apart: Array, before: Array) -> None:
    """Write into `apart` the distances of a section point from those up to `LONGEST` half cycles earlier.

    The former values of `apart` are moved to `before`.
    """
    for period_halves in range(1, min(LONGEST, now // 2) + 1):
        before[period_halves] = apart[period_halves]
        apart[period_halves] = recurrence(ring, now, period_halves)


@kernel
def extent(ring: Array, now: int) -> float:
    """Reference for relative distances: the size of the section point `now`, at least 1."""
    total = 1.0
    for i in range(SECTION_SIZE):
        total += ring[now % RING, i] ** 2
    return sqrt(total)


@kernel
def settled_period(
    ring: Array, now: int, apart: Array, before: Array, stretch: int, scale: float, tolerance: float
) -> tuple[int, float]:
    """Return the shortest period [half cycles] to which the run has settled, or 0, and the remaining distance.

    The recurrence d of a settling response falls by the factor λ per period, so the remaining distance is the sum of a
    geometric series, d λ/(1 − λ). The factor λ is computed from the current recurrences (`apart`) and from earlier
    recurrences (`before`), which were recorded `stretch` half cycles earlier.
    """
    found = 0
    way_left = inf
    for period_halves in range(1, min(LONGEST, now // 2) + 1):
        d = apart[period_halves]
        earlier = before[period_halves]
        if d <= _ROUNDING * scale and earlier <= 10.0 * _ROUNDING * scale:
            found, way_left = period_halves, d
        elif d < earlier and earlier <= 0.01 * scale:
            # among many periods, one recurrence may be small by chance, so a fall by more than half is not extrapolated
            rate = max((d / earlier) ** (period_halves / stretch), 0.5)
            if d * rate / (1.0 - rate) <= tolerance * scale:
                found, way_left = period_halves, d * rate / (1.0 - rate)
        elif d <= tolerance * scale and earlier <= tolerance * scale:
            # Under a slow base, rounding errors exceed `_ROUNDING`.
            # A recurrence that stays below the tolerance is then sufficient.
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
    """Whether the last `LONGEST` section points repeat those 1, 2, … periods earlier, within `distance`."""
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

    A multiple of the period is returned if the run repeats far better with the multiple. Near a period doubling, the
    orbit with the shorter period lies close to the run but is unstable. The higher the multiple, the better the run
    must repeat: a run that spirals into an orbit turns around the orbit, and may have made almost a whole number of
    turns by chance.
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


@inlined
def note_point(ring: Array, place: int, riding: float, path: Array, row: int) -> None:
    """Copy a section point from a row of the ring into a row of the path."""
    square = 1.0
    for i in range(SECTION_SIZE):
        value = ring[place, i]
        path[row, i] = value
        square += value**2
    path[row, SQUARED_EXTENT] = square
    if riding != 0.0:
        path[row, 0] = nan


@kernel
def closest_recurrences(
    path: Array, last: int, period_halves: int, parts: int, farthest: float
) -> NDArray[np.int64]:
    """Rows of `path` from which the run repeats best over two periods, with relative recurrences below `farthest`.

    The relative recurrence of a row is the larger of the distances over the first and over the second period. Near an
    orbit that strongly repels, the second distance is far larger than the first.

    The rows 1 … `last` − 2 `period_halves` are divided into equal parts, and one row of each part is returned, or 0 if
    the part has no such row. Rows with NaN are skipped.
    """
    rows = zero_counts(parts)
    count = last - 2 * period_halves
    for part in range(parts):
        nearest = farthest**2
        for row in range(1 + part * count // parts, 1 + (part + 1) * count // parts):
            limit = nearest * path[row, SQUARED_EXTENT]
            once = _squared_distance(path, row, row + period_halves, limit)
            if once < limit:
                again = _squared_distance(path, row + period_halves, row + 2 * period_halves, limit)
                if again < limit:
                    rows[part], nearest = row, max(once, again) / path[row, SQUARED_EXTENT]
    return rows


@inlined
def _squared_distance(path: Array, row: int, other: int, limit: float) -> float:
    """Squared distance between two rows of a path, or a part of it that is not below `limit`."""
    total: float = (path[other, 0] - path[row, 0]) ** 2
    if total < limit:  # most comparisons end with the first coordinate
        for i in range(1, SECTION_SIZE):
            total += (path[other, i] - path[row, i]) ** 2
    return total
