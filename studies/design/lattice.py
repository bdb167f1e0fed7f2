"""Candidates on a lattice over what may be chosen, whose step is halved where it matters."""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import product

from damperlab.studies.design.build import Build
from damperlab.studies.specification.specification import CHOSEN, Specification

Candidate = tuple[float, ...]
"""Shares of the ranges of what is chosen, from 0 to 1, in the order of `CHOSEN`."""

FIRST = {1: 1 / 16, 2: 1 / 8, 3: 1 / 4, 4: 1 / 4}
"""The first step, by the number of quantities that are chosen."""
FINEST = 1 / 64
FULL = 2
"""Quantities up to which every neighbour of a candidate is looked at; of more only those along one quantity."""


@dataclass(frozen=True)
class Lattice:
    """The candidates of a specification.

    Parameters
    ----------
    asked : Specification
        What may be chosen.
    """

    asked: Specification

    @property
    def names(self) -> tuple[str, ...]:
        """What is chosen."""
        return self.asked.free

    def build(self, candidate: Candidate) -> Build:
        """Give the damper of a candidate, without what its choice does not matter for."""
        chosen = dict(zip(self.names, candidate, strict=True))
        values = {name: self.asked.choices[name].at(chosen.get(name, 0.0)) for name in CHOSEN}
        share = chosen.get("restitution", 0.0)
        contact_time_s = self.asked.choices["restitution"].contact_time_s(share)
        return Build(**values, contact_time_s=contact_time_s)

    def first(self) -> list[Candidate]:
        """Fill the space."""
        step = FIRST.get(len(self.names), 1 / 2)
        axes = []
        for position, name in enumerate(self.names):
            count = len(self.asked.choices[name].values)
            # beyond two quantities the later ones, which matter less, begin with half the places
            parts = round(1 / step) if position < 2 or len(self.names) < 3 else 2
            parts = count - 1 if 0 < count <= 5 else parts
            axes.append(self._onto(name, (k / parts for k in range(parts + 1))))
        return sorted(product(*axes))

    def around(self, centres: Iterable[Candidate], step: float) -> list[Candidate]:
        """Give the neighbours of candidates, a step away."""
        found: set[Candidate] = set()
        moves = [-1.0, 0.0, 1.0]
        for centre in centres:
            axes = [
                self._onto(name, (centre[d] + self._step(name, step) * move for move in moves))
                for d, name in enumerate(self.names)
            ]
            if len(self.names) <= FULL:
                found.update(product(*axes))
            else:
                for d, axis in enumerate(axes):
                    found.update((*centre[:d], value, *centre[d + 1 :]) for value in axis)
        return sorted(found)

    def listed(self, name: str) -> bool:
        """Whether a quantity has values in a list, with nothing between them."""
        return bool(self.asked.choices[name].values)

    def whole(self, looked_at: Iterable[Candidate]) -> bool:
        """Whether these are all candidates that there are, which are finitely many where all values are in lists."""
        if not all(map(self.listed, self.names)):
            return False
        return len(set(looked_at)) == math.prod(len(self.asked.choices[name].values) for name in self.names)

    def fine(self, step: float) -> bool:
        """Whether half the step is finer than anybody could build, or than the finest."""
        if step / 2 < FINEST:
            return True
        return all(
            name in self.asked.tolerances and self._width(name) * step <= self._built(name)
            for name in self.names
        )

    def apart(self, one: Candidate, other: Candidate) -> float:
        """Give the distance of two candidates: the largest difference of a share."""
        return max((abs(a - b) for a, b in zip(one, other, strict=True)), default=0.0)

    def _built(self, name: str) -> float:
        """Give the tolerance at the middle of a range, in its unit, or as a share where steps are shares."""
        choice = self.asked.choices[name]
        middle = choice.at(0.5)
        size = self.asked.tolerances[name].of(middle)
        return math.log1p(size / middle) if choice.logarithmic else size

    def _width(self, name: str) -> float:
        choice = self.asked.choices[name]
        return math.log(choice.stop / choice.start) if choice.logarithmic else choice.stop - choice.start

    def _step(self, name: str, step: float) -> float:
        count = len(self.asked.choices[name].values)
        return max(step, 1.0 / (count - 1)) if count else step

    def _onto(self, name: str, shares: Iterable[float]) -> list[float]:
        """Put shares into the range, and on the values of a list."""
        count = len(self.asked.choices[name].values)
        held = {min(max(share, 0.0), 1.0) for share in shares}
        return sorted({round(share * (count - 1)) / (count - 1) for share in held} if count else held)
