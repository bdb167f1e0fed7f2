"""Designs of materials whose contact takes time: each is computed with its own, over a band and under records."""

from typing import Any

import numpy as np
import pytest
import xarray as xr
from tests.studies.design.test_design import DAMPED
from tests.studies.design.test_design import pursued as pursued_with
from tests.studies.design.test_mixture import solved
from tests.studies.design.test_records import SHAKEN

from damperlab.studies.choices import DwellContact
from damperlab.studies.design.answer import answer_document
from damperlab.studies.design.found import Found
from damperlab.studies.design.space import Space
from damperlab.studies.specification.excitation import Amplitude
from damperlab.worker.ground.design import Damper, Structure
from damperlab.worker.ground.response import ground_response
from damperlab.worker.point import Design, simulate_ready
from damperlab.worker.solver.particle import Particle

TIME_S = 0.006
CHOSEN: dict[str, Any] = {
    "choose": {
        "restitution": [
            {"name": "steel", "restitution": 0.8},
            {"name": "rubber", "restitution": 0.5, "contact_time_s": TIME_S},
        ]
    },
    "tolerances": {"natural_frequency_hz": "2%"},
    "builds": 4,
}
RUBBER, STEEL = (0.0,), (1.0,)
"""The candidates: materials in the order of their restitution."""


def materials(document: dict[str, Any], **given: Any) -> dict[str, Any]:
    return {name: value for name, value in document.items() if name != "restitution"} | CHOSEN | given


def pursued(document: dict[str, Any]) -> tuple[Found, list[Any]]:
    """Follow a search to its end; the studies that it took."""
    studies: list[Any] = []

    def solve(study: Any) -> xr.Dataset:
        studies.append(study)
        return solved(study)

    return pursued_with(document, solve=solve)[0], studies


@pytest.fixture(scope="module")
def damped() -> tuple[Found, list[Any]]:
    return pursued(materials(DAMPED, clearance_m=0.003, friction_force_n=40.0))


@pytest.mark.night
def test_each_material_has_its_own_contact_time_in_every_study(damped) -> None:
    found, studies = damped
    assert found.build.restitution == 0.5
    ratio = TIME_S * 2.0 * np.pi * 8.0
    times = set()
    for study in studies:
        # rubber is recommended, and its restitution moved alone as well
        rubber = study.particle and 0.8 not in study.coordinates["restitution"]
        assert isinstance(study.contact, DwellContact) == rubber
        if rubber:
            times.add(study.contact.contact_time / ratio)
    # of a structure that is off it is as long, and a longer or a shorter part of its period
    for share in (0.98, 1.0, 1.02):
        assert min(abs(time - share) for time in times) < 1e-12
    assert max(abs(time - 1.0) for time in times) < 0.02 + 1e-12


@pytest.mark.night
@pytest.mark.parametrize(("material", "restitution", "time_s"), [(RUBBER, 0.5, TIME_S), (STEEL, 0.8, 0.0)])
def test_a_response_over_the_band_is_that_of_single_points_with_this_contact(
    damped, material: tuple[float], restitution: float, time_s: float
) -> None:
    found, _ = damped
    build = Space(found.asked).build(material)
    (excitation,) = found.asked.excitations
    curve = found.book.curve(build, Amplitude(excitation, 0.001))
    assert curve.r.size
    friction = 40.0 / (found.asked.structure.stiffness_n_per_m * 0.001)
    particle = Particle(3.0, restitution, 0.1, time_s * 2.0 * np.pi * 8.0 or None)
    for r, value in zip(curve.r, curve["amplitude_ratio"], strict=True):
        alone = simulate_ready(Design(0.02, float(r), friction, particle)).metrics["amplitude_ratio"]
        # one ulp of a ratio makes another number of a response that does not repeat
        assert alone == pytest.approx(value, rel=0.05)


@pytest.mark.night
@pytest.mark.parametrize(("material", "restitution", "time_s"), [(RUBBER, 0.5, TIME_S), (STEEL, 0.8, 0.0)])
def test_a_response_under_a_record_is_that_of_this_contact(
    material: tuple[float], restitution: float, time_s: float
) -> None:
    found, _ = pursued(materials(SHAKEN, clearance_m=0.01, friction_force_n=10.0))
    build = Space(found.asked).build(material)
    structure, (records,) = Structure(40.0, 2.5, 0.02), found.asked.records
    contact = (
        {"contact": DwellContact(model="dwell", contact_time=time_s * structure.omega)} if time_s else {}
    )
    damper = Damper(10.0, 4.0, 0.01, restitution, **contact)
    for case in found.asked.cases:
        curve = found.book.under_record(build, case)
        alone = ground_response(structure, damper, records.motions[case.source.id], case.scale)
        assert curve["peak_relative_displacement_m"] == pytest.approx(
            [alone.peak_relative_displacement_m], rel=1e-6
        )


@pytest.mark.night
def test_the_answer_names_the_material_and_its_contact_time() -> None:
    document = {**DAMPED, "choose": {"friction_force_n": {"start": 30.0, "stop": 50.0}}, "clearance_m": 0.003}
    found, _ = pursued(document | {"tolerances": {}, "contact_time_s": TIME_S})
    answer = answer_document(found)
    assert answer["design"]["contact_time_s"] == TIME_S
    assert "a coefficient of restitution of 0.5 (in contact for 6 ms)" in answer["words"][0]
