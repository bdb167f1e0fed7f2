"""Blocks of suites, a ground-motion suite resumed, and the spread over perturbed starts."""

import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.worker.run_here import run_here

from damperlab.studies.choices import DwellContact
from damperlab.studies.definition import parse_study
from damperlab.studies.ground.builtin import builtin_record
from damperlab.studies.ground.motion import GroundMotion
from damperlab.studies.ground.shelf import Shelf
from damperlab.studies.ground.suite import Suite
from damperlab.studies.plan import Block, plan_with_chunk
from damperlab.studies.store.care.backup import copy_store
from damperlab.studies.store.care.verify import repair, verify
from damperlab.studies.store.store import Store
from damperlab.studies.variables import Status
from damperlab.worker.dispatch.cost_model import seconds_per_point
from damperlab.worker.ground.block import draw_of, solve_suite_block
from damperlab.worker.ground.comparison import CHAOTIC, spread
from damperlab.worker.ground.design import Damper, Structure
from damperlab.worker.ground.response import ground_response
from damperlab.worker.provenance import code_hash, provenance
from damperlab.worker.worker_process.tasks import run_block

ASKED: dict[str, Any] = {
    "records": ["northridge", "northridge-360"],
    "axes": {
        "scale": [1, 3],
        "natural_frequency_hz": [1.5, 2.5],
        "clearance_m": {"start": 0.001, "stop": 0.004, "num": 3},
        "friction_force_n": [0.05, 0.2],
    },
    "starts": 2,
}
SHAKE = GroundMotion("shake", 0.02, np.sin(0.3 * np.arange(200.0)))


def suite_of(**changes: Any) -> Suite:
    suite = parse_study({**ASKED, **changes})
    assert isinstance(suite, Suite)
    return suite


def solved(suite: Suite, block: Block) -> dict[str, np.ndarray]:
    return solve_suite_block(suite, block, lambda source: suite.motions[source.id])


def test_every_point_is_its_single_run_in_whatever_block() -> None:
    suite = suite_of()
    whole = solved(suite, Block.whole(suite.shape))
    assert whole["status"].shape == (2, 2, 1, 2, 1, 1, 3, 2)
    assert list(whole) == list(suite.metrics)
    plan = plan_with_chunk(suite, (2, 1, 1, 2, 1, 1, 2, 1), seconds_per_point)
    for index in range(plan.count):
        block = plan.block(index)
        for name, values in solved(suite, block).items():
            assert values.tobytes() == np.ascontiguousarray(whole[name][block.slices]).tobytes(), name

    structure, damper = Structure(1.605, 1.5, 0.0038), Damper(0.2, 0.1605, 0.0025)
    motion = builtin_record("northridge-360")
    alone = ground_response(structure, damper, motion, 3.0)
    at = (1, 0, 0, 1, 0, 0, 1, 1)
    for name, value in alone.values().items():
        assert whole[name][at] == value, name
    draw = draw_of(suite, suite.records[1], [1.5, 0.0038, 3.0, 0.47, 0.1605, 0.0025, 0.2])
    over = spread(structure, damper, motion, alone, 3.0, starts=2, seed=draw)
    assert whole["growth"][at] == over["growth"]
    assert (
        whole["peak_relative_displacement_highest_m"][at] == over["peak_relative_displacement_m"]["highest"]
    )
    assert whole["energy_residual"].max() < 1e-9
    other = solved(suite_of(seed=1), Block.whole(suite.shape))
    np.testing.assert_array_equal(other["impacts"], whole["impacts"])
    assert (other["growth"] != whole["growth"]).any()


def test_known_points_are_left_out() -> None:
    suite = suite_of(starts=0)
    known = np.zeros(suite.shape, bool)
    known[0] = True
    block = Block.whole(suite.shape)
    values = solve_suite_block(suite, block, lambda source: suite.motions[source.id], known)
    assert (values["status"][0] == Status.NOT_COMPUTED).all()
    assert (values["status"][1] == Status.CONVERGED).all()


@pytest.mark.night
def test_a_contact_time_is_the_particles_stay_on_the_wall() -> None:
    """As it goes to zero, dwelling becomes the rebound at once; the structure's frequency is its unit."""
    axes = {"natural_frequency_hz": [1.5, 2.5], "clearance_m": 0.001, "scale": 3}
    instant, brief, long = (
        solved(suite_of(axes=axes, starts=0, contact=contact), Block.whole((2, 2, *(1,) * 6)))
        for contact in (
            {"model": "instant"},
            {"model": "dwell", "contact_time": 1e-9},
            {"model": "dwell", "contact_time": 0.3},
        )
    )
    peak = "peak_relative_displacement_m"
    # the response is shaken by every stay, so two peaks part by the stay times the number of impacts, some thousands
    np.testing.assert_allclose(brief[peak], instant[peak], rtol=1e-5)
    assert (np.abs(long[peak] / instant[peak] - 1.0) > 1e-5).all()
    assert long["energy_residual"].max() < 1e-9
    damper = Damper(0.409, 0.1605, 0.001, 0.47, DwellContact(model="dwell", contact_time=0.3))
    alone = ground_response(Structure(1.605, 1.5), damper, builtin_record("northridge-090"), 3.0)
    suite = suite_of(axes=axes)
    force = float(suite.coordinates["friction_force_n"][0])
    assert force == damper.friction_force_n
    assert long[peak][0, 0].item() == alone.peak_relative_displacement_m


def test_a_suite_goes_on_from_half_without_the_folder_of_records(tmp_path: Path) -> None:
    """Half of the blocks are there when the uploaded record is lost: the study keeps a copy of its own."""
    shelf = Shelf(tmp_path / "data")
    record_id, _ = shelf.put(SHAKE)
    suite = parse_study({**ASKED, "records": [record_id, "northridge"], "starts": 0}, shelf)
    assert isinstance(suite, Suite)
    store = Store.open(tmp_path / "data")
    plan = plan_with_chunk(suite, (1, 1, 1, 2, 1, 1, 3, 2), seconds_per_point)
    record, _ = store.submit(suite, plan, provenance())
    for index in range(2):
        outcome = run_block(
            store.cube_path(record.id), suite.digest, plan.block(index), code_hash(), f"g{index}"
        )
        store.mark(record.id, outcome)
    shutil.rmtree(shelf.folder)
    wider = parse_study(
        {**ASKED, "axes": {**ASKED["axes"], "scale": [1, 2, 3]}, "records": ["northridge"], "starts": 0}
    )
    record = run_here(store, record.id)
    # what another suite has of it is taken over: the same record, and two of three scales
    second, _ = store.submit(wider, plan_with_chunk(wider, wider.shape, seconds_per_point), provenance())
    second = run_here(store, second.id)
    assert (second.state, second.points_reused, second.points_done) == ("done", 24, 36)
    taken = store.cube(second.id)
    afresh = solve_suite_block(wider, Block.whole(wider.shape), lambda source: wider.motions[source.id])
    for name, values in afresh.items():
        assert taken[name].values.tobytes() == values.tobytes(), name
    assert (record.state, record.points_done, record.points_failed) == ("done", 48, 0)
    cube = store.cube(record.id)
    whole = solved(suite, Block.whole(suite.shape))
    for name, values in whole.items():
        assert cube[name].values.tobytes() == values.tobytes(), name

    # a backup holds the copy of the record too; where the copy is lost, that is seen, and mended from the record
    other = Store.open(tmp_path / "other")
    copy_store(store, other)
    assert list(verify(other, other.find(record.id))) == []
    copied, _ = other.snapshot(record.id)
    copied.remove(next(source.key for source in suite.records if source.id == record_id))
    found = list(verify(other, other.find(record.id)))
    assert [damage.block for damage in found] == [None]
    assert record_id in found[0].found
    Shelf(tmp_path / "other").put(SHAKE)
    repair(other, other.find(record.id), found)
    assert list(verify(other, other.find(record.id))) == []
    other.close()
    store.close()


def test_spread_is_small_without_a_particle_and_large_in_chaos() -> None:
    motion = builtin_record("el-centro-180")
    structure = Structure()
    still, rattling = Damper(0.41), Damper(0.0, 0.1605, 0.0075)
    calm = spread(structure, still, motion, ground_response(structure, still, motion), starts=4)
    wild = spread(structure, rattling, motion, ground_response(structure, rattling, motion), starts=4)
    # friction contracts: no two of its motions part (the equation is monotone)
    assert calm["growth"] <= 1.0 + 1e-6
    assert not calm["sensitive"]
    assert wild["growth"] > CHAOTIC
    peak = wild["peak_relative_displacement_m"]
    assert peak["lowest"] <= peak["mean"] <= peak["highest"]
    again = spread(structure, rattling, motion, ground_response(structure, rattling, motion), starts=4)
    assert again == wild
