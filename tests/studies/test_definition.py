"""The study at the border: every fault named, every default stated, nothing but StudyFaults raised."""

import json
import math
import pickle
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.studies.documents import told_of

from damperlab.studies.definition import EXAMPLES, KEYS, Study, parse_study
from damperlab.studies.faults import MAX_FAULTS, Fault, StudyFaults
from damperlab.studies.guard import MAX_DEPTH, MAX_VALUES
from damperlab.studies.reading import named_studies
from damperlab.studies.variables import DIMENSIONS, STANDARD

MINIMAL: dict[str, Any] = {"axes": {"clearance_ratio": 10, "frequency_ratio": 1}}


def faults(document: object) -> dict[str, str]:
    return told_of(parse_study, document)


def with_axes(**axes: Any) -> dict[str, Any]:
    return {"axes": MINIMAL["axes"] | axes}


def test_silent_study_is_the_papers_structure_without_friction() -> None:
    coordinates = parse_study(MINIMAL).coordinates
    assert tuple(coordinates) == DIMENSIONS
    assert {name: float(values[0]) for name, values in coordinates.items()} == {
        "damping_ratio": 0.0038,
        "restitution": 0.47,
        "mass_ratio": 0.1,
        "clearance_ratio": 10.0,
        "friction_ratio": 0.0,
        "frequency_ratio": 1.0,
    }
    study = parse_study(MINIMAL)
    assert study.metrics == STANDARD
    assert (study.steady.max_cycles, study.steady.tolerance, study.steady.periodic_tolerance) == (
        4000,
        0.02,
        1e-9,
    )
    assert (study.shape, study.points) == ((1, 1, 1, 1, 1, 1), 1)


def test_scene_without_particle_has_length_one_and_zero_in_its_three_dimensions() -> None:
    axes = {"clearance_ratio": [1, 2, 3], "frequency_ratio": [0.9, 1.0]}
    study = parse_study({"particle": False, "axes": axes})
    assert study.shape == (1, 1, 1, 1, 1, 2)
    for name in ("restitution", "mass_ratio", "clearance_ratio"):
        assert study.coordinates[name].tolist() == [0.0]
    parse_study({"particle": False, "axes": {"frequency_ratio": 1}})


def test_every_fault_is_reported_at_once() -> None:
    found = faults(
        {
            "nam": "x",
            "damping_ratio": 1,
            "axes": {
                "clearance_ratio": [1, -0.5, math.nan, 1],
                "friction_ratio": {"start": 1, "num": 10**400, "step": 2},
                "frequency_ratio": math.inf,
                "damping_ratio": 0.1,
            },
            "particle": 1,
            "contact": {"model": "springy"},
            "metrics": ["amplitude"],
            "steady": {"max_cycles": 0, "tolerance": True},
            "physical": {"mass_kg": -1},
        }
    )
    told = {
        "nam": "`name`",
        "damping_ratio": "",
        "axes.clearance_ratio[1]": "-0.5",
        "axes.clearance_ratio[2]": "NaN",
        "axes.clearance_ratio[3]": "",
        "axes.friction_ratio.step": "",
        "axes.friction_ratio.stop": "",
        "axes.friction_ratio.num": "400 digits",
        "axes.frequency_ratio": "",
        "axes.damping_ratio": "top of the document",
        "particle": "",
        "contact.model": "instant or dwell or compliant",
        "metrics[0]": "`amplitude_ratio`",
        "steady.max_cycles": "",
        "steady.tolerance": "",
        "physical.mass_kg": "",
    }
    assert found.keys() == told.keys()
    assert all(words in found[field] for field, words in told.items())


@pytest.mark.parametrize("document", [None, True, 3, "figure-11", [], [MINIMAL], b"{}", {1, 2}, object()])
def test_what_is_no_mapping_is_no_study(document: object) -> None:
    assert set(faults(document)) == {"document"}


@pytest.mark.parametrize(
    ("name", "allowed", "refused"),
    [
        ("damping_ratio", [0, 0.999999], [-1e-9, 1, 1.5]),
        ("restitution", [0, 1], [-0.01, 1.0000001]),
        ("mass_ratio", [0, 1e12], [-0.1, 2e12]),
        ("clearance_ratio", [1e-12, 1e12], [0, -1, 1e-13, 2e12]),
        ("friction_ratio", [0, 1e12], [-0.1, 2e12]),
        ("frequency_ratio", [1e-4, 1e4], [0, -1, 1e-5, 1e5]),
    ],
)
def test_bounds_of_each_ratio(name: str, allowed: list[float], refused: list[float]) -> None:
    def document(value: object) -> dict[str, Any]:
        return MINIMAL | {name: value} if name == "damping_ratio" else with_axes(**{name: value})

    field = name if name == "damping_ratio" else f"axes.{name}"
    for value in allowed:
        assert parse_study(document(value)).coordinates[name].tolist() == [value]
    for value in [*refused, math.nan, math.inf, -math.inf, True, None, "1", {}, 10**400, -(10**5000)]:
        assert all(found.startswith(field) for found in faults(document(value)))


def test_grid_over_the_limit_is_refused_before_it_is_expanded() -> None:
    million = {"start": 1, "stop": 2, "num": 1_000_000}
    found = faults(with_axes(clearance_ratio=million, friction_ratio=million, frequency_ratio=million))
    assert "1,000,000,000,000,000,000 design points" in found["axes"]
    limit = with_axes(clearance_ratio=million, friction_ratio=million | {"num": 1000})
    assert parse_study(limit).points == 10**9
    limit["axes"]["friction_ratio"]["num"] = 1001
    assert set(faults(limit)) == {"axes"}


def test_depth_and_size_are_bounded_and_cycles_end() -> None:
    deep: Any = 1.0
    for _ in range(100_000):
        deep = [deep]
    assert str(MAX_DEPTH) in next(iter(faults(with_axes(clearance_ratio=deep)).values()))
    cyclic: dict[str, Any] = {}
    cyclic["axes"] = cyclic
    faults(cyclic)
    bomb: Any = [1.0]
    for _ in range(6):
        bomb = [bomb] * 9
    faults({"axes": bomb})
    assert "axes.clearance_ratio" in faults(with_axes(clearance_ratio=list(range(1, MAX_VALUES + 2))))
    assert parse_study(with_axes(clearance_ratio=list(range(1, MAX_VALUES + 1)))).points == MAX_VALUES


def test_an_answer_to_a_hostile_document_stays_small() -> None:
    with pytest.raises(StudyFaults) as caught:
        parse_study({f"key{i}" + "x" * 10_000: i for i in range(100)} | {})
    assert len(caught.value.faults) <= MAX_FAULTS + 1
    assert len(str(caught.value)) < 60_000
    assert "axes.restitution" in faults(with_axes(clearance_ratio=[-1.0] * MAX_VALUES, restitution=2))


def test_status_is_stored_in_any_case_and_metrics_take_the_registrys_order() -> None:
    study = parse_study(MINIMAL | {"metrics": ["cycles", "amplitude_ratio"]})
    assert study.metrics == ("amplitude_ratio", "cycles", "status")
    assert set(faults(MINIMAL | {"metrics": ["cycles", "cycles"]})) == {"metrics[1]"}
    assert set(faults(MINIMAL | {"metrics": []})) == {"metrics"}


@pytest.mark.parametrize("document", EXAMPLES)
def test_examples_parse_and_documents_parse_back(document: dict[str, Any]) -> None:
    study = parse_study(document)
    again = parse_study(json.loads(json.dumps(study.document())))
    assert again == study
    assert again.digest == study.digest
    assert pickle.loads(pickle.dumps(study)) == study
    assert Study(**document) == study


def test_a_study_cannot_be_changed_or_made_past_the_checks() -> None:
    study = parse_study(MINIMAL)
    with pytest.raises(ValueError, match="frozen"):
        study.particle = False  # type: ignore[misc]
    with pytest.raises(ValueError, match="read-only"):
        study.coordinates["clearance_ratio"][0] = 3.0
    assert study.coordinates["clearance_ratio"].tolist() == [10.0]
    with pytest.raises(ValueError, match="plain data"):
        Study(axes=study.axes)


known_keys = st.sampled_from(
    sorted({key for keys in KEYS.values() for key in keys} | {"start", "stop", "num", "spacing"})
)
near_values = st.recursive(
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats()
    | st.sampled_from(["rest", "log", "instant"])
    | st.text(max_size=8),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(known_keys, inner, max_size=6),
    max_leaves=20,
)


def parses_or_is_refused(document: object) -> None:
    refused: tuple[Fault, ...] = ()
    try:
        study = parse_study(document)
    except StudyFaults as error:
        refused = error.faults
    else:
        means_something(study)
        return
    assert refused
    for fault in refused:
        assert all((fault.field, fault.found, fault.allowed, fault.advice))
        str(fault).encode("utf-8")


def means_something(study: Study) -> None:
    assert parse_study(study.document()) == study
    for values in study.coordinates.values():
        assert np.isfinite(values).all()
        assert (np.diff(values) > 0).all()
    assert study.points == math.prod(study.shape) >= 1


@given(st.sampled_from([*EXAMPLES, *(s.document() for s in named_studies().values())]), st.data())
@settings(max_examples=80, deadline=None)
def test_damaged_studies_only_ever_raise_study_faults(base: dict[str, Any], data: st.DataObject) -> None:
    document = json.loads(json.dumps(base))
    for _ in range(data.draw(st.integers(1, 3))):
        here = document
        while True:
            key = data.draw(st.sampled_from(sorted(here)) | known_keys | st.text(max_size=4))
            if here.get(key) and isinstance(here[key], dict) and data.draw(st.booleans()):
                here = here[key]
                continue
            here[key] = data.draw(near_values)
            break
    parses_or_is_refused(document)


def test_contact_time_is_a_number_or_a_name_of_the_paper() -> None:
    def contact(written: object) -> dict[str, object]:
        return {**MINIMAL, "contact": {"model": "dwell", "contact_time": written}}

    named = parse_study(contact("paper_hard_printed"))
    assert named.digest == parse_study(contact(2.0 * math.pi * 2.5 * 0.046)).digest
    for wrong in ("paper_hard", 0.0, -1.0, True, math.nan):
        assert set(faults(contact(wrong))) == {"contact.contact_time"}
    assert "paper_hard_real" in faults(contact("paper_hard"))["contact.contact_time"]
    assert set(faults({**MINIMAL, "contact": {"model": "dwell"}})) == {"contact.contact_time"}
