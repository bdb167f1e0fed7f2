"""Designs of materials whose contact takes time: each is computed with its own."""

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
