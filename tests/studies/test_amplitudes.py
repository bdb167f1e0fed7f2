"""A study over base amplitudes: dampers in newtons and metres, and what is refused of one."""

import math
from typing import Any

import numpy as np
import pytest

from damperlab.studies.amplitudes import DIMENSIONS
from damperlab.studies.definition import Study, parse_study
from damperlab.studies.faults import StudyFaults
from damperlab.studies.kinds import AMPLITUDES, HARMONIC, kind_of_definition

STRUCTURE = {"mass_kg": 1.605, "natural_frequency_hz": 2.5}
RAY = STRUCTURE | {
    "base_amplitude_m": [1e-3, 2e-3, 4e-3],
    "clearance_m": [0.0075, 0.0225],
    "friction_force_n": [0.0, 0.3],
    "excitation_frequency_hz": [2.4, 2.5],
}


def study(physical: dict[str, Any], **more: Any) -> Study:
    parsed = parse_study({"physical": physical, **more})
    assert isinstance(parsed, Study)
    return parsed


def faults(document: dict[str, Any]) -> dict[str, str]:
    with pytest.raises(StudyFaults) as caught:
        parse_study(document)
    return {fault.field: str(fault.sentence) for fault in caught.value.faults}


def test_its_grid_is_that_of_dampers_and_base_amplitudes() -> None:
    made = study(RAY)
    assert tuple(made.coordinates) == tuple(DIMENSIONS) == AMPLITUDES.dimensions
    assert made.shape == (1, 1, 1, 2, 2, 3, 2)
    for name in ("base_amplitude_m", "clearance_m", "friction_force_n"):
        assert made.coordinates[name].tolist() == RAY[name]
        assert made.labels[name]["units"] == ("N" if name == "friction_force_n" else "m")
    assert kind_of_definition(made.document()) is AMPLITUDES
    assert parse_study(made.document()) == made
    assert parse_study(made.document()).digest == made.digest
    assert made.digest != study(RAY | {"mass_kg": 1.7}).digest


def test_its_ratios_are_those_of_each_damper_at_each_amplitude() -> None:
    grids = np.meshgrid(RAY["clearance_m"], RAY["friction_force_n"], RAY["base_amplitude_m"], indexing="ij")
    names = ("clearance_m", "friction_force_n", "base_amplitude_m")
    points = {name: grid.ravel() for name, grid in zip(names, grids, strict=True)}
    found = study(RAY).ratios(points)
    stiffness = 1.605 * (2 * math.pi * 2.5) ** 2
    np.testing.assert_array_equal(
        found["clearance_ratio"], points["clearance_m"] / points["base_amplitude_m"]
    )
    # a handful of roundings
    expected = points["friction_force_n"] / (stiffness * points["base_amplitude_m"])
    np.testing.assert_allclose(found["friction_ratio"], expected, rtol=1e-15)


def test_an_amplitude_that_changes_one_ratio_stays_an_axis_of_it() -> None:
    one = STRUCTURE | {"base_amplitude_m": [1e-3, 2e-3], "clearance_m": 0.008}
    parsed = study(one, axes={"frequency_ratio": 1})
    assert not parsed.over_amplitudes
    assert kind_of_definition(parsed.document()) is HARMONIC
    assert parsed.coordinates["clearance_ratio"].tolist() == [4.0, 8.0]
    # without a particle the clearance is ignored, so the force is all that the amplitude changes
    rubbing = study(one | {"friction_force_n": 0.1}, axes={"frequency_ratio": 1}, particle=False)
    assert not rubbing.over_amplitudes


def test_a_particle_alone_is_a_damper_too() -> None:
    alone = {name: value for name, value in RAY.items() if name != "friction_force_n"}
    made = study(alone)
    assert made.coordinates["friction_force_n"].tolist() == [0.0]
    points = {
        "clearance_m": np.array([0.006]),
        "friction_force_n": np.zeros(1),
        "base_amplitude_m": np.array([0.002]),
    }
    assert made.ratios(points)["friction_ratio"].tolist() == [0.0]
    friction = study({name: value for name, value in RAY.items() if name != "clearance_m"}, particle=False)
    assert friction.coordinates["clearance_m"].tolist() == [0.0]
    assert friction.ratios(points)["clearance_ratio"].tolist() == [0.0]


def test_what_would_not_be_one_damper_is_refused() -> None:
    without_force = {name: value for name, value in RAY.items() if name != "friction_force_n"}
    without_length = {name: value for name, value in RAY.items() if name != "clearance_m"}
    assert (
        "no friction_ratio"
        in faults({"physical": without_force, "axes": {"friction_ratio": 0.2}})["axes.friction_ratio"]
    )
    assert "clearance_m" in faults({"physical": without_length})["physical.clearance_m"]
    assert set(faults({"physical": without_length, "axes": {"clearance_ratio": 5}})) == {
        "axes.clearance_ratio"
    }
    assert set(faults({"physical": RAY | {"mass_kg": [1.0, 2.0]}})) == {"physical.mass_kg"}
    assert set(faults({"physical": RAY, "axes": {"clearance_ratio": 5}})) == {"physical.clearance_m"}
    # 4e15 is outside of what a ratio may be, at the smallest amplitude alone
    assert set(faults({"physical": RAY | {"clearance_m": [0.1, 4e9]}})) == {"physical.clearance_m"}


def test_points_are_shared_by_studies_of_one_structure_alone() -> None:
    settings = study(RAY).settings()
    assert settings == study(RAY | {"clearance_m": 0.01}).settings()
    assert settings != study(RAY | {"natural_frequency_hz": 2.6}).settings()
    assert settings != parse_study({"axes": {"clearance_ratio": 5, "frequency_ratio": 1}}).settings()


def test_where_a_velocity_or_an_acceleration_is_constant_the_ratios_are_those_of_the_displacement_it_makes() -> (
    None
):
    for word, order in (("velocity", 1), ("acceleration", 2)):
        made = study(RAY | {"constant": word})
        points = {
            "clearance_m": np.array([0.0075, 0.0225]),
            "friction_force_n": np.array([0.3, 0.3]),
            "base_amplitude_m": np.array([1e-3, 4e-3]),
            "frequency_ratio": np.array([0.96, 1.25]),
        }
        base_m = points["base_amplitude_m"] / points["frequency_ratio"] ** order
        as_displacement = study(RAY).ratios(points | {"base_amplitude_m": base_m})
        for ratio in ("clearance_ratio", "friction_ratio"):
            np.testing.assert_array_equal(made.ratios(points)[ratio], as_displacement[ratio])
        assert made.labels["base_amplitude_m"]["long_name"] == "base amplitude Z at the natural frequency"
        assert parse_study(made.document()) == made
        assert made.digest != study(RAY).digest
        # a point of one is no point of the other, though their coordinates are equal
        assert made.settings() != study(RAY).settings()
    assert study(RAY | {"constant": "velocity"}).digest != study(RAY | {"constant": "acceleration"}).digest


def test_what_is_constant_is_said_of_a_study_over_base_amplitudes_alone() -> None:
    assert set(faults({"physical": RAY | {"constant": "jerk"}})) == {"physical.constant"}
    one = STRUCTURE | {"base_amplitude_m": 1e-3, "clearance_m": 0.008, "constant": "velocity"}
    assert set(faults({"physical": one, "axes": {"frequency_ratio": 1}})) == {"physical.constant"}
    # within bounds at the natural frequency, and out of them where an acceleration makes the base move far less
    wide = RAY | {"clearance_m": 5e8, "excitation_frequency_hz": [2.5, 25.0]}
    bounds = study({**wide, "base_amplitude_m": [1e-3, 2e-3]})
    assert bounds.points == 8
    assert set(faults({"physical": wide | {"constant": "acceleration"}})) == {"physical.clearance_m"}
