"""Two studies of one design: where they differ, by how much, and what cannot be compared."""

import numpy as np
import pytest
import xarray as xr

from damperlab.studies.answers.compared_response import compared_response
from damperlab.studies.questions import Selection
from damperlab.studies.variables import Status


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
    answer = compared_response(whole, shifted, Selection(at=at))
    np.testing.assert_array_equal(answer["differs"].values == 1, np.isfinite(missing))
    assert answer.attrs["apart"]
    distance = float(np.abs(answer["amplitude_ratio"] - answer["other"]).max())
    assert answer.attrs["largest_difference"] == distance == pytest.approx(0.1)
    assert f"r = {answer.attrs['largest_difference_at']:.6g}" in answer.attrs["note"]
    # within three errors of each other nothing is claimed
    shifted["amplitude_error"] += 0.05
    assert not compared_response(whole, shifted, Selection(at=at))["differs"].any()


def test_of_a_study_that_has_computed_nothing_no_difference_is_denied(whole: xr.Dataset) -> None:
    empty = whole.copy(deep=True)
    empty["amplitude_ratio"][:] = np.nan
    empty["status"][:] = Status.NOT_COMPUTED
    for pair in ((whole, empty), (empty, whole)):
        assert compared_response(*pair).attrs["note"].endswith("No frequency has a value in both studies.")
