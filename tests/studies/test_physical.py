"""A physical case makes the ratios of the model, and says where it cannot."""

import math
from typing import Any

import numpy as np
import pytest

from damperlab.studies.definition import parse_study
from damperlab.studies.faults import StudyFaults

STRUCTURE = {"mass_kg": 1.605, "natural_frequency_hz": 2.5, "base_amplitude_m": 1.5e-3}


def study(physical: dict[str, Any], particle: bool = True, **axes: Any) -> dict[str, Any]:
    return {"particle": particle, "axes": axes, "physical": physical}


def fields(document: object) -> set[str]:
    with pytest.raises(StudyFaults) as caught:
        parse_study(document)
    return {fault.field for fault in caught.value.faults}


def test_ratios_follow_their_definitions() -> None:
    omega = 2 * math.pi * 2.5
    given = STRUCTURE | {
        "excitation_frequency_hz": 2.4,
        "damping_n_s_per_m": 0.19,
        "friction_force_n": 0.3,
        "clearance_m": 7.5e-3,
        "particle_mass_kg": 0.16,
    }
    made = parse_study(study(given)).coordinates
    expected = {
        "damping_ratio": 0.19 / (2 * math.sqrt(1.605 * omega**2 * 1.605)),
        "restitution": 0.47,
        "mass_ratio": 0.16 / 1.605,
        "clearance_ratio": 5.0,
        "friction_ratio": 0.3 / (1.605 * omega**2 * 1.5e-3),
        "frequency_ratio": 2.4 / 2.5,
    }
    # A handful of roundings of one unit in the last place each.
    assert {name: float(values[0]) for name, values in made.items()} == pytest.approx(expected, rel=1e-15)


def test_an_axis_in_units_becomes_an_increasing_axis_of_its_ratio() -> None:
    lengths = STRUCTURE | {"clearance_m": {"start": 0.0015, "stop": 0.015, "num": 4}}
    made = parse_study(study(lengths, frequency_ratio=1)).coordinates
    np.testing.assert_allclose(made["clearance_ratio"], [1, 4, 7, 10], rtol=4e-16)
    amplitudes = STRUCTURE | {"base_amplitude_m": [0.001, 0.002, 0.004], "clearance_m": 0.008}
    made = parse_study(study(amplitudes, frequency_ratio=1)).coordinates
    np.testing.assert_allclose(made["clearance_ratio"], [2, 4, 8], rtol=4e-16)


def test_the_block_is_kept_with_the_study() -> None:
    parsed = parse_study(study(STRUCTURE, clearance_ratio=5, frequency_ratio=1))
    assert parsed.document()["physical"] == STRUCTURE
    assert parse_study(parsed.document()) == parsed


def test_a_ratio_given_twice_is_a_conflict() -> None:
    given = STRUCTURE | {"clearance_m": 0.0075}
    assert fields(study(given, clearance_ratio=5, frequency_ratio=1)) == {"physical.clearance_m"}
    damped = study(STRUCTURE | {"damping_n_s_per_m": 1}, clearance_ratio=5, frequency_ratio=1)
    assert fields(damped | {"damping_ratio": 0.01}) == {"physical.damping_n_s_per_m"}


def test_missing_partners_are_named() -> None:
    assert fields(study({"friction_force_n": 1}, clearance_ratio=5, frequency_ratio=1)) == {
        "physical.mass_kg",
        "physical.natural_frequency_hz",
        "physical.base_amplitude_m",
    }


def test_an_axis_that_changes_several_ratios_or_none_is_refused() -> None:
    both = STRUCTURE | {
        "natural_frequency_hz": [2, 3],
        "excitation_frequency_hz": 2.5,
        "friction_force_n": 0.1,
    }
    assert fields(study(both, clearance_ratio=5)) == {"physical.natural_frequency_hz"}
    two = STRUCTURE | {"mass_kg": [1.0, 2.0], "friction_force_n": [0.1, 0.2]}
    assert fields(study(two, clearance_ratio=5, frequency_ratio=1)) == {"physical.friction_force_n"}
    idle = STRUCTURE | {"base_amplitude_m": [1e-3, 2e-3]}
    assert fields(study(idle, clearance_ratio=5, frequency_ratio=1)) == {"physical.base_amplitude_m"}


def test_ratios_out_of_bounds_are_traced_to_their_quantity() -> None:
    given = STRUCTURE | {"damping_n_s_per_m": 1e9}
    assert fields(study(given, clearance_ratio=5, frequency_ratio=1)) == {"physical.damping_n_s_per_m"}


def test_a_scene_without_particle_ignores_its_quantities() -> None:
    parsed = parse_study(
        study({"clearance_m": [0.1, 0.2], "particle_mass_kg": 1}, particle=False, frequency_ratio=1)
    )
    assert parsed.points == 1


def test_an_empty_block_is_checked_like_none_at_all() -> None:
    whole = {"axes": {"clearance_ratio": 5, "frequency_ratio": 1}}
    assert parse_study(whole | {"physical": None}) == parse_study(whole)
    for empty in (None, {}):
        assert fields({"physical": empty}) == {"axes.clearance_ratio", "axes.frequency_ratio"}
