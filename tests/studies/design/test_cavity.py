"""A damper whose particle rubs, or whose cavity is tilted: what a specification says of it, and what is stated."""

from typing import Any

import numpy as np
import pytest
from tests.studies.design.test_design import pursued, solved
from tests.studies.documents import fields_of

from damperlab.studies.answers.particle_friction import COEFFICIENTS, WITHIN
from damperlab.studies.cavity import LEVEL, Cavity
from damperlab.studies.definition import parse_harmonic
from damperlab.studies.design.answer import answer_document
from damperlab.studies.design.build import Build
from damperlab.studies.design.design import designing
from damperlab.studies.design.space import Space
from damperlab.studies.ground.suite import Suite
from damperlab.studies.specification.reading import parse_specification

VELOCITY = {"base_velocity_m_per_s": 0.05, "frequency_hz": {"start": 6.5, "stop": 9}}
NARROW = {"base_amplitude_m": 0.001, "frequency_hz": {"start": 7.4, "stop": 7.8}}
RECORDS = {"records": ["el-centro"], "scales": [1]}
RUBS = {"particle_friction_coefficient": 0.1}
FLOOR: dict[str, Any] = {
    "structure": {"mass_kg": 250, "natural_frequency_hz": 7.6, "damping_ratio": 0.02},
    "excitation": {"base_amplitude_m": 0.001, "frequency_hz": {"start": 6.5, "stop": 9}},
    "choose": {"clearance_m": {"start": 0.001, "stop": 0.01}},
    "friction_force_n": 300,
    "particle_mass_kg": 20,
    "restitution": 0.5,
    "budget_points": 1500,
    "builds": 0,
}


def amplitudes_m(clearance_m: float, frequency_ratio: Any, **cavity: float) -> np.ndarray:
    """Displacement [m] of the floor with a damper, of a study."""
    physical = {
        "mass_kg": 250, "natural_frequency_hz": 7.6, "base_amplitude_m": 0.001, "particle_mass_kg": 20,
        "clearance_m": clearance_m, "friction_force_n": 300, **cavity,
    }  # fmt: skip
    axes = {"restitution": 0.5, "frequency_ratio": frequency_ratio}
    asked = {"damping_ratio": 0.02, "physical": physical, "axes": axes, "metrics": ["amplitude_ratio"]}
    study = parse_harmonic(asked)
    return 0.001 * solved(study)["amplitude_ratio"].values


BAND = {"start": 6.5 / 7.6, "stop": 9 / 7.6, "num": 201}


@pytest.mark.night
@pytest.mark.parametrize(
    "cavity",
    [
        {"particle_friction_coefficient": 0.2},
        {"particle_friction_coefficient": 0.2, "tilt_deg": 20},
        {"tilt_deg": 90},
    ],
)
def test_what_is_stated_is_what_a_study_of_that_damper_computes(cavity: dict[str, float]) -> None:
    found, cubes = pursued({**FLOOR, **cavity}, 500)
    ratio = "gravity_ratio" if "tilt_deg" in cavity else "particle_friction_ratio"
    assert all(ratio in cube.sizes for cube in cubes.values() if cube["mass_ratio"].values[0] > 0)
    own = found.build.clearance_m
    at_worst = amplitudes_m(own, found.stated.frequency_ratio, **cavity).item()
    assert at_worst == pytest.approx(found.stated.value, rel=1e-9)
    assert amplitudes_m(own, BAND, **cavity).max() <= found.stated.most * (1 + 1e-9)
    rows = answer_document(found)["verdict"]["rows"]
    assert rows[0][0] == "given"
    assert (f"{cavity['tilt_deg']}°" if "tilt_deg" in cavity else "lying, μ_i = 0.2") in rows[0][1]


@pytest.mark.parametrize("excitation", [VELOCITY, RECORDS])
def test_friction_of_the_particle_is_in_what_a_design_asks_under_a_velocity_and_under_records(
    excitation: dict[str, Any],
) -> None:
    asked = FLOOR | RUBS | {"excitation": excitation, "measure": "worst_relative_displacement"}
    for study in next(designing(parse_specification(asked), 1500)).studies:
        numbers = study.numbers if isinstance(study, Suite) else study.physical.values()
        assert numbers["particle_friction_coefficient"] == 0.1


LEVELLED = FLOOR | {"tilt_deg": 0, "particle_friction_coefficient": 0}


def test_a_level_cavity_without_friction_asks_for_the_studies_of_one_of_which_nothing_is_said() -> None:
    plain, said = (next(designing(parse_specification(asked), 1500)) for asked in (FLOOR, LEVELLED))
    assert [study.digest for study in said.studies] == [study.digest for study in plain.studies]
    assert not any("gravity_ratio" in study.coordinates for study in said.studies)


def test_the_friction_of_the_particle_that_a_damper_bears_is_computed_with_it() -> None:
    found, _ = pursued(FLOOR | {"choose": {}, "clearance_m": 0.004, "excitation": NARROW}, 2500, front=False)
    bears = found.margins["particle_friction_coefficient"]
    assert bears.low == 0.0
    assert bears.fails_above is not None
    band = {"start": 7.4 / 7.6, "stop": 7.8 / 7.6, "num": 61}
    worst = {
        friction: amplitudes_m(0.004, band, particle_friction_coefficient=friction).max()
        for friction in (bears.high, bears.fails_above)
        if friction
    }
    assert worst[bears.fails_above] > WITHIN * found.stated.value
    assert worst.get(bears.high, 0.0) <= WITHIN * found.stated.most
    row = answer_document(found)["verdict"]["rows"][0]
    assert row[:2] == ["assumed", "lying, frictionless"]
    assert f"{bears.fails_above:.3g}" in row[2]


def test_a_damper_that_bears_all_friction_that_is_looked_at_is_not_said_to_fail() -> None:
    wide = {"choose": {}, "clearance_m": 0.004, "excitation": NARROW, "limits": {"displacement_m": 1.0}}
    found = pursued(FLOOR | wide, 2500, front=False)[0]
    bears = found.margins["particle_friction_coefficient"]
    assert (bears.high, bears.fails_above) == (COEFFICIENTS[-1], None)
    row = answer_document(found)["verdict"]["rows"][0]
    assert row[2].endswith(f"μ_i = {COEFFICIENTS[-1]:g}, the highest examined")


def test_a_range_of_the_friction_and_a_list_of_tilts_are_candidates() -> None:
    chosen = {"particle_friction_coefficient": {"start": 0, "stop": 0.5}, "tilt_deg": [0, 30, 90]}
    space = Space(parse_specification(FLOOR | {"clearance_m": 0.004, "choose": chosen}))
    assert space.names == ("particle_friction_coefficient", "tilt_deg")
    assert space.build((0.5, 0.4)).cavity == Cavity(0.25, 30)
    assert space.build((0.0, 0.0)).cavity == LEVEL


@pytest.mark.parametrize(
    ("tolerated", "ends"),
    [
        ({"tilt_deg": (88, 2)}, [86, 90]),
        ({"tilt_deg": (90, 2)}, [88, 90]),
        ({"particle_friction_coefficient": (0.1, 0.05)}, [0.05, 0.15]),
    ],
)
def test_a_tolerance_of_a_cavity_moves_builds_between_its_ends(
    tolerated: dict[str, tuple[float, float]], ends: list[float]
) -> None:
    ((name, (value, off)),) = tolerated.items()
    fixed = FLOOR | RUBS | {"choose": {}, "clearance_m": 0.004, name: value, "tolerances": {name: off}}
    asked = parse_specification(fixed)
    assert asked.toleranced == [name]
    cavity = Cavity(**{"particle_friction_coefficient": 0.1, "tilt_deg": 88.0, name: value})
    build = Build(0.004, 300, 20, 0.5, cavity=cavity)
    moved = [build.moved(asked, {name: share}).cavity for share in (-1, 1)]
    assert [getattr(each, name) for each in moved] == pytest.approx(ends)


HEAVY = {"structure": {**FLOOR["structure"], "mass_kg": "heavy"}}


@pytest.mark.parametrize(
    ("more", "field"),
    [
        ({"tilt_deg": 91}, "tilt_deg"),
        ({"choose": {"tilt_deg": [0, 90]}, "tilt_deg": 5, "clearance_m": 0.004}, "tilt_deg"),
        ({"choose": {"tilt_deg": [0, 91]}, "clearance_m": 0.004}, "choose.tilt_deg[1]"),
        ({"choose": {"tilt_deg": [0, 90]}, "clearance_m": 0.004, "contact_time_s": 0.01}, "choose.tilt_deg"),
        ({"tilt_deg": 90, "contact_time_s": 0.01}, "tilt_deg"),
        ({"tolerances": {"particle_friction_coefficient": 0.05}}, "tolerances.particle_friction_coefficient"),
        ({"tilt_deg": 0, "tolerances": {"tilt_deg": 1}, "contact_time_s": 0.01}, "tilt_deg"),
        ({"tilt_deg": 0, "tolerances": {"tilt_deg": 91}}, "tolerances.tilt_deg"),
        ({"tilt_deg": 89, "tolerances": {"tilt_deg": 2}}, "tolerances.tilt_deg"),
        (
            RUBS | {"tolerances": {"particle_friction_coefficient": 0.11}},
            "tolerances.particle_friction_coefficient",
        ),
        # beside a structure that is wrong
        ({"structure": 3, "tolerances": {"tilt_deg": 2}}, "tolerances.tilt_deg"),
        (HEAVY | {"tolerances": {"tilt_deg": 2}}, "tolerances.tilt_deg"),
    ],
)
def test_what_cannot_be_said_of_a_cavity_is_refused(more: dict[str, Any], field: str) -> None:
    assert field in fields_of(parse_specification, FLOOR | more)
