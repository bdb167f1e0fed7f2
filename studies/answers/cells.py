"""Cells of the grids of a study and its follow-ups: boxes between neighbouring designs."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import product
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.answers.design_question import DesignQuestion
from damperlab.studies.answers.follow_up import tolerance_of
from damperlab.studies.answers.judging import judge, new_tally
from damperlab.studies.answers.nearness import inside, nearest_place, same
from damperlab.studies.answers.phrases import FREQUENCY
from damperlab.studies.answers.slab import Slab

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]
Key = tuple[float, ...]

NOISE = 2.0
"""A difference smaller than this multiple of its standard error counts as zero."""
LUCK = 4.0
"""Like `NOISE`, but for a difference from the best value.

The factor is larger, because the best of many values is low partly by chance.
"""
STEEPEST = 2.0
"""Largest factor by which a change over one cell is scaled to a wider neighbouring cell.

Up to this limit, the factor is the ratio of the cell widths.
"""


@dataclass(frozen=True)
class Cells:
    """The n undivided cells of a study and its follow-ups, over d parameters.

    Parameters
    ----------
    low, high : ndarray, (n, d)
        Lowest and highest corner of each cell.
    promise : ndarray, (n,)
        Estimate of the smallest value within each cell, from values and slopes at the corners.
    spread : ndarray, (n, 3)
        Smallest and largest value at the corners of each cell, and the largest error of these values.
    """

    low: Floats
    high: Floats
    promise: Floats
    spread: Floats

    @property
    def widths(self) -> Floats:
        """Width of each cell along each parameter, (n, d)."""
        return self.high - self.low

    @classmethod
    def of(
        cls,
        cubes: "Mapping[str, xr.Dataset]",
        question: DesignQuestion,
        ranges: Mapping[str, tuple[float, float]],
        varied: list[str],
    ) -> "Cells":
        """Find the cells within `ranges`, and leave out a cell that a later study divides.

        If a range ends within a cell, the cell is cut at the end of the range. The estimates still use the value at
        the corner outside the range. A study computed with a different tolerance than the first study adds no
        cells. Its values still replace less accurate values of the same designs.
        """
        grids = [_Grid.of(cube, question, ranges, varied) for cube in cubes.values()]
        best: dict[Key, tuple[float, float]] = {}
        for grid in grids:
            for key, value, error in grid.points():
                if key not in best or error < best[key][1]:
                    best[key] = value, error
        tolerances = [tolerance_of(cube, 0.0) for cube in cubes.values()]
        cutting = [
            grid.with_values(best)
            for grid, own in zip(grids, tolerances, strict=True)
            if own == tolerances[0]
        ]
        found = []
        for place, grid in enumerate(cutting):
            cells = grid.cells()
            for later in cutting[place + 1 :]:
                if later.value.size:
                    cells = cells.outside(
                        [edge.min() for edge in later.edges], [edge.max() for edge in later.edges]
                    )
            found.append(cells)
        return cls(
            *(
                np.concatenate([getattr(each, name) for each in found])
                for name in ("low", "high", "promise", "spread")
            )
        )

    def take(self, chosen: NDArray[np.bool_]) -> "Cells":
        """Return the chosen cells."""
        return Cells(self.low[chosen], self.high[chosen], self.promise[chosen], self.spread[chosen])

    def outside(self, low: list[float], high: list[float]) -> "Cells":
        """Return the cells that do not lie within a box."""
        within = ((self.low >= low) | same(self.low, low)) & ((self.high <= high) | same(self.high, high))
        return self.take(np.asarray(~within.all(axis=1)))

    def touch(self, point: list[float]) -> NDArray[np.bool_]:
        """Return for each cell whether a point lies inside the cell or on the border, (n,)."""
        at = np.asarray(point)
        reached = ((self.low <= at) | same(self.low, at)) & ((self.high >= at) | same(self.high, at))
        return np.asarray(reached.all(axis=1))

    def flat(self, value: float, error: float) -> NDArray[np.bool_]:
        """Return which cells are flat within the errors, (n,).

        In a flat cell, errors alone can explain that the values at the corners exceed `value`.
        """
        doubt = np.hypot(self.spread[:, 2], error)
        # an error as small as rounding is not a statistical error
        return np.asarray((doubt > 1e-6 * value) & (self.spread[:, 1] - value <= LUCK * doubt))


@dataclass(frozen=True)
class _Grid:
    axes: tuple[Floats, ...]
    edges: tuple[Floats, ...]
    """Edges of the cells along each axis, cut at the ends of the range."""
    value: Floats
    error: Floats

    @classmethod
    def of(
        cls,
        cube: "xr.Dataset",
        question: DesignQuestion,
        ranges: Mapping[str, tuple[float, float]],
        varied: list[str],
    ) -> "_Grid":
        """Judge the designs in the ranges, and the nearest designs outside the ranges.

        The value of a design that does not qualify is NaN.
        """
        index, axes, edges = {}, [], []
        for name in question.design:
            values = cube[name].values
            kept = np.argsort(values, kind="stable")
            if name in ranges:
                kept = kept[_reaching(values[kept], *ranges[name])]
            index[name] = kept
            if name in varied:
                axes.append(values[kept].astype(float))
                edges.append(_cut(axes[-1], *ranges[name]) if name in ranges else axes[-1])
        frequencies = cube[FREQUENCY].values
        index[FREQUENCY] = np.array([nearest_place(frequencies, r) for r in question.frequencies])
        theirs = replace(question, axes=index)
        shape = tuple(axis.size for axis in axes)
        value, error = np.full(shape, np.nan), np.full(shape, np.nan)
        if value.size:
            found = judge(Slab(cube, question.design, (FREQUENCY,), index), theirs, new_tally())
            at = tuple(_positions(index[name], found[name]) for name in varied)
            value[at], error[at] = found["value"], np.nan_to_num(found["error"])
        return cls(tuple(axes), tuple(edges), value, error)

    def points(self) -> list[tuple[Key, float, float]]:
        """Return the coordinates, the value and the error of every design that has a value."""
        known = np.argwhere(np.isfinite(self.value))
        return [
            (
                tuple(float(axis[i]) for axis, i in zip(self.axes, place, strict=True)),
                float(self.value[tuple(place)]),
                float(self.error[tuple(place)]),
            )
            for place in known
        ]

    def with_values(self, best: Mapping[Key, tuple[float, float]]) -> "_Grid":
        """Return the grid with values and errors from `best`. Designs without a value stay unchanged."""
        value, error = self.value.copy(), self.error.copy()
        for place in np.argwhere(np.isfinite(value)):
            key = tuple(float(axis[i]) for axis, i in zip(self.axes, place, strict=True))
            value[tuple(place)], error[tuple(place)] = best[key]
        return _Grid(self.axes, self.edges, value, error)

    def cells(self) -> Cells:
        """Return the cells between neighbouring designs. A cell has zero width along a parameter with one value."""
        if not self.value.size:
            d = len(self.axes)
            return Cells(np.zeros((0, d)), np.zeros((0, d)), np.zeros(0), np.zeros((0, 3)))
        drops = [self._drops(d) for d in range(len(self.axes))]
        shape = tuple(max(1, axis.size - 1) for axis in self.axes)
        least, largest, doubt = np.full(shape, np.inf), np.full(shape, -np.inf), np.zeros(shape)
        promise = np.full(shape, np.inf)
        sides = [(0,) if axis.size == 1 else (0, 1) for axis in self.axes]
        for corner in product(*sides):
            part = tuple(slice(side, side + extent) for side, extent in zip(corner, shape, strict=True))
            value = self.value[part]
            known = np.isfinite(value)
            drop = sum((drops[d][side][part] for d, side in enumerate(corner)), np.zeros(shape))
            promise = np.where(known, np.minimum(promise, value - drop), promise)
            least = np.where(known, np.minimum(least, value), least)
            largest = np.where(known, np.maximum(largest, value), largest)
            doubt = np.where(known, np.maximum(doubt, self.error[part]), doubt)
        low = np.stack(
            np.meshgrid(*(edge[: max(1, edge.size - 1)] for edge in self.edges), indexing="ij"), axis=-1
        )
        high = np.stack(
            np.meshgrid(*(edge[-max(1, edge.size - 1) :] for edge in self.edges), indexing="ij"), axis=-1
        )
        dims = len(self.axes)
        spread = np.stack([least, largest, doubt], axis=-1)
        return Cells(
            low.reshape(-1, dims), high.reshape(-1, dims), promise.reshape(-1), spread.reshape(-1, 3)
        )

    def _drops(self, d: int) -> tuple[Floats, Floats]:
        """Estimate by how much the value may fall from each design to the middle of the neighbouring cell.

        The first array is for the cell above the design, the second array for the cell below.
        """
        axis = self.axes[d]
        value, error = np.moveaxis(self.value, d, 0), np.moveaxis(self.error, d, 0)
        up, down = np.zeros_like(value), np.zeros_like(value)
        if axis.size > 1:
            steps = np.diff(axis)
            fall = np.diff(value, axis=0)  # change from each design to the next one
            noise = NOISE * np.hypot(error[1:], error[:-1])
            shape = (-1, *(1,) * (value.ndim - 1))
            on = np.minimum(steps[1:] / steps[:-1], STEEPEST).reshape(shape)
            back = np.minimum(steps[:-1] / steps[1:], STEEPEST).reshape(shape)
            up[1:-1] = 0.5 * on * np.maximum(-fall[:-1] - noise[:-1], 0.0)
            down[1:-1] = 0.5 * back * np.maximum(fall[1:] - noise[1:], 0.0)
            # at the end of an axis, only the slope inside the grid is known
            up[0] = 0.25 * np.maximum(np.abs(fall[0]) - noise[0], 0.0)
            down[-1] = 0.25 * np.maximum(np.abs(fall[-1]) - noise[-1], 0.0)
        return tuple(np.moveaxis(np.nan_to_num(array), 0, d) for array in (up, down))  # type: ignore[return-value]


def _reaching(axis: Floats, low: float, high: float) -> slice:
    """Return the slice of the values of an ascending axis that lie in a range.

    If an end of the range lies between two values, the slice includes the value just outside the range.
    """
    within = inside(axis, low, high)
    first = int(((axis < low) & ~within).sum())
    last = axis.size - int(((axis > high) & ~within).sum())
    if first == axis.size or last == 0:
        return slice(0)
    below = int(first > 0 and not same(axis[first], low))
    above = int(last < axis.size and not same(axis[last - 1], high))
    return slice(first - below, last + above)


def _cut(axis: Floats, low: float, high: float) -> Floats:
    return np.where(inside(axis, low, high), axis, np.clip(axis, low, high))


def _positions(kept: NDArray[np.intp], wanted: NDArray[np.intp]) -> NDArray[np.intp]:
    """Return the position in `kept` of each index in `wanted`."""
    place = np.zeros(int(kept.max()) + 1, np.intp)
    place[kept] = np.arange(kept.size)
    return place[wanted]


def joined(cells: Cells, chosen: NDArray[np.intp]) -> list[list[Floats]]:
    """Join adjacent chosen cells into boxes, each given by its ascending edges along every parameter."""
    boxes = [
        [np.unique([low, high]) for low, high in zip(cells.low[each], cells.high[each], strict=True)]
        for each in chosen
    ]
    for d in range(cells.low.shape[1]):
        boxes.sort(key=lambda box: float(box[d][0]))
        merged: list[list[Floats]] = []
        for box in boxes:
            for other in merged:
                beside = bool(same(other[d][-1], box[d][0])) and box[d].size > 1
                if beside and all(np.array_equal(other[k], box[k]) for k in range(len(box)) if k != d):
                    other[d] = np.concatenate((other[d], box[d][1:]))
                    break
            else:
                merged.append(list(box))
        boxes = merged
    return boxes
