"""A physical case makes the ratios of the model, over base amplitudes and under a force too, and says where it cannot."""

import math
import re
from typing import Any

import numpy as np
import pytest
from tests.studies.documents import told_of, without

from damperlab.studies.amplitudes import DIMENSIONS
from damperlab.studies.definition import Study, parse_study
from damperlab.studies.ground.random_vibration import LEVELS
from damperlab.studies.ground.sweep import PACES
from damperlab.studies.kinds import AMPLITUDES, HARMONIC, kind_of_definition
from damperlab.studies.physical import QUANTITIES
from damperlab.studies.quantity import Quantity
from damperlab.studies.specification.limit_fields import LIMIT_QUANTITIES
from damperlab.studies.specification.schema import OF_SCENE
from damperlab.studies.spelling import quantity, spelled, unit_of, written

STRUCTURE = {"mass_kg": 1.605, "natural_frequency_hz": 2.5, "base_amplitude_m": 1.5e-3}


def case(physical: dict[str, Any], particle: bool = True, **axes: Any) -> dict[str, Any]:
    return {"particle": particle, "axes": axes, "physical": physical}


def faults(document: object) -> dict[str, str]:
    return told_of(parse_study, document)


NAMED = {each.name: each for each in QUANTITIES} | OF_SCENE | LIMIT_QUANTITIES | LEVELS | PACES


@pytest.mark.parametrize(("name", "quantity"), NAMED.items(), ids=NAMED)
def test_the_unit_of_a_name_is_that_of_its_meaning(name: str, quantity: Quantity) -> None:
    found = re.search(r"\[(.+?)\]", quantity.meaning)
    assert unit_of(name) == (found[1] if found else "")


@pytest.mark.parametrize(
    ("metres", "written"),
    [
        (1.5, "1.5 m"),
        (0.0012, "1.2 mm"),
        (8e-9, "8 nm"),
        (-8e-9, "-8 nm"),
    ],
)
def test_a_length_is_written_in_a_unit_in_which_its_digits_are_read(metres: float, written: str) -> None:
    assert spelled(metres, "m") == quantity("clearance_m", metres) == written


@pytest.mark.parametrize(
    ("value", "unit", "text"), [(49234.5, "mm", "49.2 m"), (5123.4, "N", "5120 N"), (1e-5, "mm", "10 nm")]
)
def test_a_large_or_small_quantity_is_written_without_an_exponent(value: float, unit: str, text: str) -> None:
    assert written(value, unit, ".3g") == text


def test_ratios_follow_their_definitions() -> None:
    omega = 2 * math.pi * 2.5
    given = STRUCTURE | {
        "excitation_frequency_hz": 2.4,
        "damping_n_s_per_m": 0.19,
        "friction_force_n": 0.3,
        "clearance_m": 7.5e-3,
        "particle_mass_kg": 0.16,
    }
    made = parse_study(case(given)).coordinates
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


def test_the_block_is_kept_with_the_study_and_an_empty_one_is_checked_like_none_at_all() -> None:
    parsed = parse_study(case(STRUCTURE, clearance_ratio=5, frequency_ratio=1))
    assert parsed.document()["physical"] == STRUCTURE
    assert parse_study(parsed.document()) == parsed
    # a scene without particle ignores its quantities
    ignored = {"clearance_m": [0.1, 0.2], "particle_mass_kg": 1}
    assert parse_study(case(ignored, particle=False, frequency_ratio=1)).points == 1
    whole = {"axes": {"clearance_ratio": 5, "frequency_ratio": 1}}
    assert parse_study(whole | {"physical": None}) == parse_study(whole)
    for empty in (None, {}):
        assert faults({"physical": empty}).keys() == {"axes.clearance_ratio", "axes.frequency_ratio"}


RAY = STRUCTURE | {
    "base_amplitude_m": [1e-3, 2e-3, 4e-3],
    "clearance_m": [0.0075, 0.0225],
    "friction_force_n": [0.0, 0.3],
    "excitation_frequency_hz": [2.4, 2.5],
}


def over_amplitudes(physical: dict[str, Any], **more: Any) -> Study:
    parsed = parse_study({"physical": physical, **more})
    assert isinstance(parsed, Study)
    return parsed


def test_the_grid_over_base_amplitudes_is_that_of_dampers_and_base_amplitudes() -> None:
    made = over_amplitudes(RAY)
    assert tuple(made.coordinates) == tuple(DIMENSIONS) == AMPLITUDES.dimensions
    assert made.shape == (1, 1, 1, 2, 2, 3, 2)
    for name in ("base_amplitude_m", "clearance_m", "friction_force_n"):
        assert made.coordinates[name].tolist() == RAY[name]
        assert made.labels[name]["units"] == ("N" if name == "friction_force_n" else "m")
    assert kind_of_definition(made.document()) is AMPLITUDES
    assert parse_study(made.document()) == made
    assert parse_study(made.document()).digest == made.digest
    assert made.digest != over_amplitudes(RAY | {"mass_kg": 1.7}).digest


def test_the_ratios_over_base_amplitudes_are_those_of_each_damper_at_each_amplitude() -> None:
    grids = np.meshgrid(RAY["clearance_m"], RAY["friction_force_n"], RAY["base_amplitude_m"], indexing="ij")
    names = ("clearance_m", "friction_force_n", "base_amplitude_m")
    points = {name: grid.ravel() for name, grid in zip(names, grids, strict=True)}
    found = over_amplitudes(RAY).ratios(points)
    stiffness = 1.605 * (2 * math.pi * 2.5) ** 2
    np.testing.assert_array_equal(
        found["clearance_ratio"], points["clearance_m"] / points["base_amplitude_m"]
    )
    # a handful of roundings
    expected = points["friction_force_n"] / (stiffness * points["base_amplitude_m"])
    np.testing.assert_allclose(found["friction_ratio"], expected, rtol=1e-15)


def test_an_amplitude_that_changes_one_ratio_stays_an_axis_of_it() -> None:
    one = STRUCTURE | {"base_amplitude_m": [1e-3, 2e-3], "clearance_m": 0.008}
    parsed = over_amplitudes(one, axes={"frequency_ratio": 1})
    assert not parsed.over_amplitudes
    assert kind_of_definition(parsed.document()) is HARMONIC
    assert parsed.coordinates["clearance_ratio"].tolist() == [4.0, 8.0]
    # without a particle the clearance is ignored, so the force is all that the amplitude changes
    rubbing = over_amplitudes(one | {"friction_force_n": 0.1}, axes={"frequency_ratio": 1}, particle=False)
    assert not rubbing.over_amplitudes


def test_a_particle_alone_is_a_damper_too() -> None:
    made = over_amplitudes(without(RAY, "friction_force_n"))
    assert made.coordinates["friction_force_n"].tolist() == [0.0]
    points = {
        "clearance_m": np.array([0.006]),
        "friction_force_n": np.zeros(1),
        "base_amplitude_m": np.array([0.002]),
    }
    assert made.ratios(points)["friction_ratio"].tolist() == [0.0]
    friction = over_amplitudes(without(RAY, "clearance_m"), particle=False)
    assert friction.coordinates["clearance_m"].tolist() == [0.0]
    assert friction.ratios(points)["clearance_ratio"].tolist() == [0.0]


def test_points_are_shared_by_studies_of_one_structure_alone() -> None:
    settings = over_amplitudes(RAY).settings()
    assert settings == over_amplitudes(RAY | {"clearance_m": 0.01}).settings()
    assert settings != over_amplitudes(RAY | {"natural_frequency_hz": 2.6}).settings()
    assert settings != parse_study({"axes": {"clearance_ratio": 5, "frequency_ratio": 1}}).settings()


def test_where_a_velocity_or_an_acceleration_is_constant_the_ratios_are_those_of_the_displacement_it_makes() -> (
    None
):
    for word, order in (("velocity", 1), ("acceleration", 2)):
        made = over_amplitudes(RAY | {"constant": word})
        points = {
            "clearance_m": np.array([0.0075, 0.0225]),
            "friction_force_n": np.array([0.3, 0.3]),
            "base_amplitude_m": np.array([1e-3, 4e-3]),
            "frequency_ratio": np.array([0.96, 1.25]),
        }
        base_m = points["base_amplitude_m"] / points["frequency_ratio"] ** order
        as_displacement = over_amplitudes(RAY).ratios(points | {"base_amplitude_m": base_m})
        for ratio in ("clearance_ratio", "friction_ratio"):
            np.testing.assert_array_equal(made.ratios(points)[ratio], as_displacement[ratio])
        assert made.labels["base_amplitude_m"]["long_name"] == "base amplitude Z at the natural frequency"
        assert parse_study(made.document()) == made
        assert made.digest != over_amplitudes(RAY).digest
        # a point of one is no point of the other, though their coordinates are equal
        assert made.settings() != over_amplitudes(RAY).settings()
    assert (
        over_amplitudes(RAY | {"constant": "velocity"}).digest
        != over_amplitudes(RAY | {"constant": "acceleration"}).digest
    )


STIFFNESS = 200.0 * (2.0 * math.pi * 8.0) ** 2
FORCED: dict[str, Any] = {
    "mass_kg": 200,
    "natural_frequency_hz": 8,
    "force_n": 40,
    "clearance_m": 0.001,
    "friction_force_n": [5, 10],
    "particle_mass_kg": 10,
}
UNDER_FORCE: dict[str, Any] = {
    "excitation": "force",
    "physical": FORCED,
    "axes": {"frequency_ratio": [0.9, 1.0]},
}


def forced(**changes: Any) -> dict[str, Any]:
    changed = {name: value for name, value in (FORCED | changes).items() if value is not None}
    return UNDER_FORCE | {"physical": changed}


def test_a_force_makes_ratios_over_its_static_displacement() -> None:
    study = parse_study(UNDER_FORCE)
    assert study.coordinates["friction_ratio"] == pytest.approx([5 / 40, 10 / 40], rel=1e-14)
    assert study.coordinates["clearance_ratio"] == pytest.approx([0.001 * STIFFNESS / 40], rel=1e-14)
    kept = study.document()["physical"]
    assert kept["force_n"] == 40
    assert kept["base_amplitude_m"] == pytest.approx(40 / STIFFNESS, rel=1e-14)


def test_what_is_kept_of_a_study_of_a_force_is_the_same_study() -> None:
    study = parse_study(UNDER_FORCE)
    again = parse_study(study.document())
    assert (again.digest, again.document()) == (study.digest, study.document())
    same = parse_study(forced(force_n=None, base_amplitude_m=40 / STIFFNESS))
    assert same.digest == study.digest


@pytest.mark.parametrize(
    "forces", [[10, 20, 40], {"start": 10, "stop": 40, "num": 3, "spacing": "log"}], ids=["list", "range"]
)
def test_forces_are_an_axis_as_base_amplitudes_are(forces: Any) -> None:
    study = parse_study(forced(force_n=forces))
    assert study.over_amplitudes
    given = study.coordinates["base_amplitude_m"] * STIFFNESS
    assert given == pytest.approx([10, 20, 40], rel=1e-12)
    assert parse_study(study.document()).digest == study.digest


AT_ONCE = {"frequency_ratio": 1, "clearance_ratio": 5}


def beside(axes: dict[str, Any] = AT_ONCE, **physical: Any) -> dict[str, Any]:
    return case(STRUCTURE | physical, **axes)


def ray(left_out: str = "", **changes: Any) -> dict[str, Any]:
    return {"physical": without(RAY | changes, left_out)}


@pytest.mark.parametrize(
    ("document", "field", "words"),
    [
        # a ratio that is given twice
        (beside(clearance_m=0.0075), "physical.clearance_m", ""),
        (beside(damping_n_s_per_m=1) | {"damping_ratio": 0.01}, "physical.damping_n_s_per_m", ""),
        # an axis that changes several ratios, as another does, or none
        (
            beside(
                {"clearance_ratio": 5},
                natural_frequency_hz=[2, 3],
                excitation_frequency_hz=2.5,
                friction_force_n=0.1,
            ),
            "physical.natural_frequency_hz",
            "",
        ),
        (beside(mass_kg=[1.0, 2.0], friction_force_n=[0.1, 0.2]), "physical.friction_force_n", ""),
        (beside(base_amplitude_m=[1e-3, 2e-3]), "physical.base_amplitude_m", ""),
        # a ratio out of bounds is traced to its quantity, at the smallest amplitude alone
        (beside(damping_n_s_per_m=1e9), "physical.damping_n_s_per_m", ""),
        (ray(clearance_m=[0.1, 4e9]), "physical.clearance_m", ""),
        # within bounds at the natural frequency, and out of them where an acceleration makes the base move far less
        (
            ray(clearance_m=5e8, excitation_frequency_hz=[2.5, 25.0], constant="acceleration"),
            "physical.clearance_m",
            "",
        ),
        # what would not be one damper
        (
            ray("friction_force_n") | {"axes": {"friction_ratio": 0.2}},
            "axes.friction_ratio",
            "instead of friction_ratio",
        ),
        (ray("clearance_m"), "physical.clearance_m", ""),
        (ray(mass_kg=[1.0, 2.0]), "physical.mass_kg", ""),
        (ray() | {"axes": {"clearance_ratio": 5}}, "physical.clearance_m", ""),
        # what is constant is said of base amplitudes alone
        (ray(constant="jerk"), "physical.constant", ""),
        (beside({"frequency_ratio": 1}, clearance_m=0.008, constant="velocity"), "physical.constant", ""),
        ({**UNDER_FORCE, "excitation": "base"}, "physical.force_n", "add `excitation: force`"),
        (forced(base_amplitude_m=1.0), "physical.base_amplitude_m", "determine"),
        (forced(mass_kg=[150, 200]), "physical.mass_kg", "the stiffness converts"),
        (forced(natural_frequency_hz=None), "physical.natural_frequency_hz", "not nothing"),
        (forced(force_n="forty"), "physical.force_n", "plain number"),
        (forced(constant="velocity"), "physical.constant", "the same at every frequency"),
        (
            {"physical": {"mass_kg": 200, "natural_frequency_hz": 8, "force_n": [1, 2]}, "axes": AT_ONCE}
            | {"excitation": "force"},
            "physical.force_n",
            "a single number",
        ),
        (
            {"excitation": "force", "solver": {"method": "rk4"}, "axes": AT_ONCE},
            "excitation",
            "base with solver rk4",
        ),
    ],
)
def test_what_is_wrong_is_named_where_it_was_written(
    document: dict[str, Any], field: str, words: str
) -> None:
    found = faults(document)
    assert words.lower() in found[field].lower()
    if "force_n" in document.get("physical", {}):
        # what a force makes is named nowhere, unless it is written
        assert field == "physical.base_amplitude_m" or "physical.base_amplitude_m" not in found
    else:
        assert found.keys() == {field}


def test_missing_partners_are_named() -> None:
    missing = {"physical.mass_kg", "physical.natural_frequency_hz", "physical.base_amplitude_m"}
    assert faults(case({"friction_force_n": 1}, **AT_ONCE)).keys() == missing
