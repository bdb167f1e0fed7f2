"""What the blocks of a study are expected to take, corrected by what blocks beside them have taken.

The cost model of `damperlab.worker.dispatch.cost_model` knows what points of a scene cost on average, and little of how they
differ; those beside each other mostly cost alike. So its error, measured over expected seconds, is interpolated between the
blocks that are known: those of this study that have ended, and those of earlier studies of its family.
"""

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.plan import Plan, plan_with_chunk
from damperlab.studies.store.cube.definition import DefinitionDamaged, parse_stored
from damperlab.studies.store.reuse.measured import Measured
from damperlab.worker.dispatch.cost_model import seconds_per_point

NEIGHBOURS = 6
"""Known blocks that one is compared with."""
NEAR = 0.02
"""Distances below this, as a share of an axis, count alike: a single block's time scatters."""
CAUTION = 2.0
"""Scatters of the neighbours above their mean by which blocks are ordered: one that begins late and takes long delays all, one
that begins early and takes little delays none."""
FAR = 0.2
"""Distance at which a known block says no more than all of them together."""
DOUBT, DOUBT_KNOWING = 4.0, 2.5
"""Factor either way within which a study takes what is expected, by the cost model alone and after one of its family: so in 31
and 32 of 32 drawn at random (560 points of any hybrid scene, the earlier one of 180)."""
FEWEST_KNOWN, MOST_KNOWN = 64, 512
"""Known blocks that are looked at, taken evenly from all: what they tell is how cost varies over the grid."""
COMPARISONS = 5_000_000
"""Of blocks with known ones in making a forecast: a tenth of a second, in which nothing is sent to workers."""
GROWTH = 1.2
"""A forecast is made anew once so many times more blocks have ended: seldom where they are many and each says little."""
_AT_ONCE = 4096

Known = tuple[Mapping[str, NDArray[Any]], NDArray[np.float64]]
"""Centres of blocks, N values of each dimension, and N values of measured over expected seconds."""


class Forecast:
    """Expected seconds of every block.

    Parameters
    ----------
    plan : Plan
        Of the study.
    known : Known, optional
        From earlier studies of its family.
    """

    def __init__(self, plan: Plan, known: Known | None = None) -> None:
        self.plan = plan
        self._axes = plan.study.coordinates
        self._places = self._places_of(plan.centres(np.arange(plan.count)))
        self._elsewhere = np.empty((0, len(self._axes))), np.empty(0)
        if known is not None:
            centres, ratios = known
            places = self._places_of(centres)
            there = np.isfinite(places).all(axis=1)
            self._elsewhere = places[there], np.log(ratios[there])
        self._most = int(np.clip(COMPARISONS // plan.count, FEWEST_KNOWN, MOST_KNOWN))
        self._ended: dict[int, float] = {}
        self._next = 1.0
        self.seconds = plan.block_seconds.copy()
        """Expected seconds of each block, (count,)."""
        self.cautious = self.seconds
        """What each may well take: where the known blocks about one differ, it may be like the longest of them, (count,)."""
        if self._elsewhere[1].size:
            self._correct()

    @property
    def bounds(self) -> tuple[float, float]:
        """Between what the whole study may well take [s]."""
        total = float(self.seconds.sum())
        doubt = DOUBT_KNOWING if self.informed else DOUBT
        return total / doubt, total * doubt

    @property
    def informed(self) -> bool:
        """Whether it rests on more than the cost model."""
        return bool(self._ended) or bool(self._elsewhere[1].size)

    def learn(self, index: int, seconds: float) -> bool:
        """Hear what a block has taken.

        Parameters
        ----------
        index : int
            Of the block.
        seconds : float
            In kernels; one that took none is no measure.

        Returns
        -------
        bool
            Whether the forecast is another one now.
        """
        if seconds <= 0.0:
            return False
        self._ended[index] = float(np.log(seconds / self.plan.block_seconds[index]))
        if len(self._ended) < self._next:
            return False
        self._next = max(len(self._ended) + 1.0, len(self._ended) * GROWTH)
        self._correct()
        return True

    def _correct(self) -> None:
        places, ratios = self._elsewhere
        # what was measured on this grid, by these workers, stands before what was measured elsewhere
        there = _evenly(len(ratios), max(0, self._most - len(self._ended)))
        here = _evenly(len(self._ended), self._most)
        indices = np.fromiter(self._ended, np.int64)[here]
        own = np.fromiter(self._ended.values(), np.float64)[here]
        places = np.concatenate([places[there], self._places[indices]])
        ratios = np.concatenate([ratios[there], own])
        mean, scatter = np.empty(self.plan.count), np.empty(self.plan.count)
        for first in range(0, self.plan.count, _AT_ONCE):
            some = slice(first, first + _AT_ONCE)
            mean[some], scatter[some] = _interpolated(self._places[some], places, ratios)
        self.seconds = self.plan.block_seconds * np.exp(mean)
        self.cautious = self.seconds * np.exp(CAUTION * scatter)

    def _places_of(self, centres: Mapping[str, NDArray[Any]]) -> NDArray[np.float64]:
        """Give where points lie along each axis, from 0 to 1; NaN for a name that the axis does not hold."""
        columns: list[NDArray[np.float64]] = []
        for name, axis in self._axes.items():
            values, along = centres[name], np.arange(len(axis)) / len(axis)
            if axis.dtype.kind == "f":
                columns.append(np.interp(values, axis, along))
            else:
                found = dict(zip(axis.tolist(), along, strict=True))
                columns.append(np.array([found.get(value, np.nan) for value in values.tolist()]))
        return np.stack(columns, axis=1)


def known_of(earlier: Iterable[Measured]) -> Known | None:
    """Give what is known from blocks that are done; None where there are none.

    Parameters
    ----------
    earlier : iterable of Measured
        Of `damperlab.studies.store.reuse.measured`.
    """
    centres: list[Mapping[str, NDArray[Any]]] = []
    ratios: list[NDArray[np.float64]] = []
    for measured in earlier:
        try:
            study = parse_stored(measured.record.definition, measured.record.digest)
        except (DefinitionDamaged, ValueError):
            # what is wrong with another study is said where that is asked for
            continue
        plan = plan_with_chunk(study, measured.record.chunk, seconds_per_point)
        centres.append(plan.centres(measured.indices))
        ratios.append(measured.kernel_seconds / plan.seconds_of(measured.indices))
    if not ratios:
        return None
    return {name: np.concatenate([one[name] for one in centres]) for name in centres[0]}, np.concatenate(
        ratios
    )


def _evenly(count: int, most: int) -> NDArray[np.int64]:
    """Choose at most so many of a row, evenly."""
    number = min(count, most)
    return (np.arange(number) * count) // max(1, number)


def _interpolated(
    where: NDArray[np.float64], places: NDArray[np.float64], values: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Weigh the nearest known values by the inverse square of their distances.

    Parameters
    ----------
    where, places : ndarray, (N, D) and (M, D)
        Asked for and known.
    values : ndarray, (M,)
        The known ones.

    Returns
    -------
    mean, scatter : ndarray, (N,)
        The weighted mean, and the weighted standard deviation about it.
    """
    squares = np.zeros((len(where), len(places)))
    for one, other in zip(where.T, places.T, strict=True):
        squares += np.square(one[:, None] - other[None, :])
    number = min(NEIGHBOURS, len(places))
    near = np.argpartition(squares, number - 1, axis=1)[:, :number]
    weights = 1.0 / (np.take_along_axis(squares, near, axis=1) + NEAR**2)
    # far from all that is known the best guess is the mean of that
    weights = np.column_stack([weights, np.full(len(where), 1.0 / FAR**2)])
    weights /= weights.sum(axis=1, keepdims=True)
    near_values = np.column_stack([values[near], np.full(len(where), values.mean())])
    mean = (weights * near_values).sum(axis=1)
    variance = (weights * np.square(near_values - mean[:, None])).sum(axis=1) + weights[:, -1] * values.var()
    return mean, np.sqrt(variance)
