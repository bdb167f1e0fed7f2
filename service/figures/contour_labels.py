"""Choose positions for the numbers on contour lines, so that no line crosses a number."""

from collections.abc import Iterator

import numpy as np
from matplotlib.contour import ContourSet
from matplotlib.path import Path
from numpy.typing import NDArray

from damperlab.service.figures.style import is_logarithmic

ROOM = 0.035
"""Radius of a circle around each number, as a share of the length of each axis. The circle must contain no
part of the contour lines of other levels. The text of a number is twice as long as the radius."""
STEP = 0.005
"""Distance between the sampled points of a contour line, as a share of the length of each axis."""
FOLDED = 1.3
"""Largest length of the number's own line inside the circle, divided by the diameter of the circle. A line
that turns back and passes through the circle twice has a larger ratio, and gets no number there."""
STRAIGHT = 0.97
"""Smallest ratio at which a line is straight enough for a number: the distance between the two ends of the
number, divided by the length of the line between these ends. The ratio is 1 for a straight line."""
MOST_POINTS, CANDIDATES = 10_000, 200
"""Largest number of points on all lines, and largest number of positions that are tried for a number."""


def label_places(
    lines: ContourSet, x: NDArray[np.float64], y: NDArray[np.float64]
) -> list[tuple[float, float]]:
    """Choose a position for the number of each level.

    A level without a free position gets no number.

    Parameters
    ----------
    lines : ContourSet
        Contour lines over x and y.
    x, y : ndarray
        Ascending values of the grid. On a logarithmic axis, the logarithms of the values are evenly spaced.

    Returns
    -------
    list of (float, float)
        Points on the lines, in the units of x and y.
    """
    pieces = [list(_pieces(path, x, y)) for path in lines.get_paths()]
    points = [np.concatenate([np.empty((0, 2)), *each]) for each in pieces]
    if sum(map(len, points)) > MOST_POINTS:
        return []
    taken = np.empty((0, 2))
    places = []
    for index, own in enumerate(points):
        room = [piece[_straight(piece)] for piece in pieces[index]]
        inside = np.concatenate([np.empty((0, 2)), *room])
        inside = inside[((inside > ROOM) & (inside < 1.0 - ROOM)).all(axis=1)]
        inside = inside[:: 1 + len(inside) // CANDIDATES]
        others = np.concatenate([taken, *(each for at, each in enumerate(points) if at != index)])
        away = _distance(inside, others)
        around = (np.hypot(*(inside[:, None] - own).transpose(2, 0, 1)) < ROOM).sum(axis=1)
        free = (away > ROOM) & (around < 2.0 * FOLDED * ROOM / STEP)
        if free.any():
            best = inside[free][away[free].argmax()]
            taken = np.vstack([taken, best])
            places.append((_back(best[0], x), _back(best[1], y)))
    return places


def _straight(piece: NDArray[np.float64]) -> NDArray[np.intp]:
    """Return the indices of the points at which a line is straight enough for a number."""
    half = int(ROOM / STEP)
    if len(piece) <= 2 * half:
        return np.empty(0, np.intp)
    ends = np.hypot(*(piece[2 * half :] - piece[: -2 * half]).T)
    return half + np.flatnonzero(ends > STRAIGHT * 2 * half * STEP)


def _pieces(path: Path, x: NDArray[np.float64], y: NDArray[np.float64]) -> Iterator[NDArray[np.float64]]:
    """Yield evenly spaced points along each piece of a path; coordinates are fractions of the axes."""
    for piece in path.to_polygons(closed_only=False):
        across, up = np.asarray(piece, np.float64).T
        corners = np.column_stack([_share(across, x), _share(up, y)])
        along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(corners, axis=0).T))])
        if along[-1] > STEP:
            at = np.arange(0.0, along[-1], STEP)
            yield np.column_stack([np.interp(at, along, corners[:, 0]), np.interp(at, along, corners[:, 1])])


def _distance(points: NDArray[np.float64], others: NDArray[np.float64]) -> NDArray[np.float64]:
    if not others.size:
        return np.ones(len(points))
    return np.asarray(np.hypot(*(points[:, None] - others).transpose(2, 0, 1)).min(axis=1))


def _share(values: NDArray[np.float64], axis: NDArray[np.float64]) -> NDArray[np.float64]:
    if is_logarithmic(axis):
        return _share(np.log(values), np.log(axis))
    return np.asarray((values - axis[0]) / (axis[-1] - axis[0]))


def _back(share: float, axis: NDArray[np.float64]) -> float:
    if is_logarithmic(axis):
        return float(axis[0] * (axis[-1] / axis[0]) ** share)
    return float(axis[0] + share * (axis[-1] - axis[0]))
