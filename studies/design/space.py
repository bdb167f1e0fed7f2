"""The dampers of the search, the amplitudes for judging them, and the corners of the tolerances."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

from damperlab.studies.cavity import cavity_of
from damperlab.studies.design.build import Build
from damperlab.studies.specification.excitation import Under
from damperlab.studies.specification.specification import CHOSEN, OF_DAMPER, Specification

Candidate = tuple[float, ...]
"""Fractions of the ranges of the chosen quantities, from 0 to 1, in the order of `OF_DAMPER`."""

GRAIN = 2048
"""Number of steps of a range. Candidates are rounded to these steps, so that two processors whose results differ in the
last digit examine the same dampers.
"""
MOST_LISTED = 100
"""Largest number of combinations of listed values for which every combination is examined."""


@dataclass(frozen=True)
class Space:
    """The candidates of a specification.

    Parameters
    ----------
    asked : Specification
        The specification, with the ranges of the quantities.
    """

    asked: Specification

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the chosen quantities."""
        return self.asked.free

    @property
    def counts(self) -> tuple[int, ...]:
        """Number of listed values of each chosen quantity; 0 for a range."""
        return tuple(len(self.asked.choices[name].values) for name in self.names)

    def build(self, candidate: Candidate) -> Build:
        """Return the nominal damper of a candidate."""
        chosen = dict(zip(self.names, candidate, strict=True))
        values = {name: self.asked.choices[name].at(chosen.get(name, 0.0)) for name in OF_DAMPER}
        share = chosen.get("restitution", 0.0)
        contact_time_s = self.asked.choices["restitution"].contact_time_s(share)
        drawn = {name: values[name] for name in CHOSEN}
        return Build(**drawn, contact_time_s=contact_time_s, cavity=cavity_of(values))

    def candidate(self, shares: Sequence[float]) -> Candidate:
        """Round fractions of the ranges to the nearest candidate: to listed values, or to steps of `1 / GRAIN`."""
        parts = (count - 1 if count else GRAIN for count in self.counts)
        return tuple(
            round(min(max(float(share), 0.0), 1.0) * part) / part
            for share, part in zip(shares, parts, strict=True)
        )

    def every(self) -> list[Candidate]:
        """Return all combinations of listed values; empty if a quantity has a range, or if there are too many."""
        if not all(self.counts) or math.prod(self.counts) > MOST_LISTED:
            return []
        return list(product(*([k / (count - 1) for k in range(count)] for count in self.counts)))


FACTORIAL = 3
"""Largest number of tolerances for which the search examines every corner. With more than `FACTORIAL` tolerances, it
examines a balanced fraction of the corners: the two-level design `HADAMARD`, with a column for each
tolerance.
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
"""A two-level design of eight runs for seven factors. Every pair of columns is balanced."""


def amplitudes_of(asked: Specification, count: int) -> tuple[Under, ...]:
    """Return amplitudes over the range of each excitation, and every case of ground-motion records."""
    over = (amplitude for each in asked.excitations for amplitude in each.amplitudes(count))
    return (*over, *asked.cases)


def corners_of(asked: Specification) -> list[dict[str, float]]:
    """Return all corners of the tolerances; a balanced fraction for more than `FACTORIAL` tolerances."""
    names = asked.toleranced
    if len(names) <= FACTORIAL:
        return every_corner(asked)
    return [{name: float(sign) for name, sign in zip(names, row, strict=False)} for row in HADAMARD]


def every_corner(asked: Specification) -> list[dict[str, float]]:
    """Return all corners of the tolerances; none without tolerances."""
    names = asked.toleranced
    signs = product((-1.0, 1.0), repeat=len(names)) if names else ()
    return [dict(zip(names, row, strict=True)) for row in signs]
