"""A map cut and thinned: what stays are grid points as they were, the ends among them."""

from typing import Any

import numpy as np
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st

from damperlab.studies.answers.query_fault import QueryFault
from damperlab.studies.answers.window import window


def _map(rows: int, columns: int) -> xr.Dataset:
    values = np.arange(rows * columns, dtype=float).reshape(rows, columns)
    dims = ("friction_ratio", "clearance_ratio")
    coordinates: dict[str, Any] = {dims[0]: np.linspace(0, 1, rows), dims[1]: np.geomspace(1, 10, columns)}
    variables = {"amplitude_ratio": (dims, values), "status": (dims, np.zeros((rows, columns), np.int8))}
    return xr.Dataset(variables, coordinates, {"note": "At r = 1."})


@settings(max_examples=30, deadline=None, derandomize=True)
@given(rows=st.integers(1, 40), columns=st.integers(1, 40), most=st.integers(2, 45))
def test_what_stays_is_what_was_there_and_its_ends(rows: int, columns: int, most: int) -> None:
    whole = _map(rows, columns)
    thin = window(whole, most=most)
    for name in thin["amplitude_ratio"].dims:
        assert thin.sizes[name] == min(most, whole.sizes[name])
        assert thin[name].values[0] == whole[name].values[0]
        assert thin[name].values[-1] == whole[name].values[-1]
        # evenly spaced lines: no two gaps differ by more than one line
        kept = np.searchsorted(whole[name].values, thin[name].values)
        assert np.ptp(np.diff(kept)) <= 1 if kept.size > 1 else True
    again = whole["amplitude_ratio"].sel({name: thin[name] for name in thin["amplitude_ratio"].dims})
    np.testing.assert_array_equal(again.values, thin["amplitude_ratio"].values)
    assert thin.attrs["thinned"] == (most < max(rows, columns))


def test_a_part_is_whole_where_it_is_small_and_says_nothing() -> None:
    part = window(_map(11, 11), {"friction_ratio": (0.2, 0.5)}, most=11)
    np.testing.assert_allclose(part["friction_ratio"].values, [0.2, 0.3, 0.4, 0.5])
    assert part.sizes["clearance_ratio"] == 11
    assert part.attrs == {"note": "At r = 1.", "thinned": False}


def test_a_map_that_was_thinned_says_so() -> None:
    note = window(_map(11, 3), most=4).attrs["note"]
    assert note.startswith("At r = 1. 4 of 11 values of friction ratio γ_F are shown.")
    assert "clearance_ratio" not in note


def test_a_part_without_a_grid_point_is_refused_with_what_there_is() -> None:
    with pytest.raises(QueryFault) as refused:
        window(_map(11, 11), {"friction_ratio": (0.41, 0.42)})
    assert "the study has 11 values from 0 to 1" in str(refused.value)


@settings(max_examples=30, deadline=None, derandomize=True)
@given(
    rows=st.integers(1, 60),
    columns=st.integers(1, 60),
    most=st.integers(4, 20),
    data=st.data(),
)
def test_the_largest_and_the_smallest_value_stay(
    rows: int, columns: int, most: int, data: st.DataObject
) -> None:
    whole = _map(rows, columns)
    values = np.full((rows, columns), 5.0)
    where = st.tuples(st.integers(0, rows - 1), st.integers(0, columns - 1))
    hole, peak, pit = data.draw(where), data.draw(where), data.draw(where)
    values[hole] = np.nan
    values[peak] = 447.3
    if pit != peak:
        values[pit] = 0.2
    whole["amplitude_ratio"][:] = values
    thin = window(whole, most=most)
    shown = thin["amplitude_ratio"].values
    assert max(shown.shape) <= most
    assert np.nanmax(shown) == np.nanmax(values)
    assert np.nanmin(shown) == np.nanmin(values)


def test_the_extremes_are_those_of_the_part_and_codes_have_none() -> None:
    whole = _map(101, 3)
    whole["amplitude_ratio"][50] = 1e6
    part = window(whole, {"friction_ratio": (0.0, 0.4)}, most=5)
    assert part["amplitude_ratio"].max() == whole["amplitude_ratio"][:41].max()
    assert "The largest and the smallest value are among those shown." in part.attrs["note"]
    codes = whole.rename(amplitude_ratio="response_class")
    codes["response_class"].attrs["flag_values"] = [0, 1]
    assert "largest" not in window(codes, most=5).attrs["note"]
