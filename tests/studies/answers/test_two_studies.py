"""Two studies: what is subtracted, where they differ and by how much, and what cannot be subtracted."""

import json

import numpy as np
import pytest
import xarray as xr

from damperlab.service.cli.words import map_brief
from damperlab.studies.answers.compared_response import compared_response
from damperlab.studies.answers.map_difference import map_difference
from damperlab.studies.answers.phrases import Phrases
from damperlab.studies.answers.query_fault import QueryFault
from damperlab.studies.answers.resonance_map import resonance_map
from damperlab.studies.answers.window import window
from damperlab.studies.questions import Selection
from damperlab.studies.variables import Status

AXES = ("clearance_ratio", "friction_ratio")
PHYSICAL = {"mass_kg": 1.605, "natural_frequency_hz": 2.5, "base_amplitude_m": 0.0015}


def told(cube: xr.Dataset, **parts: object) -> xr.Dataset:
    """The cube of another definition."""
    return cube.assign_attrs(study=json.dumps(json.loads(cube.attrs["study"]) | parts))


@pytest.fixture
def other(whole: xr.Dataset) -> xr.Dataset:
    """A second study on the same grid: other values, another mass, other gaps."""
    rng = np.random.default_rng(5)
    second = whole.copy(deep=True).assign_coords(mass_ratio=[0.2])
    second["amplitude_ratio"] += rng.uniform(-1.0, 1.0, second["amplitude_ratio"].shape)
    second["amplitude_ratio"][0, 0, 0, 2, 1, 3] = np.nan
    return second


def test_the_difference_is_that_of_the_cubes(whole: xr.Dataset, other: xr.Dataset) -> None:
    at = {"frequency_ratio": 1.0, "restitution": 0.2}
    answer = map_difference(whole, other, *AXES, Selection(at=at))
    mine, its = (
        cube["amplitude_ratio"].sel(at).squeeze(drop=True).transpose("friction_ratio", "clearance_ratio")
        for cube in (whole, other)
    )
    np.testing.assert_array_equal(answer["amplitude_ratio"].values, mine.values)
    np.testing.assert_array_equal(answer["other"].values, its.values)
    np.testing.assert_array_equal(answer["difference"].values, mine.values - its.values)
    assert np.isnan(answer["difference"].values).sum() > np.isnan(mine.values).sum()
    lowest = float((mine - its).min())
    place = (mine - its).where(mine - its == lowest, drop=True)
    note = answer.attrs["note"]
    assert f"by up to {-lowest:.4g} (d/Z = {place['clearance_ratio'].item():.6g}" in note
    assert "mass ratio β (0.1 and 0.2)" in note
    assert answer.attrs["other_at"] == {"mass_ratio": 0.2}
    brief = map_brief(answer, "amplitude_ratio", Phrases.of(whole), True, whole.sizes)
    assert f"by up to {-lowest:.4g} (d/Z" in brief.sentences[0]


def test_of_the_worst_over_the_band_each_study_has_its_own(whole: xr.Dataset, other: xr.Dataset) -> None:
    answer = map_difference(whole, other, *AXES)
    # at one place, that of the best design of the first
    there = Selection(at={"restitution": answer["restitution"].item()})
    assert there.at["restitution"] == resonance_map(whole, *AXES)["restitution"].item()
    first, second = (resonance_map(cube, *AXES, there)["amplitude_ratio"].values for cube in (whole, other))
    np.testing.assert_array_equal(answer["difference"].values, first - second)


def test_in_units_either_study_has_its_own_structure(whole: xr.Dataset) -> None:
    first = told(whole, physical=PHYSICAL)
    same = map_difference(first, first, "clearance_m", "friction_force_n", Selection("amplitude_m"))
    assert same["difference"].attrs["units"] == "m"
    far = map_difference(first, first.assign(amplitude_ratio=first["amplitude_ratio"] + 2.0), *AXES)
    assert "by up to 3 mm (d = " in far.attrs["in_units"]["note"]
    heavy = first.assign_coords(mass_ratio=[0.2])
    told_once = map_difference(
        first, heavy, "clearance_m", "friction_force_n", Selection("amplitude_m")
    ).attrs
    assert told_once["other_at"] == {"particle_mass_kg": 0.2 * PHYSICAL["mass_kg"]}
    assert "mass of the particle m (0.1605 and 0.321 kg)" in told_once["in_units"]["studies_differ"]
    with pytest.raises(QueryFault, match=r"mass of the particle m: 0\.1605 kg in the first"):
        compared_response(first, heavy)
    # twice the motion of the base is twice the amplitude of the same ratio, at clearances that are twice as wide
    wide = told(whole, physical=PHYSICAL | {"base_amplitude_m": 0.003})
    answer = map_difference(first, wide, *AXES, Selection("amplitude_m"))
    np.testing.assert_allclose(answer["difference"].values, -answer["amplitude_m"].values, rtol=1e-12)
    assert "`physical.base_amplitude_m`" in answer.attrs["note"]
    with pytest.raises(
        QueryFault, match=r"5 values from 1\.5 to 30 mm in the first, 5 values from 3 to 60 mm"
    ):
        map_difference(first, wide, "clearance_m", "friction_ratio")
    ratios = map_difference(first, wide, *AXES)
    assert "mm" not in ratios.attrs["in_units"]["note"].split("frequency")[-1]
    with pytest.raises(QueryFault, match="not given in the units that clearance_m needs"):
        map_difference(first, whole, "clearance_m", "friction_ratio")


def test_what_is_beyond_the_errors_is_counted(whole: xr.Dataset) -> None:
    shifted = whole.copy(deep=True)
    shifted["amplitude_ratio"] += 0.3
    for error, beyond in ((0.01, True), (0.2, False)):
        for cube in (whole, shifted):
            cube["amplitude_error"][:] = error
        answer = map_difference(whole, shifted, *AXES)
        count = int(np.isfinite(answer["difference"].values).sum())
        assert f"lower at {count} of {count} points, by up to 0.3 " in answer.attrs["note"]
        assert f"at {count if beyond else 0} the difference is more than 3 times" in answer.attrs["note"]


def test_where_the_frequency_is_named_another_band_no_longer_counts(whole: xr.Dataset) -> None:
    at, narrow = {"frequency_ratio": 1.0}, whole.isel(frequency_ratio=slice(2, None))
    assert map_difference(whole, narrow, *AXES, Selection(at=at))["difference"].max() == 0


def test_a_thinned_map_keeps_the_largest_and_the_smallest_difference(
    whole: xr.Dataset, other: xr.Dataset
) -> None:
    answer = map_difference(whole, other, "clearance_ratio", "frequency_ratio")
    thin = window(answer, most=4)
    assert thin.sizes["frequency_ratio"] == 4
    assert float(thin["difference"].max()) == float(answer["difference"].max())
    assert float(thin["difference"].min()) == float(answer["difference"].min())


def test_a_study_does_not_differ_from_itself_and_a_gap_is_no_difference(whole: xr.Dataset) -> None:
    at = {"clearance_ratio": 5.0, "restitution": 0.5, "friction_ratio": 0.2}
    whole["amplitude_error"][:] = 0.0
    whole["amplitude_ratio"].loc[{"frequency_ratio": 1.0}] = np.nan
    answer = compared_response(whole, whole, Selection(at=at))
    assert not answer["differs"].any()
    assert answer.attrs["apart"] == []
    assert "differ nowhere" in answer.attrs["note"]
    assert int(np.isnan(answer["amplitude_ratio"].values).sum()) == 1
    shifted = whole.copy(deep=True)
    shifted["amplitude_ratio"] += 0.1
    missing = whole["amplitude_ratio"].sel(at, method="nearest").values.ravel()
    answer = compared_response(whole, shifted, Selection(at=at))
    np.testing.assert_array_equal(answer["differs"].values == 1, np.isfinite(missing))
    assert answer.attrs["apart"]
    distance = float(np.abs(answer["amplitude_ratio"] - answer["other"]).max())
    assert answer.attrs["largest_difference"] == distance == pytest.approx(0.1)
    assert f"r = {answer.attrs['largest_difference_at']:.6g}" in answer.attrs["note"]
    # within three errors of each other nothing is claimed
    shifted["amplitude_error"] += 0.05
    assert not compared_response(whole, shifted, Selection(at=at))["differs"].any()


def test_a_map_at_one_frequency_less_the_largest_over_a_band_is_refused(whole: xr.Dataset) -> None:
    for pair in ((whole.isel(frequency_ratio=[3]), whole), (whole, whole.isel(frequency_ratio=[3]))):
        with pytest.raises(QueryFault, match=r"6 values from 0\.7 to 1\.25"):
            map_difference(*pair, *AXES)


def test_of_a_study_that_has_computed_nothing_no_difference_is_denied(whole: xr.Dataset) -> None:
    empty = whole.copy(deep=True)
    empty["amplitude_ratio"][:] = np.nan
    empty["status"][:] = Status.NOT_COMPUTED
    for pair in ((whole, empty), (empty, whole)):
        assert compared_response(*pair).attrs["note"].endswith("No frequency has a value in both studies.")
