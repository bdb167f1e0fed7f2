"""A coordinate is the double nearest to its exact value, so it is the same in every range that holds it."""

from decimal import Decimal, localcontext
from fractions import Fraction

import numpy as np
import pytest

from damperlab.studies.axes import Range


def values(start: float, stop: float, num: int, spacing: str = "linear") -> np.ndarray:
    return Range.model_validate({"start": start, "stop": stop, "num": num, "spacing": spacing}).values()


@pytest.mark.parametrize(
    ("start", "stop", "num"),
    [
        (0.5, 1.5, 101),
        (0, 0.8, 33),
        (0.1, 0.7, 1001),
        (1, 25, 49),
        (-0.3, 0.7, 11),
        (1e-12, 1e12, 1001),
        (0.1 + 0.2, 0.9, 7),
        (2.0, 2.0, 1),
    ],
)
def test_every_value_is_the_double_nearest_to_the_exact_one(start: float, stop: float, num: int) -> None:
    first, last = Fraction(repr(float(start))), Fraction(repr(float(stop)))
    exact = [first + (last - first) * i / max(1, num - 1) for i in range(num)]
    # float() of a fraction is correctly rounded
    assert values(start, stop, num).tolist() == [float(value) for value in exact]


def test_decimal_steps_are_the_decimals_that_they_look_like() -> None:
    # sums of doubles give 0.7250000000000001 here
    assert values(0.5, 1.5, 401).tolist() == [float(f"{0.5 + i / 400:.4f}") for i in range(401)]


@pytest.mark.parametrize(("start", "stop", "num"), [(0.3, 1.7, 141), (0.5, 1.5, 1001), (0.5, 2.5, 201)])
def test_a_wider_range_and_a_finer_step_hold_every_value(start: float, stop: float, num: int) -> None:
    assert np.isin(values(0.5, 1.5, 101), values(start, stop, num)).all()


@pytest.mark.parametrize(
    ("start", "stop", "num"), [(0.5, 2, 5), (1e-3, 1e3, 61), (0.1, 0.7, 1001), (3e-9, 5, 4)]
)
def test_log_values_are_within_half_a_unit_of_the_exact_ones(start: float, stop: float, num: int) -> None:
    found = values(start, stop, num, "log")
    with localcontext() as context:
        context.prec = 60
        first, last = Decimal(repr(float(start))), Decimal(repr(float(stop)))
        for i, value in enumerate(found.tolist()):
            exact = first * ((last / first).ln() * i / (num - 1)).exp()
            # half a unit in the last place, and the rounding of 60 digits
            assert abs(Decimal(value) - exact) <= Decimal(float(np.spacing(value))) / 2 * (
                1 + Decimal(10) ** -30
            )


def test_decades_are_powers_of_ten_and_halved_steps_hold_every_value() -> None:
    assert values(1e-3, 1e3, 7, "log").tolist() == [1e-3, 1e-2, 0.1, 1.0, 10.0, 100.0, 1000.0]
    assert np.isin(values(0.1, 10, 101, "log"), values(0.1, 10, 201, "log")).all()
    assert np.isin(values(0.1, 10, 21, "log"), values(0.01, 100, 41, "log")).all()


def test_a_million_values_increase_and_end_where_they_should() -> None:
    for spacing in ("linear", "log"):
        found = values(0.1, 3.7, 1_000_000, spacing)
        assert (np.diff(found) > 0).all()
        assert (found[0], found[-1]) == (0.1, 3.7)
