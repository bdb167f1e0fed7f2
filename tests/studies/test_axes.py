"""Axes: three spellings, one set of increasing values."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from damperlab.studies.axes import Range, axis_count, axis_values, read_axis
from damperlab.studies.faults import StudyFaults
from damperlab.studies.quantity import CLEARANCE_RATIO, FRICTION_RATIO


def fields(raw: object) -> list[str]:
    with pytest.raises(StudyFaults) as caught:
        read_axis(raw, FRICTION_RATIO, "x")
    return [fault.field for fault in caught.value.faults]


def test_a_list_is_a_set_of_values_and_comes_out_sorted() -> None:
    assert read_axis([3, 1.5, 2], FRICTION_RATIO) == (1.5, 2.0, 3.0)


def test_minus_zero_is_zero() -> None:
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


def test_single_value_range_is_that_value() -> None:
    spec = read_axis({"start": 5, "stop": 5.0, "num": 1}, CLEARANCE_RATIO)
    assert axis_values(spec).tolist() == [5.0]


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
