"""The best damper of a survey lies where its axes end, or does not, or could not lie elsewhere."""

import numpy as np
import pytest
import xarray as xr

from damperlab.studies.answers.suite import worst_case_designs
from damperlab.studies.ground.variables import DIMENSIONS, RECORD

CLEARANCE = np.array([0.005, 0.01, 0.02])
FRICTION = np.array([0.0, 1.0, 2.0])
PEAK = "peak_relative_displacement_m"


def made(values: np.ndarray) -> xr.Dataset:
    """A suite of two records: values over clearance and friction, of the second record half as much."""
    axes = dict.fromkeys(DIMENSIONS, np.array([0.5])) | {
        RECORD: np.array(["one", "two"]),
        "clearance_m": CLEARANCE,
        "friction_force_n": FRICTION,
    }
    shape = tuple(axes[name].size for name in DIMENSIONS)
    over = [{RECORD: 0, "clearance_m": 1, "friction_force_n": 2}.get(name) for name in DIMENSIONS]
    three = np.array([1.0, 0.5])[:, None, None] * np.asarray(values)
    placed = three.transpose([at for at in over if at is not None]).reshape(shape)
    status = np.zeros(shape, np.int8)
    return xr.Dataset({PEAK: (DIMENSIONS, placed), "status": (DIMENSIONS, status)}, axes)


def ends(values: list[list[float]], **asked: object) -> dict[str, list[object]]:
    notes = worst_case_designs(made(np.array(values)), PEAK, **asked).attrs["notes"]  # type: ignore[arg-type]
    return notes[0]["values"] if notes else {}


def test_the_best_damper_at_the_end_of_an_axis_is_said_to_be():
    rises = [[3.0, 2.5, 2.2], [2.0, 1.6, 1.3], [1.5, 1.1, 0.9]]
    both = {"clearance_m": ["upper", 0.02], "friction_force_n": ["upper", 2.0]}
    assert ends(rises) == ends(rises, records=["two"]) == both
    # a range that was asked for ends before the axis does, and says nothing of what lies beyond
    assert ends(rises, ranges={"friction_force_n": (0.0, 1.0)}).keys() == {"clearance_m"}


@pytest.mark.parametrize(
    "values",
    [
        [[3.0, 2.0, 3.0], [2.0, 1.0, 2.0], [3.0, 2.0, 3.0]],  # inside
        [[3.0, 3.5, 4.0], [1.0, 1.2, 1.5], [3.0, 3.5, 4.0]],  # friction is never less than none
        [[1.00, 1.05, 1.08], [1.01, 1.06, 1.09], [1.02, 1.07, 1.09]],  # as good all along
    ],
)
def test_elsewhere_nothing_is_said(values: list[list[float]]):
    assert ends(values) == {}
