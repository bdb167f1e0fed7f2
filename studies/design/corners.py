"""What every damper is judged under, and the corners of its tolerances."""

from itertools import product

from damperlab.studies.specification.records import Under
from damperlab.studies.specification.specification import Specification

FACTORIAL = 3
"""Tolerances up to which every corner is looked at; of more, a fraction in which no two share a column."""
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
    """Give amplitudes over the range of each excitation, and of ground-motion records every case."""
    over = (amplitude for each in asked.excitations for amplitude in each.amplitudes(count))
    return (*over, *asked.cases)


def corners_of(asked: Specification) -> list[dict[str, float]]:
    """Give the corners of the tolerances: every one of a few, else a balanced fraction of them."""
    return corners(asked.toleranced) if asked.tolerances else []


def corners(names: list[str]) -> list[dict[str, float]]:
    """Give the signs of quantities at corners: every one of a few quantities, else a balanced fraction of them."""
    signs = HADAMARD if len(names) > FACTORIAL else tuple(product((-1, 1), repeat=len(names)))
    return [{name: float(sign) for name, sign in zip(names, row, strict=False)} for row in signs]
