"""Designs of materials whose contact takes time: each is computed with its own, over a band and under records."""

import json
from typing import Any

import numpy as np
import pytest
from tests.studies.design.test_design import DAMPED, pursued
from tests.studies.documents import without

from damperlab.studies.choices import DwellContact
from damperlab.studies.definition import parse_study
from damperlab.studies.design.answer import answer_document
from damperlab.studies.design.found import Found
from damperlab.studies.design.space import Space
from damperlab.studies.specification.excitation import Amplitude
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


@pytest.fixture(scope="module")
def damped() -> tuple[Found, list[Any]]:
    """Follow a search to its end; the studies that it took."""
    document = without(DAMPED, "restitution") | CHOSEN
    found, cubes = pursued(document | {"clearance_m": 0.003, "friction_force_n": 40.0})
    return found, [parse_study(json.loads(cube.attrs["study"])) for cube in cubes.values()]


@pytest.mark.night
def test_each_material_has_its_own_contact_time_in_every_study(damped) -> None:
    found, studies = damped
    assert found.build.restitution == 0.5
    answer = answer_document(found)
    assert answer["design"]["contact_time_s"] == TIME_S
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
        alone = simulate_ready(Design(0.02, float(r), friction, particle), followed=False).metrics
        # one ulp of a ratio makes another number of a response that does not repeat
        assert alone["amplitude_ratio"] == pytest.approx(value, rel=0.05)
