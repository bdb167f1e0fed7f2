"""Specifications that a fit corrects: what was measured replaces what was thought, and all else is kept."""

import copy
from typing import Any

import pytest
from tests.studies.fit.estimates import IN_RATIOS, RATIO_TABLE, estimate, history, response

from damperlab.studies.faults import StudyFaults
from damperlab.studies.fit.correction import corrected
from damperlab.studies.fit.fitted import Estimate
from damperlab.studies.fit.made import Correction, check_specification
from damperlab.studies.fit.prototype import Question
from damperlab.studies.fit.specified import Specified
from damperlab.studies.specification.reading import parse_specification

PLANNED: dict[str, Any] = {
    "name": "bench",
    "structure": {"mass_kg": 1.7, "stiffness_n_per_m": 400.0, "damping_n_s_per_m": 0.4},
    "excitation": {"base_velocity_m_per_s": 0.02, "frequency_hz": {"start": 2.0, "stop": 3.0}},
    "choose": {
        "clearance_m": {"start": 0.002, "stop": 0.03},
        "friction_force_n": {"start": 0.0, "stop": 0.5},
    },
    "mass_ratio": 0.12,
    "restitution": 0.6,
    "contact_time_s": 0.002,
    "tolerances": {"clearance_m": 0.0005, "friction_force_n": "10%", "restitution": 0.1, "mass_kg": "2%"},
    "limits": {"displacement_m": 0.02},
    "confidence": 0.8,
    "builds": 30,
}
RATIOS: dict[str, Any] = {
    "structure": {"damping_ratio": 0.01},
    "excitation": {"frequency_ratio": {"start": 0.8, "stop": 1.2}},
    "choose": {"clearance_ratio": {"start": 2, "stop": 20}},
    "friction_ratio": 0.2,
    "mass_ratio": 0.12,
    "restitution": 0.6,
}
ESTIMATES = (
    estimate("natural_frequency_hz", 2.5, 2.49, 2.52),
    estimate("damping_ratio", 0.004, 0.0036, 0.0042),
    estimate("friction_force_n", 0.2, 0.15, 0.22),
    estimate("restitution", 0.5, 0.46, 0.53),
)


def correct(document: dict[str, Any], question: Question, *estimates: Estimate) -> Specified:
    before = copy.deepcopy(document)
    found = corrected(parse_specification(document), question, list(estimates))
    assert document == before
    parse_specification(found.document)
    return found


def asked() -> Question:
    return response(
        natural_frequency_hz=None, damping_ratio=None, friction_force_n=(0.0, 1.0), restitution=None
    )


def test_structure_given_values_and_tolerances_are_as_measured_and_all_else_is_kept() -> None:
    found = correct(PLANNED, asked(), *ESTIMATES)
    expected = PLANNED | {
        "structure": {"mass_kg": 1.605, "natural_frequency_hz": 2.5, "damping_ratio": 0.004},
        "particle_mass_kg": 0.1605,
        "restitution": 0.5,
        "tolerances": {
            # a clearance was not sought: what is worked to stays; of a force that is known to 25 % no 10 % are set
            "clearance_m": 0.0005,
            "friction_force_n": "25%",
            "restitution": 0.04,
            "mass_kg": "2%",
            "natural_frequency_hz": "0.8%",
            "damping_ratio": "10%",
        },
    }
    del expected["mass_ratio"]  # in units now
    assert found.document == expected
    assert list(found.document)[:4] == ["name", "structure", "excitation", "choose"]
    assert found.guesses == {}


def test_what_is_chosen_keeps_the_tolerance_to_which_it_is_built_where_it_is_known_better() -> None:
    sharp = estimate("friction_force_n", 0.2, 0.199, 0.201)
    found = correct(PLANNED, asked(), *ESTIMATES[:2], sharp, ESTIMATES[3])
    assert found.document["tolerances"]["friction_force_n"] == "10%"
    assert "the friction force" not in found.words[1]
    unworked = copy.deepcopy(PLANNED)
    del unworked["tolerances"]["friction_force_n"]
    found = correct(unworked, asked(), *ESTIMATES[:2], sharp, ESTIMATES[3])
    assert found.document["tolerances"]["friction_force_n"] == "0.5%"


def test_what_the_measurement_says_nothing_about_stays_with_its_tolerance() -> None:
    unknown = estimate("restitution", 0.05, 0.0, 1.0, determined=False)
    found = correct(PLANNED, asked(), *ESTIMATES[:3], unknown)
    assert found.document["restitution"] == 0.6
    assert found.document["tolerances"]["restitution"] == 0.1
    assert "Kept as before, since the measurement does not say it: the restitution." in found.words


def test_a_measurement_that_knows_no_mass_leaves_it_and_uses_it() -> None:
    structure = {
        "damping_ratio": 0.0038,
        "axes": {"restitution": 0.47, "mass_ratio": 0.1, "friction_ratio": 0.3},
        "physical": {"natural_frequency_hz": 2.5, "base_amplitude_m": 0.0015, "clearance_m": 0.01},
    }
    found = correct(PLANNED, response(structure, restitution=None), ESTIMATES[3])
    assert found.document["structure"]["mass_kg"] == 1.7
    assert found.document["particle_mass_kg"] == pytest.approx(0.17)


def test_a_specification_in_ratios_stays_in_ratios() -> None:
    question = response(restitution=None, friction_force_n=(0.0, 1.0))
    found = correct(RATIOS, question, *ESTIMATES[2:])
    stiffness = 1.605 * (2 * 3.141592653589793 * 2.5) ** 2
    assert found.document["friction_ratio"] == pytest.approx(0.2 / (stiffness * 0.0015), rel=1e-5)
    assert found.document["mass_ratio"] == 0.1
    assert found.document["structure"] == {"damping_ratio": 0.0038}
    assert found.document["tolerances"] == {"friction_force_n": "25%", "restitution": 0.04}


def test_ratios_of_an_unknown_base_and_histories_beside_ratios_are_refused() -> None:
    given = PLANNED | {"choose": {"clearance_m": {"start": 0.002, "stop": 0.03}}, "friction_force_n": 0.2}
    ratios = response(IN_RATIOS, RATIO_TABLE, restitution=None)
    with pytest.raises(StudyFaults, match="`base_amplitude_m` is missing: the specification is in units"):
        correct(given, ratios, ESTIMATES[3])
    # what is chosen needs no value
    assert correct(PLANNED, ratios, ESTIMATES[3]).document["restitution"] == 0.5
    structure = {
        "damping_ratio": 0.01,
        "axes": {"mass_ratio": 0.1, "restitution": 0.5},
        "physical": {"natural_frequency_hz": 2.5, "friction_force_n": 0},
    }
    decay = history(structure, clearance_m=(0.001, 0.02))
    with pytest.raises(StudyFaults, match="A time history is in units"):
        correct(RATIOS, decay, estimate("clearance_m", 0.01, 0.0099, 0.0101))


def test_limits_are_held_against_what_is_measured_and_not_against_what_is_sought() -> None:
    """A friction force sought from 0 to 1 N, of which 0.2 N are measured, keeps a limit of 0.3 N."""
    planned = {key: value for key, value in PLANNED.items() if key != "choose"}
    planned |= {"choose": {"clearance_m": PLANNED["choose"]["clearance_m"]}, "friction_force_n": 0.1}
    planned |= {"limits": {"friction_force_n": 0.3}}
    check_specification(asked(), Correction(parse_specification(planned)))
    assert correct(planned, asked(), *ESTIMATES).document["friction_force_n"] == 0.2
    with pytest.raises(StudyFaults, match="excludes every friction_force_n"):
        correct(planned | {"limits": {"friction_force_n": 0.15}}, asked(), *ESTIMATES)
