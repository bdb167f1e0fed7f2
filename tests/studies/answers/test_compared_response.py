"""Two studies of one design: hysteresis that was computed, and what cannot be compared."""

import numpy as np
import pytest
import xarray as xr

from damperlab.studies.answers.compared_response import compared_response
from damperlab.studies.answers.faults import QueryFault
from damperlab.studies.definition import parse_study
from damperlab.studies.plan import Block
from damperlab.studies.questions import Selection
from damperlab.studies.variables import DIMENSIONS, VARIABLES, Status
from damperlab.worker.block import solve_block

FREQUENCIES = [1.05, 1.07, 1.09, 1.095, 1.1, 1.105, 1.11, 1.115, 1.12, 1.15]


def swept(direction: str) -> xr.Dataset:
    """The cube of a hysteresis study, solved here."""
    axes = {"clearance_ratio": 2, "friction_ratio": 0.6, "restitution": 0.47, "mass_ratio": 0.1}
    study = parse_study(
        {
            "damping_ratio": 0.0038,
            "axes": axes | {"frequency_ratio": FREQUENCIES},
            "start": {"kind": "continuation", "direction": direction},
        }
    )
    values = solve_block(study, Block(0, (0,) * 6, study.shape))
    attributes = {
        name: {"units": v.units, "long_name": v.long_name} | ({"flag_values": [0]} if v.flags else {})
        for name, v in VARIABLES.items()
    }
    return xr.Dataset(
        {name: (DIMENSIONS, array, attributes[name]) for name, array in values.items()}, study.coordinates
    )


def test_the_ways_up_and_down_differ_where_two_responses_are_stable() -> None:
    answer = compared_response(swept("up"), swept("down"))
    place = FREQUENCIES.index(1.1)
    # the symmetric response and the one with its symmetry broken, both stable there
    assert answer["amplitude_ratio"].values[place] == pytest.approx(2.09540163, abs=1e-7)
    assert answer["other"].values[place] == pytest.approx(1.67530417, abs=1e-7)
    assert answer["differs"].values[place] == 1
    assert answer["differs"].values[-1] == 0  # above, the branches have met
    (span,) = [s for s in answer.attrs["apart"] if s[0] <= 1.1 <= s[1]]
    assert 1.07 <= span[0] < span[1] < 1.15
    distance = np.abs(answer["amplitude_ratio"] - answer["other"]).values
    assert answer.attrs["largest_difference"] == distance.max()
    assert f"r = {answer.attrs['largest_difference_at']:.6g}" in answer.attrs["note"]


def test_a_study_does_not_differ_from_itself_and_a_gap_is_no_difference(whole: xr.Dataset) -> None:
    at = {"clearance_ratio": 5.0, "restitution": 0.5, "friction_ratio": 0.2}
    whole["amplitude_error"][:] = 0.0
    whole["amplitude_ratio"].loc[{"frequency_ratio": 1.0}] = np.nan
    answer = compared_response(whole, whole, Selection(at=at))
    assert not answer["differs"].any()
    assert answer.attrs["apart"] == []
    assert "do not differ" in answer.attrs["note"]
    assert int(np.isnan(answer["amplitude_ratio"].values).sum()) == 1
    assert "At 1 frequency ratio one of the two has no value" in answer.attrs["note"]
    shifted = whole.copy(deep=True)
    shifted["amplitude_ratio"] += 0.1
    missing = whole["amplitude_ratio"].sel(at, method="nearest").values.ravel()
    differs = compared_response(whole, shifted, Selection(at=at))["differs"].values
    np.testing.assert_array_equal(differs == 1, np.isfinite(missing))
    # within three errors of each other nothing is claimed
    shifted["amplitude_error"] += 0.05
    assert not compared_response(whole, shifted, Selection(at=at))["differs"].any()


def test_of_a_study_that_has_computed_nothing_no_difference_is_denied(whole: xr.Dataset) -> None:
    empty = whole.copy(deep=True)
    empty["amplitude_ratio"][:] = np.nan
    empty["status"][:] = Status.NOT_COMPUTED
    for pair in ((whole, empty), (empty, whole)):
        assert compared_response(*pair).attrs["note"].endswith("No frequency has a value in both studies.")


def test_what_cannot_be_compared_is_refused(whole: xr.Dataset) -> None:
    for other, metric, field in (
        (whole.isel(frequency_ratio=slice(3)), "amplitude_ratio", "with"),
        (whole.assign_coords(mass_ratio=[0.2]), "amplitude_ratio", "with"),
    ):
        with pytest.raises(QueryFault) as caught:
            compared_response(whole, other, Selection(metric))
        assert caught.value.fault.field == field
    coded = whole.copy()
    coded["response_class"].attrs["flag_values"] = [0]
    with pytest.raises(QueryFault, match="a quantity"):
        compared_response(coded, coded, Selection("response_class"))
