"""A ground-motion suite as a study: read, refused, told apart, and read back."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.studies.documents import fields_of

from damperlab.studies.definition import Study, parse_study
from damperlab.studies.digest import family_digest
from damperlab.studies.faults import StudyFaults
from damperlab.studies.ground.motion import GroundMotion
from damperlab.studies.ground.shelf import Shelf
from damperlab.studies.ground.suite import Suite
from damperlab.studies.ground.variables import VARIABLES
from damperlab.studies.plan import make_plan
from damperlab.worker.dispatch.cost_model import seconds_per_point

ASKED: dict[str, Any] = {
    "records": ["northridge", "el-centro"],
    "axes": {"scale": [1, 3], "clearance_m": {"start": 0.001, "stop": 0.004, "num": 4}},
}
MILLION = {"start": 0.001, "stop": 1, "num": 10**6}
SPIKE = GroundMotion("spike", 0.01, np.array([0.0, 1.0, -1.0, 0.0]))


def suite_of(shelf: Shelf | None = None, **changes: Any) -> Suite:
    suite = parse_study({**ASKED, **changes}, shelf)
    assert isinstance(suite, Suite)
    return suite


def test_a_document_that_names_records_is_a_suite() -> None:
    suite = suite_of()
    assert suite.shape == (2, 1, 1, 2, 1, 1, 4, 1)
    assert suite.coordinates["record"].tolist() == ["el-centro-180", "northridge-090"]
    assert suite.metrics == tuple(v.name for v in VARIABLES.values() if not (v.start or v.rubbing))
    assert suite_of(starts=3, particle_friction_coefficient=0.1).metrics == tuple(VARIABLES)
    assert isinstance(parse_study({"axes": {"clearance_ratio": 5, "frequency_ratio": 1}}), Study)


@pytest.mark.parametrize(
    ("change", "field"),
    [
        ({"records": []}, "records"),
        ({"records": ["loma-prieta", "loma-prieta-000"]}, "records[1]"),
        ({"records": ["nowhere"]}, "records[0]"),
        ({"records": [{"id": "el-centro", "sha": 1}]}, "records[0].sha"),
        ({"records": [{"kanai_tajimi": {"seed": -1}}]}, "records[0].kanai_tajimi.seed"),
        ({"axes": {"scale": [1, -1]}}, "axes.scale[1]"),
        ({"axes": {"clearance": 1}}, "axes.clearance"),
        ({"axes": 5}, "axes"),
        ({"clearance_m": 1}, "clearance_m"),
        ({"mass_kg": 0}, "mass_kg"),
        ({"axes": {"tilt_deg": [0, 90]}}, "axes.tilt_deg"),
        ({"tilt_deg": 5, "contact": {"model": "dwell", "contact_time": 0.1}}, "tilt_deg"),
        ({"axes": {"clearance_m": MILLION, "friction_force_n": MILLION}}, "axes"),
        ({"axes": {"natural_frequency_hz": 1000}}, "axes.natural_frequency_hz"),
        ({"contact": {"model": "compliant"}}, "contact.contact_time"),
        ({"contact": {"model": "compliant", "contact_time": 0.1}, "axes": {"restitution": [0, 0.5]}}, "axes.restitution"),
        ({"contact": {"model": "dwell"}}, "contact.contact_time"),
        ({"metrics": ["growth"]}, "metrics[0]"),
        ({"metrics": ["amplitude_ratio"]}, "metrics[0]"),
        ({"name": 5}, "name"),
        ({"starts": 10**6}, "starts"),
    ],
)  # fmt: skip
def test_bad_suites_are_refused(change: dict[str, Any], field: str) -> None:
    assert field in fields_of(suite_of, **change)


def test_the_digest_is_that_of_what_is_asked() -> None:
    suite = suite_of()
    same = {
        "records": ["el-centro-180", "northridge-090"],
        "name": "another",
        "seed": 5,
        "perturbation_m": 1.0,
    }
    same["axes"] = {"clearance_m": [0.004, 0.003, 0.002, 0.001], "scale": [3.0, 1.0]}
    assert parse_study(same).digest == suite.digest
    others = [
        {"records": ["northridge"]},
        {"starts": 1},
        {"starts": 1, "seed": 1},
        {"tail_s": 1.0},
        {"metrics": ["status", "impacts"]},
        {"contact": {"model": "dwell", "contact_time": 0.1}},
    ]
    assert len({suite.digest, *(suite_of(**other).digest for other in others)}) == 1 + len(others)
    # points of suites that differ in grid and metrics alone are the same
    family = family_digest(suite, {"identity": "k"})
    assert family == family_digest(suite_of(records=["loma-prieta"], metrics=["impacts"]), {"identity": "k"})
    assert family != family_digest(suite_of(tail_s=1.0), {"identity": "k"})


def test_a_definition_reads_back_without_its_records(tmp_path: Path) -> None:
    shelf = Shelf(tmp_path)
    record_id, _ = shelf.put(SPIKE)
    recipe = {"kanai_tajimi": {"seed": 4, "duration_s": 15}}
    suite = suite_of(shelf, records=[record_id, recipe, "el-centro"], starts=2, metrics=["growth"])
    assert all(suite.records[i].id <= suite.records[i + 1].id for i in range(2))
    held = suite.attachments()
    for source in suite.records:
        motion = source.read(held[source.key])
        assert motion.step_s == suite.motions[source.id].step_s
        np.testing.assert_array_equal(motion.acceleration_m_s2, suite.motions[source.id].acceleration_m_s2)
        with pytest.raises(ValueError, match=source.id):
            source.read(held[source.key][:-8] + bytes(8) if source.id == "el-centro-180" else bytes(32))

    stored = parse_study(suite.document())
    assert stored == suite
    assert stored.digest == suite.digest
    with pytest.raises(StudyFaults, match="Upload the record again"):
        stored.attachments()
    # submitted again it is the same study, as long as the record is there and what it was
    assert parse_study(suite.document(), shelf).attachments() == held
    for path in shelf.folder.glob("*.npy"):
        path.unlink()
    with pytest.raises(StudyFaults, match="Upload it again"):
        parse_study(suite.document(), shelf)
    told = suite.document()
    next(each for each in told["records"] if each["id"] == "el-centro-180")["sha256"] = "0" * 64
    with pytest.raises(StudyFaults, match="Leave `sha256` out"):
        parse_study(told, shelf)


def test_a_block_shares_record_and_structure() -> None:
    large = suite_of(
        records=["el-centro", "loma-prieta", "northridge"],
        axes={
            "natural_frequency_hz": [1, 5, 50],
            "clearance_m": {"start": 0.001, "stop": 0.1, "num": 100},
            "friction_force_n": {"start": 0.1, "stop": 1, "num": 100},
        },
    )
    plan = make_plan(large, seconds_per_point)
    assert plan.chunk[:2] == (1, 1)
    # a stiff structure under a long record is what costs
    slowest = plan.block(int(plan.order()[0]))
    assert (slowest.start[0], slowest.start[1]) == (0, 2)
