"""Results of another solver beside today's: both kept, compared, and the older one replaced when told."""

import json
from pathlib import Path

import numpy as np
import pytest
from tests.other_solver import SCALE, OtherSolver
from tests.service.cli.commands import run
from tests.worker.run_here import give_up, run_here, submit

from damperlab.studies.definition import parse_study
from damperlab.studies.store.catalogue.rows import study_row
from damperlab.studies.store.catalogue.tables import done_blocks
from damperlab.studies.store.differences import differences_of
from damperlab.studies.store.faults import NothingToDo, StudyNotFound
from damperlab.studies.store.record import BlockOutcome, Record
from damperlab.studies.store.solver import solver
from damperlab.studies.store.store import Store
from damperlab.studies.variables import Status
from damperlab.worker.provenance import computing, provenance

STUDY = parse_study(
    {
        "name": "curve",
        "damping_ratio": 0.05,
        "axes": {"friction_ratio": 0, "frequency_ratio": {"start": 0.5, "stop": 1.6, "num": 12}},
        "particle": False,
    }
)


FINER = {"friction_ratio": 0, "frequency_ratio": {"start": 0.5, "stop": 1.6, "num": 23}}


@pytest.fixture(scope="module")
def other(tmp_path_factory: pytest.TempPathFactory) -> OtherSolver:
    return OtherSolver(tmp_path_factory.mktemp("other"))


def identities(store: Store, record: Record) -> set[str]:
    """By whom the blocks of a study were computed."""
    with store.catalogue.reading() as connection:
        number = study_row(connection, record.id).number
        query = done_blocks.select().where(done_blocks.c.study == number)
        return {row.identity for row in connection.execute(query)}


@pytest.fixture
def old(store: Store, other: OtherSolver) -> Record:
    """Submitted to this solver, and computed wholly by the other one."""
    record = submit(store, STUDY, 4)
    other.run("run", record.id, "--data-dir", str(store.data_dir))
    return store.find(record.id)


def test_a_study_asked_for_again_is_the_old_one_until_it_is_recomputed_and_the_two_are_compared(
    store: Store, old: Record
) -> None:
    assert old.document()["outdated"]
    assert old.provenance["identity"] != computing()["identity"]
    # the solver is its sources and not its place: nothing else differs
    assert old.provenance["solver"] != solver()
    for name in ("target", "libc", "numpy", "numba", "llvmlite", "kernels"):
        assert old.provenance[name] == computing()[name]
    assert json.loads(store.cube(old.id).attrs["provenance"])["identity"] == old.provenance["identity"]
    assert identities(store, old) == {old.provenance["identity"]}
    # its points go into no study of today's solver
    finer = run_here(store, submit(store, parse_study({**STUDY.document(), "axes": FINER}), 4).id)
    assert (finer.state, finer.points_reused, finer.outdated) == ("done", 0, False)
    store.delete(finer.id)
    # and none of its blocks is taken back to be tried again
    with pytest.raises(NothingToDo, match=f"damperlab recompute {old.id}"):
        store.retry(old.id)
    assert store.find(old.id).blocks_done == 3
    again = submit(store, STUDY, 4)
    assert (again.id, again.outdated) == (old.id, True)
    newer, created = store.recompute(old.id, provenance())
    assert (newer.id, newer.version, newer.digest, created) == (f"{old.id}-2", 2, old.digest, True)
    assert store.recompute(old.id, provenance()) == (newer, False)
    newer = run_here(store, newer.id)
    assert (newer.state, newer.outdated, newer.points_reused) == ("done", False, 0)
    assert submit(store, STUDY, 4).id == newer.id
    assert [each.id for each in store.versions(old.id)] == [old.id, newer.id]
    # the older one is what it was, to the last bit
    ours, theirs = (store.cube(each.id)["amplitude_ratio"].values for each in (newer, old))
    np.testing.assert_array_equal(theirs, ours * SCALE)
    with pytest.raises(NothingToDo, match="same bits"):
        store.recompute(newer.id, provenance())

    # differences are counted, and the largest is placed
    found = differences_of(store, newer)
    assert (found.older, found.newer) == (old.id, newer.id)
    assert (found.points, found.compared, found.differing) == (12, 12, 12)
    assert (found.only_older, found.only_newer) == (0, 0)
    by_name = {each.variable: each for each in found.variables}
    assert "run_time" not in by_name
    assert {name for name, each in by_name.items() if each.points} == {"amplitude_ratio"}
    amplitude = by_name["amplitude_ratio"]
    one, two = theirs.ravel(), ours.ravel()
    relative = np.abs(one - two) / np.maximum(one, two)
    assert amplitude.largest_relative == relative.max()
    place = list(STUDY.coordinates["frequency_ratio"]).index(amplitude.at["frequency_ratio"])
    assert (amplitude.older, amplitude.newer) == (one[place], two[place])
    # one block that only one of them has is told apart
    store.forget(newer.id, [0], "for a test")
    assert differences_of(store, store.find(newer.id)).only_older == 4
    with pytest.raises(NothingToDo, match="no older version"):
        differences_of(store, old)


def test_no_solver_finishes_what_another_began(store: Store, other: OtherSolver) -> None:
    done = run_here(store, submit(store, STUDY, 4).id)
    taken = store.forget(done.id, [1], "to be computed again")
    assert taken.blocks_done == done.blocks_total - 1
    refused = other.run("run", done.id, "--data-dir", str(store.data_dir), allowed=(1,))
    assert f"damperlab recompute {done.id}" in json.dumps(refused)
    assert store.find(done.id).blocks_done == done.blocks_total - 1
    again = run_here(store, done.id)
    assert again.state == "done"
    assert identities(store, again) == {computing()["identity"]}


def test_the_catalogue_takes_no_block_of_another_solver(store: Store) -> None:
    record = submit(store, STUDY, 4)
    with pytest.raises(ValueError, match="0000000000000000"):
        store.mark(record.id, BlockOutcome(0, 4, 0, 0.1, 0.1, generation="g", identity="0" * 16))
    assert store.find(record.id).blocks_done == 0


@pytest.mark.night
def test_both_are_kept_until_the_older_one_is_replaced(store: Store, old: Record, other: OtherSolver) -> None:
    newer = run_here(store, store.recompute(old.id, provenance())[0].id)
    path = Path(store.cube_path(old.id))
    assert path.exists()
    # seen from the other solver it is the newer one that is outdated
    third = other.run("recompute", newer.id, "--replace", "--data-dir", str(store.data_dir))
    assert (third["id"], third["version"], third["state"], third["replaced"]) == (
        f"{old.id}-3",
        3,
        "done",
        True,
    )
    assert third["differences"]["differing"] == 12
    assert [each.version for each in store.versions(old.id)] == [1, 3]
    store.delete(old.id)
    with pytest.raises(StudyNotFound, match="deleted 20"):
        store.find(newer.id)
    # the start of the id is enough to find what took its place
    assert store.find(old.id).id == store.find(old.id[:5]).id == third["id"]
    assert path.exists()
    store.bury()
    assert not path.exists()
    assert store.find(third["id"]).points_done == 12


@pytest.mark.night
def test_the_older_one_stays_while_blocks_of_the_newer_one_have_no_answer(store: Store, old: Record) -> None:
    newer, _ = store.recompute(old.id, provenance())
    give_up(store, newer, STUDY, 1)
    assert run_here(store, newer.id).state == "done"
    command = "recompute", old.id, "--replace", "--json", "--data-dir", store.data_dir
    done = run(*command, status=1)
    assert json.loads(done.stdout)["replaced"] is False
    assert f"damperlab run {newer.id} --retry" in " ".join(done.stderr.split())
    assert store.find(old.id).points_done == 12
    run_here(store, store.retry(newer.id).id)
    assert json.loads(run(*command).stdout)["replaced"] is True
    assert [each.id for each in store.versions(newer.id)] == [newer.id]


def test_versions_of_a_study_with_uploaded_files_keep_them(tmp_path: Path) -> None:
    from damperlab.studies.ground.shelf import Shelf

    document = {"records": ["el-centro"], "axes": {"natural_frequency_hz": 1.0}, "mass_kg": 1.0}
    store = Store.open(tmp_path)
    suite = parse_study(document, Shelf(tmp_path))
    older = submit(store, suite, suite.shape, solver="0" * 16, identity="0" * 16)
    give_up(store, older, suite, 0)
    newer, _ = store.recompute(older.id, provenance())
    for key in suite.attached:
        assert store.snapshot(newer.id)[0].get(key) == store.snapshot(older.id)[0].get(key)
    store.close()


def test_blocks_that_were_given_up_are_tried_again_and_nothing_else(store: Store) -> None:
    record = submit(store, STUDY, 4)
    give_up(store, record, STUDY, 1)
    done = run_here(store, record.id)
    assert (done.state, done.points_failed) == ("done", 4)
    kept = store.snapshot(record.id)[1]
    queued = store.retry(record.id)
    assert (queued.state, queued.blocks_done, queued.points_failed, queued.message) == ("queued", 2, 0, None)
    again = run_here(store, queued.id)
    assert (again.state, again.points_failed, again.message) == ("done", 0, None)
    assert (store.cube(record.id)["status"] == Status.CONVERGED).all()
    assert {index: mark for index, mark in store.snapshot(record.id)[1].items() if index != 1} == {
        index: mark for index, mark in kept.items() if index != 1
    }
    with pytest.raises(NothingToDo, match="has no block that failed"):
        store.retry(record.id)


def test_points_that_fail_by_their_numbers_are_not_tried_again(store: Store) -> None:
    # undamped at resonance: no bounded response, whoever computes it
    study = parse_study(
        {
            **STUDY.document(),
            "damping_ratio": 0.0,
            "axes": {"friction_ratio": 0, "frequency_ratio": [0.5, 1.0]},
        }
    )
    record = run_here(store, submit(store, study, 2).id)
    assert record.points_failed == 1
    with pytest.raises(NothingToDo, match="failed numerically"):
        store.retry(record.id)
