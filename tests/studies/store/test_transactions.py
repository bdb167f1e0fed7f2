"""What writes to the catalogue waits for no disk and no object store meanwhile, and what is cut short loses nothing."""

import multiprocessing
from pathlib import Path
from typing import Any

import pytest
from tests.filling import enter, make_plan_of, make_study, values_of
from tests.studies.store.racing import die_at

from damperlab.studies.remarks import Remarks
from damperlab.studies.store.care.rebuild import rebuild
from damperlab.studies.store.care.sweep import collect_garbage
from damperlab.studies.store.care.verify import check_catalogue, verify
from damperlab.studies.store.cube.block_file import write_region
from damperlab.studies.store.store import Store


def test_no_file_is_touched_within_a_transaction(watched):
    store, study = watched, make_study()
    plan = make_plan_of(study)
    record, _ = store.submit(study, plan, {"identity": "one"})
    facts = {"identity": "two"}
    assert store.begin(record.id, facts, None).provenance["identity"] == "two"
    for index in range(plan.count):
        block = plan.block(index)
        told = {"identity": "two"}
        outcome = write_region(store.cube_path(record.id), block, values_of(study, block), "g", told)
        store.mark(record.id, outcome)
    store.set_state(record.id, "done")
    store.remark(record.id, Remarks(("rig",), "n"))
    assert list(verify(store, store.find(record.id))) == []
    again, created = store.recompute(record.id, {"identity": "three"})
    assert created
    assert again.id == f"{record.id}-2"
    store.forget(record.id, [0], "by hand")
    store.set_state(record.id, "cancelled")
    store.delete(record.id, keep_seconds=600.0)
    assert store.undelete(record.id).id == record.id
    store.delete(again.id)
    store.bury()
    collect_garbage(store, 0.0)
    assert [each.id for each in store.page().records] == [record.id]
    assert list(check_catalogue(store)) == []


def test_of_two_that_enter_one_study_at_once_one_makes_it(watched):
    store = watched
    other = Store.open(store.data_dir)
    study = make_study()
    first: list[Any] = []

    def meanwhile(name: str) -> None:
        # as another process would, just before this one's cube is made
        if name == "make" and not first:
            first.append(other.submit(study, make_plan_of(study), {}))

    store.shelf.before = meanwhile  # type: ignore[attr-defined]
    record, created = store.submit(study, make_plan_of(study), {})
    assert (first[0][1], created) == (True, False)
    assert record.id == first[0][0].id
    # nothing is left of the cube that was made for nothing
    assert [path.name for path in (store.data_dir / "cubes").glob("*.zarr")] == [
        Path(store.cube_path(record.id)).name
    ]
    assert list(verify(store, store.find(record.id))) == []
    other.close()


def test_a_cube_that_was_taken_for_garbage_before_its_study_was_entered_is_made_anew(store, monkeypatch):
    study, make, swept = make_study(), store._make, []

    def make_and_sweep(fresh: Any) -> None:
        make(fresh)
        if not swept:
            swept.append(collect_garbage(store, 0.0, orphan_seconds=0.0))

    monkeypatch.setattr(store, "_make", make_and_sweep)
    record, created = store.submit(study, make_plan_of(study), {})
    assert "never entered" in swept[0].what[0]
    assert created
    assert list(verify(store, store.find(record.id))) == []


def submit(store: Store) -> None:
    enter(store, make_study())


@pytest.mark.parametrize("where", ["_make", "_publish"])
def test_a_submission_that_is_killed_leaves_nothing_that_hinders_the_next(tmp_path: Path, where: str) -> None:
    """Before its cube is made, or before its row is."""
    process = multiprocessing.get_context("spawn").Process(target=die_at, args=(where, submit, tmp_path))
    process.start()
    process.join()
    assert process.exitcode == -9
    store = Store.open(tmp_path)
    assert store.page().records == ()
    record = enter(store, make_study())
    assert list(verify(store, record)) == []
    assert list(check_catalogue(store)) == []
    collect_garbage(store, 0.0, orphan_seconds=0.0)
    assert [path.name for path in (tmp_path / "cubes").glob("*.zarr")] == [
        Path(store.cube_path(record.id)).name
    ]
    assert collect_garbage(store, 0.0).unknown == ()
    store.close()


def test_a_study_that_a_rebuild_enters_for_a_submission_under_way_keeps_its_cube(store, monkeypatch):
    make = store._make

    def rebuilt(fresh):
        make(fresh)
        assert rebuild(store.data_dir).studies == 1

    monkeypatch.setattr(store, "_make", rebuilt)
    study = make_study()
    record = enter(store, study)
    assert Path(store.cube_path(record.id)).exists()
    assert list(verify(store, record)) == []
