"""The catalogue: one record per study, counted done-marks, claims, phases, pages, deletion."""

import hashlib
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from tests.filling import enter, entered, make_plan_of, make_study, outcome_of, write_behind

from damperlab.studies.store.catalogue.catalogue import REVISION
from damperlab.studies.store.catalogue.tables import metadata
from damperlab.studies.store.cube.description import describe_cube
from damperlab.studies.store.faults import RevisionGone, StoreFault, StudyBusy, StudyNotFound
from damperlab.studies.store.life_cycle.lookup import Wanted
from damperlab.studies.store.store import Store


def test_a_submitted_study_is_found_by_id_prefix_and_name(store):
    study = make_study("my map")
    record, created = store.submit(study, make_plan_of(study), {"solver_version": "7"})
    assert created
    assert record.id == study.digest[:12]
    assert record.state == "queued"
    assert record.points_total == 5 * 3 * 4
    assert record.blocks_total == 3 * 2 * 2
    assert record.definition == study.document()
    assert record.provenance == {"solver_version": "7"}
    for ref in (record.id, record.id[:4], "my map"):
        assert store.find(ref) == record
    told = f'at least 4 digits of an id are needed; "{record.id[:3]}" fits {record.id} \\(my map\\)'
    with pytest.raises(StudyNotFound, match=told):
        store.find(record.id[:3])


def test_marks_are_counted_once_and_leave_the_rest_pending(store):
    _, plan, study_id = entered(store)
    store.mark(study_id, outcome_of(plan.block(3)))
    store.mark(study_id, outcome_of(plan.block(3), failed=1, message="a late twin"))
    store.mark(study_id, outcome_of(plan.block(11), failed=1, message="lost"))
    record = store.find(study_id)
    assert record.blocks_done == 2
    assert record.points_done == plan.block(3).points + plan.block(11).points
    assert record.points_failed == 1
    assert record.message == "block 11: lost"
    assert record.seconds == pytest.approx(1.0)
    np.testing.assert_array_equal(store.pending(study_id), [0, 1, 2, 4, 5, 6, 7, 8, 9, 10])
    bigger = make_plan_of(make_study(), (1, 1, 1, 1, 1, 1))
    with pytest.raises(ValueError, match="block 59 of 12"):
        store.mark(study_id, outcome_of(bigger.block(59)))


def test_states_keep_the_times_of_the_run(store):
    _, plan, study_id = entered(store)
    queued = store.find(study_id)
    assert queued.started is None
    assert queued.seconds_left is None
    running = store.set_state(study_id, "running")
    assert running.started >= running.created
    assert running.seconds_left is None  # no block yet, no pace
    store.mark(study_id, outcome_of(plan.block(0)))
    assert store.find(study_id).seconds_left >= 0
    cancelled = store.set_state(study_id, "cancelled", "by hand")
    assert cancelled.finished >= running.started
    assert cancelled.message == "by hand"
    again = store.set_state(study_id, "running", "")
    assert (again.started, again.finished, again.message) == (running.started, None, None)
    for index in range(1, plan.count):
        store.mark(study_id, outcome_of(plan.block(index)))
    done = store.set_state(study_id, "done")
    assert done.points_done == done.points_total
    assert done.seconds_left == 0


def test_a_state_changes_only_from_the_states_that_were_named(store):
    *_, study_id = entered(store)
    store.set_state(study_id, "done")
    assert store.set_state(study_id, "cancelled", only_from=("queued", "running")).state == "done"
    with pytest.raises(ValueError, match="paused"):
        store.set_state(study_id, "paused")


def test_one_owner_at_a_time_holds_a_claim(store):
    *_, study_id = entered(store)
    assert store.claim(study_id, "a")
    assert store.claim(study_id, "a")
    assert not store.claim(study_id, "b")
    assert not store.renew(study_id, "b")
    store.release(study_id, "b")
    assert store.find(study_id).owner == "a"
    store.release(study_id, "a")
    assert store.find(study_id).owner is None
    assert store.claim(study_id, "b")


def test_pages_go_from_new_to_old_and_do_not_shift(store):
    for number in range(5):
        study = make_study(f"Sweep {number}", damping_ratio=0.01 + number / 100)
        enter(store, study)
    store.set_state(store.find("Sweep 1").id, "done")
    first = store.page(limit=2)
    assert [record.name for record in first.records] == ["Sweep 4", "Sweep 3"]
    late = make_study("late", damping_ratio=0.5)
    enter(store, late)
    second = store.page(limit=2, cursor=first.cursor)
    third = store.page(limit=2, cursor=second.cursor)
    assert [record.name for record in (*second.records, *third.records)] == ["Sweep 2", "Sweep 1", "Sweep 0"]
    assert third.cursor is None
    assert [record.name for record in store.page(wanted=Wanted(state="done")).records] == ["Sweep 1"]
    assert len(store.page(wanted=Wanted(name="sweep")).records) == 5
    assert store.page(wanted=Wanted(name="%")).records == ()


@pytest.mark.parametrize(
    ("asked", "field"),
    [
        ({"cursor": "nonsense"}, "cursor"),
        ({"cursor": "\ud800"}, "cursor"),
        ({"limit": 0}, "limit"),
        ({"limit": 10**6}, "limit"),
    ],
)
def test_a_page_that_cannot_be_is_refused(store, asked, field):
    with pytest.raises(StoreFault) as caught:
        store.page(**asked)
    assert caught.value.fault.field == field


@pytest.mark.parametrize("ref", ["", "nope", "ffffffffffff", "%", "\ud800", "a\x00b", "x" * 10_000])
def test_an_unknown_study_is_told_with_those_that_are_known(store, ref):
    record = enter(store, make_study("known one"))
    with pytest.raises(StudyNotFound, match=f"{record.id} \\(known one\\)"):
        store.find(ref)


def test_a_prefix_of_several_ids_is_refused_with_them(store):
    # of seventeen ids, two start with the same of sixteen digits
    studies = [make_study(damping_ratio=0.01 + number / 100) for number in range(17)]
    starts = [study.digest[0] for study in studies]
    shared = max(starts, key=starts.count)
    for study in studies:
        if study.digest[0] == shared:
            enter(store, study)
    with pytest.raises(StudyNotFound, match="more digits"):
        store.find(shared)


def test_a_name_that_is_the_start_of_another_studys_id_is_a_name(store):
    other = enter(store, make_study("other"))
    for number, digits in enumerate((2, 5, 11), 1):
        study = make_study(other.id[:digits], damping_ratio=0.01 * number)
        named = enter(store, study)
        assert store.find(other.id[:digits]) == named
        assert store.find(other.id) == other
    study = make_study(other.id, damping_ratio=0.05)
    enter(store, study)
    assert store.find(other.id) == other  # a whole id is what it says, whatever others are called


def test_a_deleted_study_is_gone_with_its_files_and_can_come_back(store):
    _, plan, study_id = entered(store)
    store.mark(study_id, outcome_of(plan.block(0)))
    folder = Path(store.cube_path(study_id))
    assert folder.exists()
    store.delete(study_id)
    with pytest.raises(StudyNotFound, match=r"deleted 20.* no studies yet"):
        store.find(study_id)
    store.bury()
    assert not folder.exists()
    with pytest.raises(StudyNotFound):
        store.mark(study_id, outcome_of(plan.block(1)))
    record, created = store.submit(make_study(), plan, {})
    assert created
    assert record.blocks_done == 0
    assert Path(store.cube_path(study_id)) != folder


@pytest.mark.parametrize("ended", ["cancelled", "done", "failed"])
def test_a_study_that_is_worked_on_is_not_deleted_unless_it_has_ended(store, ended):
    *_, study_id = entered(store)
    store.claim(study_id, "runner 7")
    store.set_state(study_id, "running")
    with pytest.raises(StudyBusy, match=r"runner 7.*cancel"):
        store.delete(study_id)
    assert Path(store.cube_path(study_id)).exists()
    store.set_state(study_id, ended)
    store.delete(study_id)  # although its runner has not let go yet
    assert store.page().records == ()
    store.release(study_id, "runner 7")


def test_a_delete_that_was_cut_short_is_finished_later(store):
    *_, study_id = entered(store)
    folder = Path(store.cube_path(study_id))
    write_behind(store.data_dir, "UPDATE studies SET deleted = 1.0, crc = NULL")
    assert folder.exists()
    again = Store.open(store.data_dir)
    again.bury()
    assert not folder.exists()
    with again.catalogue.reading() as opened:
        left = opened.exec_driver_sql("SELECT definition FROM studies").scalars().all()
        assert left == [""]  # the row keeps the number alone
    again.close()


def test_a_revision_of_a_deleted_study_is_not_found_in_the_next_of_its_name(store):
    study, plan = make_study(), make_plan_of(make_study())
    first = store.submit(study, plan, {})[0]
    store.mark(first.id, *(outcome_of(plan.block(index)) for index in range(3)))
    last = store.find(first.id).revision
    store.delete(first.id)
    again = store.submit(study, plan, {})[0]
    assert (again.id, again.blocks_done) == (first.id, 0)
    store.mark(first.id, *(outcome_of(plan.block(index)) for index in range(5)))
    for revision in range(last + 1):
        with pytest.raises(RevisionGone):
            store.snapshot(first.id, revision)
    assert store.snapshot(first.id, again.revision)[1] == {}
    assert len(store.snapshot(first.id, again.revision + 4)[1]) == 4


def test_commits_reach_the_disk(store):
    with store.catalogue.reading() as connection:
        pragma = {
            name: connection.exec_driver_sql(f"PRAGMA {name}").scalar_one()
            for name in ("journal_mode", "synchronous", "foreign_keys", "busy_timeout")
        }
    assert pragma == {"journal_mode": "wal", "synchronous": 2, "foreign_keys": 1, "busy_timeout": 60_000}


def test_a_catalogue_of_a_newer_version_is_left_alone(tmp_path):
    Store.open(tmp_path).close()
    write_behind(tmp_path, "UPDATE facts SET value = '9999' WHERE key = 'revision'")
    with pytest.raises(StoreFault, match=r"revision 9999.*Upgrade"):
        Store.open(tmp_path)


def test_other_tables_have_another_revision():
    told = [
        f"{column} {column.type} {column.nullable}" for table in metadata.sorted_tables for column in table.c
    ]
    digest = hashlib.sha256("\n".join(told).encode()).hexdigest()[:8]
    # catalogues of this revision may also have a table of idempotency keys, which is not read
    assert (REVISION, digest) == (2, "03489f54")


def test_a_catalogue_of_0_1_0_is_left_alone(tmp_path):
    """It kept its version where SQLite keeps such a number."""
    write_behind(tmp_path, "CREATE TABLE studies (id TEXT)", "PRAGMA user_version = 1")
    before = (tmp_path / "catalogue.sqlite").read_bytes()
    with pytest.raises(StoreFault, match=r"older than 0\.2\.0.*damperlab export"):
        Store.open(tmp_path)
    assert (tmp_path / "catalogue.sqlite").read_bytes() == before
    # of its cubes: Zarr groups without a seal and without the codec of blocks
    with pytest.raises(ValueError, match=r"damperlab 0\.1\.0; export it"):
        describe_cube(b'{"zarr_format": 3, "node_type": "group", "attributes": {}}')


def test_a_file_that_is_no_catalogue_and_a_folder_that_cannot_be_made_are_told(tmp_path):
    (tmp_path / "catalogue.sqlite").write_bytes(b"no database at all, but long enough to look at" * 40)
    with pytest.raises(StoreFault, match=r"not a database.*damperlab store rebuild"):
        Store.open(tmp_path)
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(StoreFault, match="--data-dir"):
        Store.open(tmp_path / "file" / "data")


def test_marks_are_kept_while_threads_look_at_many_studies(store, monkeypatch):
    monkeypatch.setattr("damperlab.studies.store.cubes._MARKS_KEPT", 2)
    ids = []
    for number in range(8):
        study = make_study(f"study {number}", damping_ratio=0.01 * (1 + number))
        ids.append(enter(store, study).id)
    before = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    try:
        with ThreadPoolExecutor(8) as threads:
            found = list(threads.map(lambda turn: store.snapshot(ids[turn % 8])[1], range(200)))
    finally:
        sys.setswitchinterval(before)
    assert found == [{}] * 200


def _phase(store: Store, study_id: str) -> tuple[str, int | None, int | None]:
    record = store.find(study_id)
    return record.phase, record.phase_done, record.phase_total


def test_a_phase_is_the_state_but_for_what_its_owner_says_before_the_blocks(store: Store) -> None:
    *_, study_id = entered(store)
    assert _phase(store, study_id) == ("queued", None, None)
    assert store.claim(study_id, "one")
    store.set_phase(study_id, "starting", owner="one")
    assert _phase(store, study_id) == ("queued", None, None), "a phase is of a study that runs"
    store.set_state(study_id, "running", owner="one")
    assert _phase(store, study_id) == ("running", None, None)
    store.set_phase(study_id, "starting", owner="one")
    assert _phase(store, study_id) == ("starting", None, None)
    store.set_phase(study_id, "compiling", 0, 2, owner="two")
    assert _phase(store, study_id) == ("starting", None, None)
    store.set_phase(study_id, "compiling", 1, 3, owner="one")
    assert _phase(store, study_id) == ("compiling", 1, 3)
    for state in ("cancelled", "queued", "running", "done"):
        store.set_state(study_id, state, owner="one")
        assert _phase(store, study_id) == (state, None, None)


def test_the_pace_of_a_study_leaves_its_preparation_out(store: Store) -> None:
    _, plan, study_id = entered(store)
    assert store.claim(study_id, "one")
    store.set_state(study_id, "running", owner="one")
    with store.catalogue.writing() as connection:
        # as if compiling had taken an hour
        connection.exec_driver_sql("UPDATE studies SET run_began = run_began - 3600")
    store.set_phase(study_id, None, owner="one")
    store.mark(study_id, outcome_of(plan.block(0)))
    left = store.find(study_id).seconds_left
    assert left < 3600
