"""Axes: three spellings, one set of increasing values, each the double nearest to its exact value."""

import math
from decimal import Decimal, localcontext
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.studies.documents import fields_of

from damperlab.studies.axes import Range, axis_count, axis_values, read_axis
from damperlab.studies.faults import StudyFaults
from damperlab.studies.quantity import CLEARANCE_RATIO, FRICTION_RATIO


def fields(raw: object) -> list[str]:
    return fields_of(read_axis, raw, FRICTION_RATIO, "x")


def test_a_list_is_a_set_of_values_and_comes_out_sorted_and_minus_zero_is_zero() -> None:
    assert read_axis([3, 1.5, 2], FRICTION_RATIO) == (1.5, 2.0, 3.0)
    value = read_axis(-0.0, FRICTION_RATIO)
    assert math.copysign(1.0, value) == 1.0  # type: ignore[arg-type]
    assert fields([0, -0.0]) == ["x[1]"]


@pytest.mark.parametrize(
    ("raw", "where"),
    [
        ([1, 2, 1.0], ["x[2]"]),
        ([1, True, "2", None, [1]], ["x[1]", "x[2]", "x[3]", "x[4]"]),
        ([], ["x"]),
        ({}, ["x.start", "x.stop", "x.num"]),
        ({"start": 1, "stop": 0, "num": 2}, ["x.stop"]),
        ({"start": 1, "stop": 1, "num": 2}, ["x.stop"]),
        ({"start": 1, "stop": 2, "num": 1}, ["x.num"]),
        ({"start": 1, "stop": 2, "num": 0}, ["x.num"]),
        ({"start": 1, "stop": 2, "num": 2.5}, ["x.num"]),
        ({"start": 1, "stop": 2, "num": True}, ["x.num"]),
        ({"start": 1, "stop": 2, "num": 10**9}, ["x.num"]),
        ({"start": 1, "stop": 2, "num": 1e308}, ["x.num"]),
        ({"start": 1, "stop": 2, "num": math.nan}, ["x.num"]),
        ({"start": 0, "stop": 2, "num": 3, "spacing": "log"}, ["x.start"]),
        ({"start": 1, "stop": 2, "num": 3, "spacing": "cubic"}, ["x.spacing"]),
        ({"start": 1, "stop": 2, "num": 3, "spacing": []}, ["x.spacing"]),
        ({"start": 1, "stop": math.nextafter(1.0, 2.0), "num": 3}, ["x"]),
        ({"start": 1, "stop": math.nextafter(1.0, 2.0), "num": 3, "spacing": "log"}, ["x"]),
    ],
)
def test_faults_name_their_place(raw: Any, where: list[str]) -> None:
    assert fields(raw) == where


@given(
    st.floats(1e-12, 1e12),
    st.floats(1e-12, 1e12),
    st.integers(2, 300),
    st.sampled_from(["linear", "log"]),
)
@settings(deadline=None)
def test_a_range_that_is_accepted_increases_and_keeps_its_ends(
    a: float, b: float, num: int, spacing: str
) -> None:
    start, stop = sorted((a, b))
    try:
        spec = read_axis({"start": start, "stop": stop, "num": num, "spacing": spacing}, CLEARANCE_RATIO)
    except StudyFaults:
        # Refused only where the ends are so near that the values cannot be told apart: fewer floats than values,
        # or steps within the rounding of the spacing.
        assert stop - start <= 1e-12 * stop * num
        return
    values = axis_values(spec)
    assert isinstance(spec, Range)
    assert len(values) == axis_count(spec) == num
    assert values[0] == start
    assert values[-1] == stop
    assert (np.diff(values) > 0).all()


def values(start: float, stop: float, num: int, spacing: str = "linear") -> np.ndarray:
    return Range.model_validate({"start": start, "stop": stop, "num": num, "spacing": spacing}).values()


@pytest.mark.parametrize(
    ("start", "stop", "num"),
    [
        (0.5, 1.5, 101),
        (0.5, 1.5, 401),  # sums of doubles give 0.7250000000000001 here
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
