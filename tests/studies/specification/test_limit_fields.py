"""Limits and tolerances of a specification."""

from typing import Any

import pytest
from tests.studies.documents import without
from tests.studies.specification.test_specification import PROTOTYPE, RATIOS, changed, faults_of

from damperlab.studies.faults import StudyFaults
from damperlab.studies.specification.measure import EVERY_LIMIT
from damperlab.studies.specification.reading import parse_specification, read_specification
from damperlab.studies.specification.specification import Tolerance

GIVEN = PROTOTYPE | {
    "choose": {"clearance_m": {"start": 0.0015, "stop": 0.03}},
    "friction_force_n": 0.3,
    "tolerances": {"friction_force_n": "10%"},
}


def test_the_largest_value_that_may_be_chosen_keeps_its_limit_with_its_tolerance() -> None:
    asked = read_specification("pipe")
    (limit,) = asked.damper_limits.values()
    stop, tolerance = asked.choices["friction_force_n"].stop, asked.tolerances["friction_force_n"]
    assert limit == 30.0
    assert stop + tolerance.of(stop) == pytest.approx(limit, rel=1e-12)
    assert asked.bounds == {"friction_force_n": "limits.friction_force_n"}


@pytest.mark.parametrize(("limit_n", "kept"), [(0.33, True), (0.3299, False), (0.3, False)])
def test_a_quantity_that_is_given_keeps_its_limit_with_its_tolerance(limit_n: float, kept: bool) -> None:
    document = GIVEN | {"limits": {"friction_force_n": limit_n}}
    if kept:
        assert parse_specification(document).damper_limits == {"friction_force_n": limit_n}
        return
    told = faults_of(document)["limits.friction_force_n"]
    assert "with its tolerance, friction_force_n reaches 0.33" in told
    assert "relax it to at least 0.33" in told.lower()


def test_of_a_list_the_values_are_left_whose_tolerance_keeps_the_limit() -> None:
    document = changed("choose.clearance_m", [0.004, 0.008, 0.009, 0.012])
    asked = parse_specification(document | {"limits": {"cavity_length_m": 0.018}})
    # 9 mm may be built as 9.5 mm, a cavity of 19 mm
    assert asked.choices["clearance_m"].values == (0.004, 0.008)
    assert asked.damper_limits == {"cavity_length_m": 0.018}


@pytest.mark.parametrize(
    "excitation",
    [
        {"base_amplitude_m": 0.0015},
        {"base_amplitude_m": "1.5 mm", "frequency_hz": 2.5},
        {"base_amplitude_m": 0.0015, "frequency_hz": {"start": 3, "stop": 2}},
    ],
)
def test_contradictory_limits_are_named_beside_a_fault_of_the_excitation(excitation: dict[str, Any]) -> None:
    document = PROTOTYPE | {"excitation": excitation, "limits": {"cavity_length_m": 0.001}}
    document |= {"tolerances": {"particle_mass_kg": 1.0}, "contact_time_s": -1.0}
    found = faults_of(document)
    assert any(field.startswith("excitation") for field in found)
    assert {"limits.cavity_length_m", "tolerances.particle_mass_kg", "contact_time_s"} <= found.keys()


OF_RESULTS = {
    "displacement_ratio": 5.0,
    "relative_displacement_ratio": 4.0,
    "impact_speed_ratio": 3.0,
    "impact_noise_ratio": 2.0,
    "stick_fraction": 0.5,
}


@pytest.mark.parametrize("structure", [{}, {"natural_frequency_hz": 2.5}])
def test_limits_in_ratios_are_over_amplitude_and_natural_frequency(structure: dict[str, float]) -> None:
    of_damper = {"cavity_length_ratio": 30.0, "friction_ratio": 0.5, "mass_ratio": 0.2}
    asked = parse_specification(
        RATIOS | {"structure": RATIOS["structure"] | structure, "limits": OF_RESULTS | of_damper}
    )
    limits = asked.limits | asked.damper_limits
    units = {name: asked.structure.reference(EVERY_LIMIT[name].unit, 1.0) for name in limits}
    given = {name: limit / units[name] for name, limit in limits.items()}
    assert list(given.values()) == pytest.approx([*OF_RESULTS.values(), *of_damper.values()], rel=1e-14)
    omega = asked.structure.angular_frequency
    assert (units["impact_speed_m_per_s"], units["impact_noise_m_per_s2"]) == (omega, omega**2)
    assert units["friction_force_n"] == asked.structure.stiffness_n_per_m
    assert asked.choices["clearance_m"].stop == 15.0
    assert asked.bounds == {
        "clearance_m": "limits.cavity_length_ratio",
        "friction_force_n": "limits.friction_ratio",
    }


def test_a_ratio_of_the_damper_that_no_value_keeps_is_refused_in_ratios() -> None:
    with pytest.raises(StudyFaults, match=r"excludes every allowed clearance_ratio; the smallest is 1 "):
        parse_specification(RATIOS | {"limits": {"cavity_length_ratio": 1.5}})


@pytest.mark.parametrize("given", [0.16, {"start": 0.1, "stop": 0.2}])
def test_a_limit_of_nothing_excludes_every_particle_and_every_friction_that_begins_above_it(
    given: Any,
) -> None:
    chosen = {"choose": GIVEN["choose"] | {"particle_mass_kg": given}}
    place = chosen if isinstance(given, dict) else {"particle_mass_kg": given}
    document = without(GIVEN, "particle_mass_kg") | place
    told = faults_of(document | {"limits": {"particle_mass_kg": 0, "friction_force_n": 0}})
    assert "excludes every allowed particle_mass_kg" in told["limits.particle_mass_kg"]
    assert "at least 0.33" in told["limits.friction_force_n"]


FIXED = PROTOTYPE | {"choose": {}, "clearance_m": 0.01, "friction_force_n": 0.4, "limits": {}}
RANGES: dict[str, Any] = {
    "choose": {
        "friction_force_n": {"start": 0.0, "stop": 0.4},
        "particle_mass_kg": {"start": 0.1, "stop": 0.3},
        "restitution": {"start": 0.2, "stop": 0.8},
        "clearance_m": {"start": 0.01, "stop": 0.03},
    },
    **{key: PROTOTYPE[key] for key in ("structure", "excitation")},
}


@pytest.mark.parametrize(
    ("document", "name", "most"),
    [
        (FIXED, "friction_force_n", 0.2),
        (FIXED, "particle_mass_kg", 0.08025),
        (FIXED, "restitution", 0.235),
        (FIXED, "clearance_m", 0.005),
        (FIXED, "mass_kg", 0.8025),
        # friction may be 0, a particle and its cavity may not
        (RANGES, "friction_force_n", 0.2),
        (RANGES, "restitution", 0.4),
        (RANGES, "particle_mass_kg", 0.05),
        (RANGES, "clearance_m", 0.005),
    ],
)
def test_a_size_is_at_most_half_of_a_value_as_a_share_is(
    document: dict[str, Any], name: str, most: float
) -> None:
    (held,) = parse_specification(document | {"tolerances": {name: most}}).tolerances.values()
    assert held.size == pytest.approx(0.5 if held.relative else most)
    for beyond in (1.01 * most, "51%"):
        assert list(faults_of(document | {"tolerances": {name: beyond}})) == [f"tolerances.{name}"]


def test_a_size_around_no_damping_is_refused_and_a_share_of_it_is_none() -> None:
    document = PROTOTYPE | {"structure": PROTOTYPE["structure"] | {"damping_ratio": 0.0}}
    assert (
        "of a damping_ratio of 0"
        in faults_of(document | {"tolerances": {"damping_ratio": 0.002}})["tolerances.damping_ratio"]
    )
    assert parse_specification(document | {"tolerances": {"damping_ratio": "10%"}}).tolerances == {}
    held = parse_specification(PROTOTYPE | {"tolerances": {"damping_ratio": 0.0019}}).tolerances
    assert held == {"damping_ratio": Tolerance(0.5, True)}
