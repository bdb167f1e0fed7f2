"""A study whose particle rubs or falls: its dimensions, what makes its ratios, what it is refused with, what is told of it."""

from typing import Any

import numpy as np
import pytest
from tests.studies.documents import fields_of
from tests.studies.solving import LEAN, solved
from tests.worker.forms import night

from damperlab.studies.answers.optimal_designs import optimal_designs
from damperlab.studies.answers.resonance_map import resonance_map
from damperlab.studies.definition import parse_harmonic
from damperlab.studies.kinds import dimensions_of_definition
from damperlab.studies.units import quantities_of
from damperlab.studies.variables import DIMENSIONS

AXES: dict[str, Any] = {
    "clearance_ratio": [2, 5],
    "friction_ratio": 0.4,
    "frequency_ratio": {"start": 0.9, "stop": 1.1, "num": 3},
}
PHYSICAL: dict[str, Any] = {
    "mass_kg": 250, "natural_frequency_hz": 6, "base_amplitude_m": 0.003, "particle_mass_kg": 20, "clearance_m": 0.01,
    "friction_force_n": 300, "excitation_frequency_hz": 6,
}  # fmt: skip
WEIGHT = 9.80665 / ((2 * np.pi * 6) ** 2 * 0.003)
"""g over Z·ω_n² of that structure."""


@pytest.mark.parametrize(
    ("given", "before"),
    [
        ({}, ()),
        ({"particle_friction_ratio": 0.2}, ("particle_friction_ratio",)),
        ({"gravity_ratio": [0, 1]}, ("gravity_ratio",)),
        ({"gravity_ratio": 1, "particle_friction_ratio": 0}, ("particle_friction_ratio", "gravity_ratio")),
    ],
)
def test_a_dimension_is_there_only_where_a_study_has_it(
    given: dict[str, Any], before: tuple[str, ...]
) -> None:
    study = parse_harmonic({"axes": AXES, **given})
    assert tuple(study.coordinates) == (*before, *DIMENSIONS) == dimensions_of_definition(study.document())
    assert tuple(study.labels) == tuple(study.coordinates)
    assert ("dissipation_particle" in study.metrics) == ("particle_friction_ratio" in before)
    assert parse_harmonic(study.document()) == study
    assert (study.digest == parse_harmonic({"axes": AXES}).digest) == (not given)


def test_a_coefficient_and_a_tilt_make_the_ratios() -> None:
    physical = PHYSICAL | {"particle_friction_coefficient": [0.1, 0.2], "tilt_deg": 30}
    found = parse_harmonic({"physical": physical}).coordinates
    cosine, sine = np.sqrt(3) / 2, 0.5
    assert found["particle_friction_ratio"] == pytest.approx(
        np.array([0.1, 0.2]) * cosine * WEIGHT, rel=1e-14
    )
    assert found["gravity_ratio"] == pytest.approx([sine * WEIGHT], rel=1e-14)
    standing = parse_harmonic({"physical": physical | {"tilt_deg": 90, "particle_friction_coefficient": 0.1}})
    assert standing.coordinates["particle_friction_ratio"] == [
        0.0
    ]  # nothing presses the particle on its floor


@pytest.mark.parametrize(
    ("given", "field"),
    [
        ({"particle_friction_ratio": -1}, "particle_friction_ratio"),
        ({"particle_friction_ratio": 1, "contact": {"model": "dwell", "contact_time": 0.1}}, "particle_friction_ratio"),
        ({"gravity_ratio": 1, "solver": {"method": "rk4"}}, "gravity_ratio"),
        ({"particle_friction_ratio": 0.2, "particle": False}, "particle_friction_ratio"),
        ({"metrics": ["dissipation_particle"]}, "metrics[0]"),
        ({"gravity_ratio": 1, "physical": {"tilt_deg": 10}}, "physical.tilt_deg"),
        ({"physical": {"tilt_deg": 91}}, "physical.tilt_deg"),
        ({"physical": {"tilt_deg": [0, 30], "particle_friction_coefficient": 0.1}}, "physical.tilt_deg"),
        ({"physical": {"base_amplitude_m": [0.001, 0.002], "tilt_deg": [10, 20]}}, "physical.tilt_deg"),
        ({"physical": {"base_amplitude_m": [0.001, 0.002]}, "gravity_ratio": 1}, "gravity_ratio"),
    ],
)  # fmt: skip
def test_what_does_not_go_together_is_refused_by_its_field(given: dict[str, Any], field: str) -> None:
    document = {"axes": AXES, **given}
    if "physical" in given:
        document = {**given, "physical": PHYSICAL | given["physical"]}
    assert field in fields_of(parse_harmonic, document)


@pytest.mark.parametrize("gravity", [0, night([0, 1])])
def test_without_friction_and_gravity_the_values_are_those_of_a_study_that_says_nothing_of_them(
    gravity: int | list[int],
) -> None:
    plain = solved(parse_harmonic({"axes": AXES, "metrics": LEAN}))
    given = {"particle_friction_ratio": [0, 0.3], "gravity_ratio": gravity}
    both = solved(parse_harmonic({"axes": AXES, "metrics": LEAN, **given}))
    none = both.isel(particle_friction_ratio=0, gravity_ratio=0)
    for name in plain.data_vars:
        if name != "run_time":
            np.testing.assert_array_equal(none[name].values, plain[name].values)
    assert (both["status"] == 0).all()
    assert np.unique(both["amplitude_ratio"].values).size > plain["amplitude_ratio"].size


def test_answers_tell_them_as_they_tell_other_dimensions() -> None:
    given = {"particle_friction_ratio": [0, 0.3], "gravity_ratio": 0}
    cube = solved(parse_harmonic({"axes": AXES, "metrics": LEAN, **given}))
    ranked = optimal_designs(cube)
    best = cube["amplitude_ratio"].max("frequency_ratio").min().item()
    assert ranked["value"].values[0] == best
    assert "κ" in " ".join(ranked.attrs["verdict"])
    shown = resonance_map(cube, "particle_friction_ratio", "clearance_ratio")
    assert shown.sizes["particle_friction_ratio"] == 2
    assert shown["amplitude_ratio"].min().item() == best


@pytest.mark.parametrize(("tilt_deg", "told"), [(0, 0.05), (45, 0.05), (90, None)])
def test_the_coefficient_is_told_as_it_was_given_however_the_cavity_lies(
    tilt_deg: float, told: float | None
) -> None:
    given = PHYSICAL | {"particle_friction_coefficient": 0.05, "tilt_deg": tilt_deg}
    quantities = {each.name: each for each in quantities_of({"physical": given})}
    ratio = WEIGHT * 0.05 * np.cos(np.radians(tilt_deg))
    if told is None:
        assert "particle_friction_coefficient" not in quantities
    else:
        assert quantities["particle_friction_coefficient"].of(ratio) == pytest.approx(told, rel=1e-12)
