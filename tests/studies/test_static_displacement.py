"""A force on the structure in newtons: what it makes of a study, and what is wrong beside it."""

import math
from typing import Any

import pytest

from damperlab.studies.definition import parse_study
from damperlab.studies.faults import StudyFaults

STIFFNESS = 200.0 * (2.0 * math.pi * 8.0) ** 2
PHYSICAL: dict[str, Any] = {
    "mass_kg": 200,
    "natural_frequency_hz": 8,
    "force_n": 40,
    "clearance_m": 0.001,
    "friction_force_n": [5, 10],
    "particle_mass_kg": 10,
}
STUDY: dict[str, Any] = {"excitation": "force", "physical": PHYSICAL, "axes": {"frequency_ratio": [0.9, 1.0]}}


def physical(**changes: Any) -> dict[str, Any]:
    changed = {name: value for name, value in (PHYSICAL | changes).items() if value is not None}
    return STUDY | {"physical": changed}


def faults_of(document: dict[str, Any]) -> dict[str, str]:
    with pytest.raises(StudyFaults) as caught:
        parse_study(document)
    return {fault.field: str(fault) for fault in caught.value.faults}


def test_a_force_makes_ratios_over_its_static_displacement() -> None:
    study = parse_study(STUDY)
    assert study.coordinates["friction_ratio"] == pytest.approx([5 / 40, 10 / 40], rel=1e-14)
    assert study.coordinates["clearance_ratio"] == pytest.approx([0.001 * STIFFNESS / 40], rel=1e-14)
    kept = study.document()["physical"]
    assert kept["force_n"] == 40
    assert kept["base_amplitude_m"] == pytest.approx(40 / STIFFNESS, rel=1e-14)


def test_what_is_kept_of_a_study_is_the_same_study() -> None:
    study = parse_study(STUDY)
    again = parse_study(study.document())
    assert (again.digest, again.document()) == (study.digest, study.document())
    same = parse_study(physical(force_n=None, base_amplitude_m=40 / STIFFNESS))
    assert same.digest == study.digest


@pytest.mark.parametrize(
    "forces", [[10, 20, 40], {"start": 10, "stop": 40, "num": 3, "spacing": "log"}], ids=["list", "range"]
)
def test_forces_are_an_axis_as_base_amplitudes_are(forces: Any) -> None:
    study = parse_study(physical(force_n=forces))
    assert study.over_amplitudes
    given = study.coordinates["base_amplitude_m"] * STIFFNESS
    assert given == pytest.approx([10, 20, 40], rel=1e-12)
    assert parse_study(study.document()).digest == study.digest


@pytest.mark.parametrize(
    ("document", "field", "words"),
    [
        ({**STUDY, "excitation": "base"}, "physical.force_n", "add `excitation: force`"),
        (physical(base_amplitude_m=1.0), "physical.base_amplitude_m", "one of them determines it"),
        (physical(mass_kg=[150, 200]), "physical.mass_kg", "over the stiffness"),
        (physical(natural_frequency_hz=None), "physical.natural_frequency_hz", "not nothing"),
        (physical(force_n="forty"), "physical.force_n", "plain number"),
        (physical(force_n=-1), "physical.force_n", "not -1"),
        (physical(constant="velocity"), "physical.constant", "the same at every frequency"),
        (
            {**STUDY, "physical": {"mass_kg": 200, "natural_frequency_hz": 8, "force_n": [1, 2]},
             "axes": {"frequency_ratio": 1, "clearance_ratio": 2}},
            "physical.force_n", "a single number",
        ),
        ({"excitation": "wind", "axes": {"frequency_ratio": 1, "clearance_ratio": 2}}, "excitation", "base or force"),
        (
            {"excitation": "force", "solver": {"method": "rk4"}, "axes": {"frequency_ratio": 1, "clearance_ratio": 2}},
            "excitation", "base with solver rk4",
        ),
    ],
)  # fmt: skip
def test_what_is_wrong_is_named_where_it_was_written(
    document: dict[str, Any], field: str, words: str
) -> None:
    found = faults_of(document)
    assert words.lower() in found[field].lower()
    if "base_amplitude_m" not in document.get("physical", {}):
        assert "physical.base_amplitude_m" not in found
