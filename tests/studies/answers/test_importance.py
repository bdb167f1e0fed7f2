"""Shares of the variance of a result: closed forms on grids made by hand."""

import json

import numpy as np
import pytest
import xarray as xr

from damperlab.studies.answers.importance import importance
from damperlab.studies.questions import Varied
from damperlab.studies.variables import DIMENSIONS, Status

D, G, B = np.array([1.0, 2.0, 3.0, 6.0]), np.array([0.1, 0.2, 0.6]), np.array([0.05, 0.1])
R = np.array([0.9, 1.0, 1.1])


def made(value) -> xr.Dataset:
    """A study of clearance, friction and mass whose largest value over the frequency is `value(d, g, b)`."""
    axes = dict(zip(DIMENSIONS, ([0.01], [0.5], B, D, G, R), strict=True))
    b, d, g, r = np.meshgrid(B, D, G, R, indexing="ij")
    values = value(d, g, b) - 5 * (r - 1) ** 2
    shape = [len(axis) for axis in axes.values()]
    variables = {"amplitude_ratio": values, "status": np.zeros_like(values, np.int8)}
    return xr.Dataset({name: (DIMENSIONS, array.reshape(shape)) for name, array in variables.items()}, axes)


def centred(x: np.ndarray, axis: np.ndarray) -> np.ndarray:
    return x - axis.mean()


def test_shares_of_a_sum_and_a_product_are_the_closed_form() -> None:
    cube = made(
        lambda d, g, b: (
            1e6 + 2 * centred(d, D) + 7 * centred(g, G) + 3 * centred(d, D) * centred(g, G) + 0 * b
        )
    )
    # the terms are orthogonal on the grid, so the variance is the sum of theirs
    parts = np.array([4 * D.var(), 49 * G.var(), 9 * D.var() * G.var()])
    found = importance(cube)
    share = dict(zip(found["dimension"].values, found["share"].values, strict=True))
    # the values are 1e6 and their spread is 5: what is lost is 1e6 / 5 of a rounding, squared terms twice
    close = {"abs": 1e-8}
    assert share["clearance_ratio"] == pytest.approx(parts[0] / parts.sum(), **close)
    assert share["friction_ratio"] == pytest.approx(parts[1] / parts.sum(), **close)
    assert share["mass_ratio"] == pytest.approx(0, **close)
    assert found.attrs["interactions"] == pytest.approx(parts[2] / parts.sum(), **close)
    assert found["dimension"].values.tolist() == sorted(share, key=lambda name: -share[name])
    effect = dict(zip(found["dimension"].values, found["effect"].values, strict=True))
    assert effect["clearance_ratio"] == pytest.approx(2 * np.ptp(D), rel=1e-8)
    assert found.attrs["standard_deviation"] == pytest.approx(np.sqrt(parts.sum()), rel=1e-8)
    assert found.attrs["mean"] == pytest.approx(1e6, rel=1e-12)
    assert (found.attrs["designs"], found.attrs["without"], found.attrs["over"]) == (24, 0, "frequency_ratio")


def test_slab_by_slab_it_is_the_same_and_a_range_is_a_smaller_grid(monkeypatch: pytest.MonkeyPatch) -> None:
    cube = made(lambda d, g, b: np.exp(d * g) + b * d)
    whole = importance(cube)
    monkeypatch.setattr("damperlab.studies.answers.slab.BUDGET", 1)
    cube["amplitude_ratio"].encoding["chunks"] = (1, 1, 1, 2, 1, 3)
    np.testing.assert_allclose(importance(cube)["share"], whole["share"], rtol=1e-12)
    part = importance(cube, Varied(ranges={"clearance_ratio": (2, 6), "frequency_ratio": (1.05, 1.2)}))
    np.testing.assert_allclose(
        part["share"], importance(cube.isel(clearance_ratio=slice(1, None), frequency_ratio=[2]))["share"]
    )
    assert dict(zip(part["dimension"].values, part["number"].values, strict=True))["clearance_ratio"] == 3


def test_designs_without_a_value_are_left_out_and_counted_and_nothing_is_made_of_nothing() -> None:
    cube = made(lambda d, g, b: d + 0 * g)
    cube["status"][0, 0, 0, 1, 2, 0] = Status.NOT_COMPUTED
    cube["amplitude_ratio"][0, 0, 1, 0, 0, :] = np.nan
    found = importance(cube)
    assert found.attrs["without"] == 2
    assert "need not add up" in found.attrs["note"]
    assert found["share"].sel(dimension="clearance_ratio") == pytest.approx(1)
    level = importance(made(lambda d, g, b: 3 + 0 * d))
    assert np.isnan(level["share"]).all()
    assert "nothing matters" in level.attrs["note"]
    cube["status"][:] = Status.NOT_COMPUTED
    assert "None has a value yet" in importance(cube).attrs["note"]


def test_in_units_the_shares_are_the_same_and_the_effect_is_a_length() -> None:
    cube = made(lambda d, g, b: d + g)
    structure = {"mass_kg": 2.0, "natural_frequency_hz": 4.0, "base_amplitude_m": 0.003}
    cube.attrs["study"] = json.dumps({"physical": structure})
    ratios, units = importance(cube), importance(cube, Varied("amplitude_m", {"clearance_m": (0.0, 1.0)}))
    np.testing.assert_array_equal(ratios["share"], units["share"])
    np.testing.assert_allclose(units["effect"], ratios["effect"] * 0.003, rtol=1e-15)
    assert units["effect"].attrs["units"] == "m"
    assert "clearance d" in units.attrs["in_units"]["note"]
