"""Designs over bands and under ground-motion records at once: brute force, either side by itself, limits, an interruption."""

from typing import Any

import numpy as np
import pytest
import xarray as xr
from tests.studies.design.test_design import pursued as pursued_with
from tests.studies.design.test_design import solved as solved_over_bands
from tests.studies.design.test_excitations import worst_m
from tests.studies.design.test_records import SHAKEN
from tests.studies.design.test_records import solved as solved_under_records

from damperlab.service.design_report import design_report
from damperlab.studies.definition import parse_study
from damperlab.studies.design.answer import answer_document
from damperlab.studies.design.build import Build
from damperlab.studies.design.design import next_round
from damperlab.studies.design.found import Found
from damperlab.studies.ground.suite import Suite
from damperlab.studies.specification.reading import parse_specification
from damperlab.studies.specification.records import Case
from damperlab.studies.tmd.transfer import highest
from damperlab.studies.tmd.under_record import measures_under

MACHINE = {"name": "machine", "base_amplitude_m": 0.003, "frequency_hz": {"start": 2.2, "stop": 2.8}}
QUAKE = {
    "name": "quake",
    "records": [{"kanai_tajimi": {"seed": 1, "duration_s": 14, "peak_g": 0.2}}],
    "scales": [0.6],
}
BOTH: dict[str, Any] = {
    **{key: value for key, value in SHAKEN.items() if key not in ("tolerances", "builds")},
    "excitation": [MACHINE, QUAKE],
    "choose": {"friction_force_n": {"start": 2.0, "stop": 40.0}},
    "clearance_m": 0.01,
}
"""A structure whose least displacement against the base needs more friction under one of them than under the other."""
BUDGET = 12_000


def solved(study: Any) -> xr.Dataset:
    """Compute a study of either kind here."""
    return solved_under_records(study) if isinstance(study, Suite) else solved_over_bands(study)


def pursued(document: dict[str, Any]) -> tuple[Found, dict[str, xr.Dataset]]:
    """Follow a search to its end."""
    return pursued_with(document, BUDGET, solved)


def alone(excitation: dict[str, Any], **more: Any) -> Found:
    """What is found under one of them by itself."""
    bare = {key: value for key, value in excitation.items() if key != "name"}
    document = BOTH | {"measure": "worst_relative_displacement", "excitation": bare} | more
    return pursued(document)[0]


@pytest.fixture(scope="module")
def both() -> tuple[Found, dict[str, xr.Dataset]]:
    return pursued(BOTH | {"measure": "worst_displacement"})


def under_quake_m(forces_n: list[float]) -> np.ndarray:
    """Largest displacement [m] of the structure under the record, by friction force."""
    study = parse_study(
        {
            "records": QUAKE["records"],
            "mass_kg": 40.0,
            "axes": {
                "scale": QUAKE["scales"],
                "natural_frequency_hz": 2.5,
                "damping_ratio": 0.02,
                "restitution": 0.5,
                "particle_mass_kg": 4.0,
                "clearance_m": 0.01,
                "friction_force_n": forces_n,
            },
            "metrics": ["peak_absolute_displacement_m"],
        }
    )
    return solved(study)["peak_absolute_displacement_m"].values.ravel()


@pytest.mark.night
def test_no_other_force_keeps_both_lower(both) -> None:
    found, _ = both
    (machine,) = found.asked.excitations
    forces = np.linspace(2.0, 40.0, 20).tolist()
    over = [worst_m(found, Build(0.01, force, 4.0, 0.5), machine) for force in forces]
    worst = np.maximum(over, under_quake_m(forces))
    assert worst.min() > 0.98 * found.nominal.most
    # what is stated is what brute force says of it, and each of the two is told
    own = [worst_m(found, found.build, machine), float(under_quake_m([found.build.friction_force_n])[0])]
    assert found.under[0].most >= own[0] * (1 - 1e-6)
    assert found.under_records[0].value == pytest.approx(own[1], rel=1e-9)
    assert found.nominal.value == max(found.under[0].value, found.under_records[0].value)


@pytest.mark.night
def test_what_binds_and_what_each_reaches_is_told(both) -> None:
    found, _ = both
    answer = answer_document(found)
    binds = "quake" if isinstance(found.stated.under, Case) else "machine"
    assert answer["worst"]["excitation"] == binds
    assert (answer["worst"]["record"] is None) == (binds == "machine")
    assert [each["excitation"] for each in answer["excitations"]] == ["machine", "quake"]
    assert [each["value"] for each in answer["excitations"]] == [
        found.under[0].value,
        answer["cases"][0]["value"],
    ]
    assert answer["response"]["frequency_hz"]
    assert answer["design"]["base_amplitude_m"] == 0.003
    told = " ".join(answer["words"])
    assert f"Of 2 excitations `{binds}` binds" in told
    assert "under `machine` (from 2.2 Hz to 2.8 Hz with a base amplitude of 3 mm)" in told
    assert "under `quake` (under 1 ground-motion record, at a scale of 0.6)" in told
    report = design_report(found)
    assert "Under each record" in report
    assert ">quake</td>" in report
    assert "Response over the band under the largest amplitude" in report


@pytest.mark.night
def test_records_that_hardly_shake_change_no_damper() -> None:
    weak = QUAKE | {"scales": [0.001]}
    with_it, _ = pursued(BOTH | {"measure": "worst_relative_displacement", "excitation": [MACHINE, weak]})
    without = alone(MACHINE)
    assert with_it.build == without.build
    assert (with_it.stated.value, with_it.stated.error) == (without.stated.value, without.stated.error)
    assert with_it.binding.low == without.binding.low


@pytest.mark.night
def test_a_band_that_hardly_moves_changes_no_damper() -> None:
    # whose peak is friction's alone: a structure that its base does not move does not move against it
    weak = MACHINE | {"base_amplitude_m": 1e-5}
    with_it, _ = pursued(BOTH | {"measure": "worst_relative_displacement", "excitation": [weak, QUAKE]})
    without = alone(QUAKE)
    assert with_it.build == without.build
    assert with_it.stated.value == without.stated.value
    assert with_it.stated.under == without.stated.under


@pytest.mark.night
def test_a_limit_on_accelerations_holds_under_both() -> None:
    limits = {"acceleration_m_per_s2": 1.0}
    found, _ = pursued(BOTH | {"measure": "worst_acceleration", "limits": limits})
    case, machine = found.asked.cases[0], found.asked.excitations[0].largest
    quake = float(found.book.curve(found.build, case)["peak_absolute_acceleration_m_s2"][0])
    band = found.book.curve(found.build, machine)
    running = float((band.base_m * (2.0 * np.pi * 2.5) ** 2 * band["acceleration_ratio"]).max())
    assert found.stated.value == pytest.approx(max(quake, running), rel=1e-12)
    assert found.stated.reached["acceleration_m_per_s2"] == pytest.approx(max(quake, running), rel=1e-12)
    assert [each.value for each in found.under] == pytest.approx([running], rel=1e-12)
    assert "the largest acceleration of the structure that was computed" in " ".join(
        answer_document(found)["words"]
    )


@pytest.mark.night
def test_the_tuned_mass_damper_is_judged_under_both(both) -> None:
    found, _ = both
    assert found.absorber is not None
    (records,) = found.asked.records
    (case,) = records.cases
    one, motion = found.absorber.absorber, records.motions[case.source.id]
    band = 0.003 * highest(one, 0.02, "base", (2.2 / 2.5, 2.8 / 2.5)).value
    under = measures_under(one, 0.02, 5.0 * np.pi, motion, case.scale, records.tail_s)
    assert found.absorber.value == pytest.approx(
        max(band, under[found.asked.measured(case).variable]), rel=1e-12
    )


@pytest.mark.night
def test_an_interrupted_design_ends_as_one_that_was_not(both) -> None:
    found, cubes = both
    assert parse_specification(found.asked.document).digest == found.asked.digest
    asked = parse_specification(BOTH | {"measure": "worst_displacement"})
    resumed = next_round(asked, BUDGET, dict(reversed(cubes.items())))
    assert isinstance(resumed, Found)
    assert answer_document(resumed) == answer_document(found)
