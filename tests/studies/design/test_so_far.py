"""The best damper so far in one line: what it does, and what it is, in the units it was asked in."""

from typing import Any

from damperlab.studies.design.so_far import best_so_far

DESIGN: dict[str, Any] = {
    "clearance_m": 0.0056,
    "friction_force_n": 30.0,
    "particle_mass_kg": 0.16,
    "restitution": 0.5,
    "clearance_ratio": 5.6,
    "friction_ratio": 0.3,
    "mass_ratio": 0.1,
}
RATIOS: dict[str, Any] = DESIGN | dict.fromkeys(("clearance_m", "friction_force_n", "particle_mass_kg"))
WORST: dict[str, Any] = {"value": 0.00312, "units": "m", "frequency_ratio": 0.95, "frequency_hz": 7.6}


def test_in_units() -> None:
    told = best_so_far({"design": DESIGN, "worst": WORST, "feasible": True})
    assert (
        told == "3.12 mm near 7.6 Hz: clearance 5.6 mm, friction force 30 N, particle 160 g, restitution 0.5"
    )


def test_in_ratios_and_beyond_a_limit() -> None:
    worst = WORST | {"value": 3.12, "units": "1", "frequency_hz": None}
    told = best_so_far({"design": RATIOS, "worst": worst, "feasible": False})
    assert told == (
        "3.12 times the base amplitude near r = 0.95, exceeds a limit: d/Z = 5.6, γ_F = 0.3, β = 0.1, restitution 0.5"
    )


def test_under_a_record_without_a_particle_and_without_a_bound() -> None:
    friction = dict.fromkeys(DESIGN) | {"friction_force_n": 30.0}
    worst = {"value": 2.5, "units": "m/s²", "record": "northridge", "scale": 0.5, "frequency_hz": None}
    told = best_so_far({"design": friction, "worst": worst, "feasible": True})
    assert told == "2.5 m/s² under northridge × 0.5: friction force 30 N"
    told = best_so_far({"design": friction, "worst": worst | {"value": None}, "feasible": True})
    assert told == "no bounded response: friction force 30 N"


def test_a_record_is_called_what_it_is_and_not_by_its_id() -> None:
    worst = {"value": 2.5, "units": "m/s²", "record": "u-17d516815afb", "scale": 1.0}
    worst |= {"record_name": "sweep from 2 to 3 Hz at 0.1 Hz/s", "frequency_hz": None}
    told = best_so_far({"design": DESIGN, "worst": worst, "feasible": True})
    assert told.startswith("2.5 m/s² under sweep from 2 to 3 Hz at 0.1 Hz/s × 1: ")
