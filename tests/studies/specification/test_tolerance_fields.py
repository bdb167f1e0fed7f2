"""Tolerances: what is beyond sense is refused, in the unit as in per cent."""

from typing import Any

import pytest
from tests.studies.specification.test_specification import PROTOTYPE, faults_of

from damperlab.studies.specification.reading import parse_specification
from damperlab.studies.specification.specification import Tolerance

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


def test_a_ratio_is_held_against_the_ratios_asked_for() -> None:
    ratios = {
        "structure": {"damping_ratio": 0.01, "natural_frequency_hz": 3.0},
        "excitation": {"frequency_ratio": 1.0},
        "choose": {"clearance_ratio": {"start": 2.0, "stop": 8.0}},
        "friction_ratio": 0.4,
        "mass_ratio": 0.1,
        "restitution": 0.5,
    }
    parse_specification(ratios | {"tolerances": {"friction_ratio": 0.2, "clearance_ratio": 1.0}})
    told = faults_of(ratios | {"tolerances": {"friction_ratio": 0.3, "clearance_ratio": 1.1}})
    assert "at most" not in told["tolerances.friction_ratio"]
    assert "specified value, 0.4" in told["tolerances.friction_ratio"]
    assert "smallest specified value, 2" in told["tolerances.clearance_ratio"]


def test_a_size_around_no_damping_is_refused_and_a_share_of_it_is_none() -> None:
    document = PROTOTYPE | {"structure": PROTOTYPE["structure"] | {"damping_ratio": 0.0}}
    assert (
        "of a damping_ratio of 0"
        in faults_of(document | {"tolerances": {"damping_ratio": 0.002}})["tolerances.damping_ratio"]
    )
    assert parse_specification(document | {"tolerances": {"damping_ratio": "10%"}}).tolerances == {}
    held = parse_specification(PROTOTYPE | {"tolerances": {"damping_ratio": 0.0019}}).tolerances
    assert held == {"damping_ratio": Tolerance(0.5, True)}
