"""The digest is equal for equal questions and differs for different ones, also by the rule that made the coordinates."""

import json
import math
from typing import Any

import numpy as np
import pytest

from damperlab.studies.definition import parse_study
from damperlab.studies.reading import parse_study_text
from damperlab.studies.store.cube.definition import DefinitionDamaged, parse_stored
from damperlab.studies.variables import STANDARD

BASE: dict[str, Any] = {
    "name": "a",
    "axes": {
        "clearance_ratio": {"start": 1, "stop": 25, "num": 49},
        "friction_ratio": [0, 0.4],
        "frequency_ratio": {"start": 0.5, "stop": 2, "num": 5, "spacing": "log"},
    },
}


def digest(**changes: Any) -> str:
    return parse_study(BASE | changes).digest


def axes(**changes: Any) -> dict[str, Any]:
    return {"axes": BASE["axes"] | changes}


@pytest.mark.parametrize(
    "same",
    [
        {"name": "b"},
        {"damping_ratio": 0.0038},
        {"damping_ratio": [3.8e-3]},
        axes(clearance_ratio=np.linspace(1, 25, 49).tolist()),
        axes(frequency_ratio=[0.5, math.sqrt(0.5), 1, math.sqrt(2), 2]),
        axes(friction_ratio=[0.4, -0.0]),
        axes(friction_ratio={"start": 0, "stop": 4e-1, "num": 2.0}),
        axes(restitution=0.47, mass_ratio=1e-1),
        {"contact": {"model": "instant"}, "start": "rest", "solver": {"method": "event"}, "steady": {}},
        {"steady": {"max_cycles": 4e3}},
        {"metrics": list(reversed(STANDARD))},
        {"particle": True},
        {"excitation": "base"},
        {"excitation": None},
    ],
)
def test_spelling_order_and_free_text_do_not_count(same: dict[str, Any]) -> None:
    assert digest(**same) == digest()


def test_key_order_does_not_count() -> None:
    text = json.dumps(BASE)
    backwards = json.dumps(dict(reversed(BASE.items())) | {"axes": dict(reversed(BASE["axes"].items()))})
    assert backwards != text
    assert parse_study_text(backwards, "json").digest == parse_study_text(text, "json").digest


def test_every_part_of_the_question_counts() -> None:
    different: list[dict[str, Any]] = [
        {},
        {"damping_ratio": 0.0039},
        {"damping_ratio": np.nextafter(0.0038, 1).item()},
        axes(clearance_ratio={"start": 1, "stop": 25, "num": 50}),
        axes(restitution=0.4),
        axes(mass_ratio=0.2),
        axes(friction_ratio=[0, 0.5]),
        axes(frequency_ratio=1),
        {"particle": False},
        {"metrics": ["amplitude_ratio"]},
        {"steady": {"max_cycles": 4001}},
        {"excitation": "force"},
        {"steady": {"tolerance": 1e-5}},
        {"steady": {"periodic_tolerance": 1e-8}},
        {"physical": {"base_amplitude_m": 0.001}},
        {"physical": {"base_amplitude_m": 0.002}},
        {"physical": {"mass_kg": 0.001}},
    ]
    assert len({digest(**change) for change in different}) == len(different)


def test_what_the_scene_without_particle_ignores_does_not_count() -> None:
    bare = {"particle": False, "axes": {"frequency_ratio": [0.9, 1.0]}}
    busy = {
        "particle": False,
        "axes": {
            "frequency_ratio": [0.9, 1.0],
            "clearance_ratio": [1, 2],
            "restitution": 0.1,
            "mass_ratio": 3,
        },
    }
    assert parse_study(bare).digest == parse_study(busy).digest
    one = parse_study(bare | {"physical": {"mass_kg": 1, "particle_mass_kg": 2}})
    other = parse_study(bare | {"physical": {"mass_kg": 1}})
    assert one.digest == other.digest


def test_values_do_not_move_between_axes_unnoticed() -> None:
    one = axes(friction_ratio=[1, 2], frequency_ratio=[3])
    other = axes(friction_ratio=[1], frequency_ratio=[2, 3])
    assert digest(**one) != digest(**other)


@pytest.mark.parametrize(
    "change", [{"damping_ratio": 0.03}, {"damping_ratio": 3}, axes(friction_ratio=[0, 0.5])]
)
def test_a_definition_that_changed_is_refused(change: dict[str, Any]) -> None:
    study = parse_study(BASE)
    with pytest.raises(DefinitionDamaged, match=study.digest[:12]):
        parse_stored(study.document() | change, study.digest)
