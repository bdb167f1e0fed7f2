"""The best damper so far in one line: what it does, and what it is, in the units it was asked in."""

from typing import Any

import pytest

from damperlab.studies.design.spelling import best_so_far

DESIGN: dict[str, Any] = {
    "clearance_m": 0.0056,
    "friction_force_n": 30.0,
    "particle_mass_kg": 0.16,
    "restitution": 0.5,
    "clearance_ratio": 5.6,
    "friction_ratio": 0.3,
    "mass_ratio": 0.1,
}
RATIOS = DESIGN | dict.fromkeys(("clearance_m", "friction_force_n", "particle_mass_kg"))
FRICTION = dict.fromkeys(DESIGN) | {"friction_force_n": 30.0}
AT = {"value": 0.00312, "units": "m", "frequency_ratio": 0.95, "frequency_hz": 7.6}
UNDER = {"value": 2.5, "units": "m/s²", "record": "northridge", "scale": 0.5, "frequency_hz": None}
IN_UNITS = "clearance 5.6 mm, friction force 30 N, particle mass 160 g, coefficient of restitution 0.5"
IN_RATIOS = "d/Z = 5.6, γ_F = 0.3, β = 0.1, coefficient of restitution 0.5"


@pytest.mark.parametrize(
    ("design", "worst", "feasible", "told"),
    [
        (DESIGN, AT, True, f"3.12 mm near 7.6 Hz: {IN_UNITS}"),
        (
            RATIOS,
            AT | {"value": 3.12, "units": "1", "frequency_hz": None},
            False,
            f"3.12 times the base amplitude near r = 0.95, exceeds a limit: {IN_RATIOS}",
        ),
        # a record is called what it is and not by its id
        (FRICTION, UNDER | {"record_name": "sweep"}, True, "2.5 m/s² under sweep × 0.5: friction force 30 N"),
        (FRICTION, UNDER | {"value": None}, True, "no bounded response: friction force 30 N"),
    ],
)
def test_a_line_says_what_it_does_and_what_it_is(
    design: dict[str, Any], worst: dict[str, Any], feasible: bool, told: str
) -> None:
    assert best_so_far({"design": design, "worst": worst, "feasible": feasible}) == told
