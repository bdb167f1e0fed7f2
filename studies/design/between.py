"""What may lie between candidates: how far the worst case may dip where none was looked at."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import inf, isfinite

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.design.lattice import Candidate, Lattice
from damperlab.studies.design.score import Score

SAME = 1e-9
"""Difference of shares that are one place."""


@dataclass
class Between:
    """How far it is from every candidate to those around it.

    Parameters
    ----------
    lattice : Lattice
        Of the candidates.
    """

    lattice: Lattice
    _reach: dict[Candidate, tuple[float, ...]] = field(default_factory=dict)
    _step: dict[Candidate, float] = field(default_factory=dict)
    _around: set[Candidate] = field(default_factory=set)

    def begin(self, candidates: list[Candidate], step: float) -> None:
        """Note the first look, in which every candidate has neighbours on all sides."""
        reach: list[float] = []
        for place, name in enumerate(self.lattice.names):
            gaps = np.diff(sorted({each[place] for each in candidates}))
            reach.append(0.0 if self.lattice.listed(name) else float(gaps.max(initial=0.0)))
        self._reach = dict.fromkeys(candidates, tuple(reach))
        self._step = dict.fromkeys(candidates, step)
        self._around = set(candidates)

    def looked_around(self, centres: list[Candidate], new: list[Candidate], step: float) -> None:
        """Note that candidates have neighbours a step away on all sides, some of them new."""
        reach = tuple(0.0 if self.lattice.listed(name) else step for name in self.lattice.names)
        closer = [each for each in centres if step < self._step[each]]
        for each in (*closer, *new):
            self._reach[each], self._step[each] = reach, step
        self._around.update(each for each in centres if step <= self._step[each])

    def step(self, candidate: Candidate) -> float:
        """Give the step at which a candidate was looked at, or around."""
        return self._step[candidate]

    def next_step(self, candidate: Candidate) -> float:
        """Give the step of the next look around a candidate: its own where it was only seen from one side."""
        step = self._step[candidate]
        return step / 2 if candidate in self._around else step

    def beside(self, candidate: Candidate, others: list[Candidate]) -> list[Candidate]:
        """Choose the neighbours of a candidate."""
        reach = self._reach[candidate]
        return [
            other
            for other in others
            if all(abs(a - b) <= far + SAME for a, b, far in zip(other, candidate, reach, strict=True))
        ]

    def dips(self, scores: Mapping[Candidate, Score]) -> dict[Candidate, float]:
        """Give how far the worst case may fall below each candidate that none of its neighbours is better than.

        Along every quantity alone by `dip`, and what these come to is added up; of one that was seen from one side alone,
        by what it differs from those there.

        Parameters
        ----------
        scores : mapping of Score
            Of all candidates, as drawn.

        Returns
        -------
        dict of float
            In the unit of the measure, by candidate.
        """
        every = sorted(each for each in scores if isfinite(scores[each].value))
        if not every or not self.lattice.names:
            return {}
        places = np.array(every)
        values = np.array([scores[each].value for each in every])
        ranks = np.array([scores[each].violation for each in every])
        found: dict[Candidate, float] = {}
        for at, each in enumerate(every):
            apart = np.abs(places - places[at])
            near = (apart <= np.array(self._reach[each]) + SAME).all(axis=1)
            # of several that are equal the first stands for all
            before = np.arange(len(every)) < at
            as_good = (values < values[at]) | ((values == values[at]) & before)
            if (near & ((ranks < ranks[at]) | ((ranks == ranks[at]) & as_good))).any():
                continue
            if each not in self._around:
                # seen from one side only: it may dip by whatever it differs from those
                found[each] = float(np.abs(values[near] - values[at]).max())
                continue
            found[each] = 0.0
            for axis, name in enumerate(self.lattice.names):
                line = (np.delete(apart, axis, axis=1) <= SAME).all(axis=1)
                if not self.lattice.listed(name):
                    order = np.flatnonzero(line)[np.argsort(places[line, axis])]
                    found[each] += dip(places[order, axis], values[order], int((order == at).argmax()))
        return found


def dip(x: NDArray[np.float64], values: NDArray[np.float64], place: int) -> float:
    """Give how far a convex function may fall below one of its values on the two intervals beside it.

    Such a function lies above every chord that is prolonged. So on an interval it falls from either end at most as
    steeply as it was seen to fall towards that end. A worst case is the largest of many responses, and convex where
    two of them cross.

    Parameters
    ----------
    x, values : ndarray, (n,)
        Ascending places, and the function there.
    place : int
        Which of them.

    Returns
    -------
    float
        Not negative; where no chord can be prolonged into an interval, what its ends differ by.
    """

    def into(step: int) -> float:
        end, beyond, behind = place + step, place + 2 * step, place - step
        if not 0 <= end < x.size:
            return 0.0
        width = abs(x[end] - x[place])
        falls = [inf, inf]
        if 0 <= behind < x.size:
            falls[0] = (values[behind] - values[place]) / abs(x[place] - x[behind]) * width
        if 0 <= beyond < x.size:
            slope = (values[beyond] - values[end]) / abs(x[beyond] - x[end])
            falls[1] = slope * width - (values[end] - values[place])
        least = min(falls)
        return max(float(least if isfinite(least) else abs(values[end] - values[place])), 0.0)

    return max(into(-1), into(1))
