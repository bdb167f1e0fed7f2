"""What a fit found, in the names and units of a specification."""

import math
from typing import Any

import pytest
from tests.studies.fit.estimates import BENCH, IN_RATIOS, RATIO_TABLE, estimate, history, response

from damperlab.studies.faults import StudyFaults
from damperlab.studies.fit.prototype import prototype_of


def without(*names: str) -> dict[str, Any]:
    """Give the bench's prototype without some of its quantities."""
    return {
        **BENCH,
        "physical": {name: value for name, value in BENCH["physical"].items() if name not in names},
        "axes": {name: value for name, value in BENCH["axes"].items() if name not in names},
    }


def test_what_is_known_and_what_was_estimated_stand_side_by_side() -> None:
    question = response(friction_force_n=(0.0, 1.0), restitution=None)
    found = [estimate("friction_force_n", 0.2, 0.15, 0.22), estimate("restitution", 0.6, 0.45, 0.7)]
    prototype = prototype_of(question, found)
    assert prototype.values == {
        "mass_kg": (1.605,),
        "natural_frequency_hz": (2.5,),
        "damping_ratio": (0.0038,),
        "clearance_m": (0.015,),
        "friction_force_n": (0.2,),
        "particle_mass_kg": (0.1605,),
        "restitution": (0.6,),
    }
    # the farther side of each: a share of the value, of a restitution the difference
    assert prototype.off == pytest.approx({"friction_force_n": 0.25, "restitution": 0.15}, rel=1e-12)
    assert prototype.in_units
    assert prototype.excitation == {"base_amplitude_m": 0.0015, "frequency_hz": {"start": 2.4, "stop": 2.7}}


def test_a_ratio_becomes_a_force_over_every_corner_of_the_intervals_that_make_it() -> None:
    structure = without("friction_force_n", "natural_frequency_hz")
    question = response(structure, friction_ratio=None, natural_frequency_hz=(2.0, 3.0))
    found = [estimate("friction_ratio", 0.3, 0.27, 0.31), estimate("natural_frequency_hz", 2.5, 2.45, 2.55)]
    prototype = prototype_of(question, found)

    def force(ratio: float, own_hz: float) -> float:
        return ratio * 1.605 * (2 * math.pi * own_hz) ** 2 * 0.0015

    (value,) = prototype.values["friction_force_n"]
    assert value == pytest.approx(force(0.3, 2.5), rel=1e-12)
    assert prototype.off["friction_force_n"] == pytest.approx(1 - force(0.27, 2.45) / value, rel=1e-12)
    assert prototype.off["natural_frequency_hz"] == pytest.approx(0.02, rel=1e-12)


def test_a_damping_coefficient_becomes_a_ratio() -> None:
    structure = without()
    del structure["damping_ratio"]
    question = response(structure, damping_n_s_per_m=(0.0, 1.0))
    prototype = prototype_of(question, [estimate("damping_n_s_per_m", 0.2, 0.18, 0.21)])
    critical = 2 * 1.605 * 2 * math.pi * 2.5
    assert prototype.values["damping_ratio"] == pytest.approx((0.2 / critical,), rel=1e-12)
    assert prototype.off == pytest.approx({"damping_ratio": 0.1}, rel=1e-12)


def test_without_units_everything_is_over_one() -> None:
    question = response(IN_RATIOS, RATIO_TABLE, clearance_ratio=(5.0, 15.0))
    prototype = prototype_of(question, [estimate("clearance_ratio", 10, 9, 10.5)])
    assert not prototype.in_units
    assert prototype.structure.stiffness_n_per_m == pytest.approx(1.0, rel=1e-12)
    assert prototype.values["friction_force_n"] == pytest.approx((0.3,), rel=1e-12)
    assert prototype.values["clearance_m"] == (10,)
    assert prototype.excitation == {"frequency_ratio": {"start": 0.9, "stop": 1.2}}


def test_rows_without_friction_or_particle_are_those_of_another_damper() -> None:
    table = "r, X/Z, clearance ratio, friction ratio, mass ratio\n1, 29, 5, 0, 0.1\n1, 9, 15, 0, 0.1\n1, 16, 5, , 0\n"
    structure = {"damping_ratio": 0.0038, "axes": {"restitution": 0.47}}
    question = response(structure, table, friction_ratio=(0.0, 0.8))
    prototype = prototype_of(question, [estimate("friction_ratio", 0.4, 0.3, 0.6)])
    assert prototype.values["friction_force_n"] == pytest.approx((0.4,), rel=1e-12)
    assert prototype.values["clearance_m"] == (5, 15)
    assert prototype.values["particle_mass_kg"] == (0.1,)
    assert prototype.off == pytest.approx({"friction_force_n": 0.5}, rel=1e-12)
    assert prototype.excitation == {"frequency_ratio": 1}


def test_several_base_amplitudes_are_a_range() -> None:
    table = "frequency (Hz), amplitude (mm), base amplitude (mm)\n2.4, 9, \n2.5, 12,\n2.6, 8, 3\n"
    prototype = prototype_of(
        response(table=table, restitution=None), [estimate("restitution", 0.5, 0.5, 0.5)]
    )
    assert prototype.base_m == (0.0015, 0.003)
    assert prototype.excitation["base_amplitude_m"] == {"start": 0.0015, "stop": 0.003}
    assert prototype.off == {}


def test_an_interval_about_nothing_has_no_share() -> None:
    question = response(friction_force_n=(0.0, 1.0))
    prototype = prototype_of(question, [estimate("friction_force_n", 0.0, 0.0, 0.02)])
    assert prototype.values["friction_force_n"] == (0.0,)
    assert prototype.off == {"friction_force_n": math.inf}


def test_a_history_leaves_its_release_out_and_says_what_it_does_not_determine() -> None:
    structure = {
        "damping_ratio": 0.01,
        "axes": {"mass_ratio": 0.1, "restitution": 0.5},
        "physical": {"natural_frequency_hz": 2.5, "friction_force_n": 0},
    }
    question = history(structure, clearance_m=(0.001, 0.02))
    found = [
        estimate("clearance_m", 0.01, 0.001, 0.02, determined=False),
        estimate("initial_displacement_m", 0.02, 0.019, 0.021),
    ]
    prototype = prototype_of(question, found)
    assert prototype.undetermined == ("clearance_m",)
    assert set(prototype.off) == {"clearance_m"}
    assert "mass_kg" not in prototype.known
    assert prototype_of(question, found, {"mass_kg": 3.0}).values["particle_mass_kg"] == pytest.approx((0.3,))


@pytest.mark.parametrize(
    ("structure", "table", "said"),
    [
        (
            IN_RATIOS,
            "r, X/Z, damping ratio\n1, 29, 0.01\n1, 9, 0.02\n1.1, 6, 0.02\n",
            "The rows have several values of damping_ratio; a specification is of one structure.",
        ),
        (
            IN_RATIOS | {"excitation": "force"},
            RATIO_TABLE,
            "A response to a force on the structure makes no specification here",
        ),
    ],
)
def test_what_is_not_one_structure_on_a_moving_base_is_refused(
    structure: dict[str, Any], table: str, said: str
) -> None:
    question = response(structure, table, restitution=None)
    with pytest.raises(StudyFaults, match=said):
        prototype_of(question, [estimate("restitution", 0.5, 0.4, 0.6)])
