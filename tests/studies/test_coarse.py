"""The coarse sub-grid of a study: the same values, fewer of them, both ends of every axis."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from damperlab.studies.coarse import COARSE_POINTS, FEWEST_POINTS, SHARE, coarse
from damperlab.studies.definition import Study, parse_study

PHYSICAL = {"mass_kg": 1.3, "natural_frequency_hz": 7.9, "damping_n_s_per_m": 0.7}


def axis(count: int, start: float, stop: float) -> Any:
    return start if count == 1 else {"start": start, "stop": stop, "num": count}


def of_ratios(clearances: int, frictions: int, frequencies: int, **more: Any) -> Study:
    axes = {
        "clearance_ratio": axis(clearances, 0.3, 17.0),
        "friction_ratio": axis(frictions, 0.0, 0.7),
        "frequency_ratio": axis(frequencies, 0.83, 1.19),
        "restitution": 0.47,
        "mass_ratio": 0.1,
    }
    return parse_study({"name": "large", "damping_ratio": 0.01, "axes": axes, **more})


def of_dampers(clearances: int, forces: int, amplitudes: int, frequencies: int) -> Study:
    physical = PHYSICAL | {
        "clearance_m": axis(clearances, 1e-4, 7e-3),
        "friction_force_n": axis(forces, 0.1, 3.0),
        "base_amplitude_m": axis(amplitudes, 1e-4, 1e-3),
        "excitation_frequency_hz": axis(frequencies, 6.1, 9.7),
    }
    return parse_study({"physical": physical, "axes": {"restitution": 0.5, "mass_ratio": 0.07}})


def require_sub_grid(study: Study, found: Study) -> None:
    assert FEWEST_POINTS <= found.points <= min(COARSE_POINTS, study.points // SHARE)
    for name, values in study.coordinates.items():
        kept = found.coordinates[name]
        assert np.isin(kept, values).all(), name
        assert kept[0] == values[0], name
        assert kept[-1] == values[-1], name


@given(st.tuples(st.integers(1, 300), st.integers(1, 120), st.integers(1, 900)))
def test_a_sub_grid_has_values_of_the_study_alone_and_both_ends(counts: tuple[int, int, int]) -> None:
    study = of_ratios(*counts)
    found = coarse(study)
    if found is None:
        # whole numbers along three axes, each of two or more, may be (3/2)³ below what is allowed
        assert study.points < SHARE * FEWEST_POINTS * 1.5**3
    else:
        require_sub_grid(study, found)


def test_units_and_dampers_over_base_amplitudes_are_thinned_where_they_are_written() -> None:
    study = of_dampers(50, 40, 30, 30)
    found = coarse(study)
    assert found is not None
    require_sub_grid(study, found)
    assert found.over_amplitudes
    physical = PHYSICAL | {"clearance_m": axis(90, 1e-4, 7e-3), "base_amplitude_m": 2e-4}
    axes = {"restitution": 0.5, "mass_ratio": 0.07, "friction_ratio": axis(60, 0, 0.7)}
    axes["frequency_ratio"] = axis(80, 0.8, 1.2)
    one = parse_study({"physical": physical, "axes": axes})
    found = coarse(one)
    assert found is not None
    require_sub_grid(one, found)
    assert found.physical is not None
    assert found.physical.values()["base_amplitude_m"].tolist() == [2e-4]


def test_the_sub_grid_follows_from_the_study_alone_and_differs_in_its_axes_alone() -> None:
    study = of_ratios(60, 30, 90, steady={"tolerance": 0.03}, metrics=["amplitude_ratio"])
    found = coarse(study)
    assert found is not None
    again = coarse(parse_study(study.document()))
    assert again is not None
    assert found.digest == again.digest != study.digest
    assert found.settings() == study.settings()
    assert found.metrics == study.metrics
    assert found.name == "large, coarse grid"
    assert coarse(of_ratios(60, 30, 90, name="n" * 200)) is not None


@pytest.mark.parametrize(
    "more", [{"start": {"kind": "continuation"}}, {"start": {"kind": "ensemble", "n": 4, "seed": 1}}]
)
def test_points_that_depend_on_others_have_no_sub_grid(more: dict[str, Any]) -> None:
    assert coarse(of_ratios(60, 30, 90, **more)) is None
