"""The dampers of the search, the amplitudes for judging them, and the corners of the tolerances."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

from damperlab.studies.cavity import cavity_of
from damperlab.studies.design.build import Build
from damperlab.studies.specification.records import Under
from damperlab.studies.specification.specification import CHOSEN, OF_DAMPER, Specification

Candidate = tuple[float, ...]
"""Fractions of the ranges of the chosen quantities, from 0 to 1, in the order of `OF_DAMPER`."""

GRAIN = 2048
"""Candidates are rounded to this fraction of a range, so that two processors that differ in the last digit examine
the same dampers.
"""
MOST_LISTED = 100
"""Up to this number of combinations of listed values, all are examined."""


@dataclass(frozen=True)
class Space:
    """The candidates of a specification.

    Parameters
    ----------
    asked : Specification
        The ranges of its quantities.
    """

    asked: Specification

    @property
    def names(self) -> tuple[str, ...]:
        """The chosen quantities."""
        return self.asked.free

    @property
    def counts(self) -> tuple[int, ...]:
        """Number of values of each quantity; 0 for a range."""
        return tuple(len(self.asked.choices[name].values) for name in self.names)

    def build(self, candidate: Candidate) -> Build:
        """Give the damper of a candidate, without quantities that have no effect on it."""
        chosen = dict(zip(self.names, candidate, strict=True))
        values = {name: self.asked.choices[name].at(chosen.get(name, 0.0)) for name in OF_DAMPER}
        share = chosen.get("restitution", 0.0)
        contact_time_s = self.asked.choices["restitution"].contact_time_s(share)
        drawn = {name: values[name] for name in CHOSEN}
        return Build(**drawn, contact_time_s=contact_time_s, cavity=cavity_of(values))

    def candidate(self, shares: Sequence[float]) -> Candidate:
        """Round fractions to those of listed values, or to the grain of a range."""
        parts = (count - 1 if count else GRAIN for count in self.counts)
        return tuple(
            round(min(max(float(share), 0.0), 1.0) * part) / part
            for share, part in zip(shares, parts, strict=True)
        )

    def every(self) -> list[Candidate]:
        """Give all combinations of listed values if there are few; else none."""
        if not all(self.counts) or math.prod(self.counts) > MOST_LISTED:
            return []
        return list(product(*([k / (count - 1) for k in range(count)] for count in self.counts)))


FACTORIAL = 3
"""Number of tolerances up to which every corner is examined; for more, a balanced fraction: the two-level design
`HADAMARD`, with a column for each tolerance.
"""
HADAMARD = (
    (1, 1, 1, 1, 1, 1, 1),
    (-1, 1, -1, 1, -1, 1, -1),
    (1, -1, -1, 1, 1, -1, -1),
    (-1, -1, 1, 1, -1, -1, 1),
    (1, 1, 1, -1, -1, -1, -1),
    (-1, 1, -1, -1, 1, -1, 1),
    (1, -1, -1, -1, -1, 1, 1),
    (-1, -1, 1, -1, 1, 1, -1),
)
"""A two-level design of eight runs for seven factors, every pair of columns balanced."""


def amplitudes_of(asked: Specification, count: int) -> tuple[Under, ...]:
    """Give amplitudes over the range of each excitation, and every case of ground-motion records."""
    over = (amplitude for each in asked.excitations for amplitude in each.amplitudes(count))
    return (*over, *asked.cases)


def corners_of(asked: Specification) -> list[dict[str, float]]:
    """Give the corners of the tolerances: all if there are few tolerances, else a balanced fraction."""
    names = asked.toleranced
    if not names:
        return []
    signs = HADAMARD if len(names) > FACTORIAL else tuple(product((-1, 1), repeat=len(names)))
    return [{name: float(sign) for name, sign in zip(names, row, strict=False)} for row in signs]
