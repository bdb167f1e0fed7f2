"""The catalogue made again from the cubes, from a folder and from a bucket: the same studies, the same bits; no damaged key."""

import os
import shutil
import sqlite3
from contextlib import closing, suppress
from pathlib import Path
from types import SimpleNamespace

import pytest
from tests.filling import (
    enter,
    flip,
    lose_catalogue,
    make_plan_of,
    make_study,
    values_of,
    write,
    write_behind,
)

from damperlab.studies.remarks import Remarks
from damperlab.studies.store.care.rebuild import rebuild
from damperlab.studies.store.care.sweep import collect_garbage
from damperlab.studies.store.care.verify import check_catalogue, unfinished_submissions, verify
from damperlab.studies.store.catalogue.access_keys import AccessKeys
from damperlab.studies.store.cube.block_file import write_region
from damperlab.studies.store.faults import StoreFault, StudyNotFound
from damperlab.studies.store.life_cycle.manifest import lost_end, read_marks
from damperlab.studies.store.store import Store

METRICS = ["amplitude_ratio", "period"]
VOLATILE = {"revision"}


PROVENANCE = {"kernels": "k", "solver_version": "1"}


def begun(store: Store, study, blocks, generation: str = "g") -> str:
    """Submit a study, and do some blocks of it that tell what they took."""
    record, told = enter(store, study, **PROVENANCE), {"seconds": 0.5, "kernel_seconds": 0.4}
    for block in map(make_plan_of(study).block, blocks):
        write(store, record.id, block, values_of(study, block), generation, told)
    return record.id


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Studies that are done, cancelled half-way, queued, and running with blocks that only their files tell of."""
    store = Store.open(tmp_path_factory.mktemp("made") / "data")
    states = (("done", 12), ("cancelled", 5), (None, 0), ("running", 4))
    for number, (state, blocks) in enumerate(states):
        study = make_study(f"study {number}", damping_ratio=0.01 * (1 + number), metrics=METRICS)
        study_id = begun(store, study, range(blocks))
        if number == 0:  # said before it ends
            store.remark(study_id, Remarks(("rig-2", "steel"), "first"))
        if state is not None:
            store.set_state(study_id, state, "stopped" if state == "cancelled" else None)
        if state == "cancelled":  # and after it has ended
            store.remark(study_id, Remarks(("paused",), "why"))
    store.close()
    return store.data_dir


def told(store: Store) -> dict:
    found = {}
    for record in store.page().records:
        document = record.document()
        if document["state"] == "running":
            document |= {"state": "queued", "phase": "queued", "started": None, "seconds_left": None}
        found[record.id] = {key: value for key, value in document.items() if key not in VOLATILE}
    return found


def test_a_lost_catalogue_is_made_again(copied):
    data = copied.data_dir
    before, cubes = told(copied), {r.id: copied.cube(r.id).load() for r in copied.page().records}
    copied.close()
    lose_catalogue(data)
    there = sorted(data.rglob("*"))
    with pytest.raises(
        StoreFault, match=r"without their catalogue.*DAMPERLAB_CATALOGUE.*damperlab store rebuild"
    ):
        Store.open(data)
    assert sorted(data.rglob("*")) == there
    found = rebuild(data)
    assert (found.studies, found.blocks, found.trouble) == (4, 21, [])
    again = Store.open(data)
    assert told(again) == before
    for study_id, cube in cubes.items():
        assert again.cube(study_id).load().identical(cube)
        assert list(verify(again, again.find(study_id))) == []
    again.close()
    once_more = rebuild(data)
    assert (once_more.studies, once_more.blocks, once_more.known) == (0, 0, 4)


def test_a_study_whose_last_block_was_done_but_not_its_end_is_done_and_sound(store):
    never_ended = begun(store, make_study("never ended", metrics=METRICS), range(12))
    study = make_study("cancelled", damping_ratio=0.02, metrics=METRICS)
    cancelled = begun(store, study, range(11))
    store.set_state(cancelled, "cancelled")
    late = make_plan_of(study).block(11)
    write_region(store.cube_path(cancelled), late, values_of(study, late), "late")
    store.close()
    lose_catalogue(store.data_dir)
    rebuild(store.data_dir)
    again = Store.open(store.data_dir)
    for study_id in (never_ended, cancelled):
        assert again.find(study_id).state == "done"
        assert list(verify(again, again.find(study_id))) == []
    again.keep_late_marks()
    for study_id in (never_ended, cancelled):
        kept, marks = read_marks(again.find_cube(study_id))
        assert (kept["state"], len(marks)) == ("done", 12)
        assert list(verify(again, again.find(study_id))) == []
    again.close()


def test_what_the_tail_of_the_log_held_is_missed_and_restored(store, tmp_path):
    """As a machine leaves it that loses its power, and a disk that loses what was written last."""
    first = make_study("first", damping_ratio=0.01, metrics=METRICS)
    second = make_study("second", damping_ratio=0.02, metrics=METRICS)
    gone = make_study("gone", damping_ratio=0.03, metrics=METRICS)
    study_id = begun(store, first, range(12))
    half = begun(store, second, range(5))
    deleted = begun(store, gone, ())
    store.set_state(deleted, "cancelled")
    log = store.data_dir / "catalogue.sqlite-wal"
    ends = log.stat().st_size
    store.set_state(study_id, "done")
    store.set_state(half, "cancelled", "stopped")
    store.delete(deleted)
    queued = [
        enter(store, study, **PROVENANCE).id
        for number in range(25)
        for study in [make_study(f"queued {number}", damping_ratio=0.1 + number / 1000, metrics=METRICS)]
    ]
    before = told(store)
    for kind in ("cut", "zeroed"):
        data = tmp_path / kind
        shutil.copytree(store.data_dir, data)
        content = log.read_bytes()
        zeros = bytes(len(content) - ends) if kind == "zeroed" else b""
        (data / log.name).write_bytes(content[:ends] + zeros)
        again = Store.open(data)
        said = list(check_catalogue(again))
        for each in (study_id, half, deleted, *queued):
            assert any(each in line and "damperlab store rebuild" in line for line in said), each
        again.close()
        found = rebuild(data)
        assert (found.studies, found.restored, found.deleted, found.trouble) == (25, 2, 1, [])
        again = Store.open(data)
        assert told(again) == before
        assert list(check_catalogue(again)) == []
        for record in again.page(limit=100).records:
            assert list(verify(again, record)) == []
        again.close()


def test_a_study_whose_entry_is_lost_after_its_number_was_reserved_is_missed_and_restored(
    store, tmp_path, monkeypatch
):
    log, ends, make = store.data_dir / "catalogue.sqlite-wal", [], store._make

    def noted(fresh):
        make(fresh)
        ends.append(log.stat().st_size)

    monkeypatch.setattr(store, "_make", noted)
    study = make_study("entered", metrics=METRICS)
    entered = enter(store, study, **PROVENANCE).id
    before = told(store)
    data = tmp_path / "cut"
    shutil.copytree(store.data_dir, data)
    (data / log.name).write_bytes(log.read_bytes()[: ends[0]])
    with closing(Store.open(data)) as again:
        assert list(check_catalogue(again)) == []  # an interrupted submission leaves the same
        (line,) = unfinished_submissions(again)
        assert entered in line
    assert (rebuild(data).studies, rebuild(data).known) == (1, 1)
    with closing(Store.open(data)) as again:
        assert told(again) == before
        assert list(check_catalogue(again)) == []


def test_a_submission_under_way_or_cut_short_is_no_damage(store, monkeypatch):
    make = store._make

    def killed(fresh):
        make(fresh)
        raise KeyboardInterrupt

    monkeypatch.setattr(store, "_make", killed)
    monkeypatch.setattr(store, "_discard", lambda several: None)  # a killed process removes nothing
    with pytest.raises(KeyboardInterrupt):
        enter(store, make_study("cut short", metrics=METRICS))
    assert list(check_catalogue(store)) == []
    (line,) = unfinished_submissions(store)
    (name,) = store.shelf.shelves()
    assert name in line
    # a cube with results is no interrupted submission: the catalogue has lost its study
    store.shelf.at(name).put("blocks/0~attempt", b"block")
    (line,) = check_catalogue(store)
    assert name in line
    assert unfinished_submissions(store) == []


def test_an_end_that_a_killed_run_never_reached_is_not_lost():
    kept = {"state": "cancelled", "finished": 100.0}
    row = {"finished": None, "run_began": 150.0}
    assert not lost_end(kept, SimpleNamespace(**row), 50.0)
    assert lost_end(kept, SimpleNamespace(**row | {"run_began": 40.0}), 50.0)


def test_a_study_that_was_resumed_since_its_end_is_left_as_it_is(copied):
    (half,) = (each for each in copied.page().records if each.state == "cancelled")
    copied.set_state(half.id, "queued")
    assert list(check_catalogue(copied)) == []
    assert rebuild(copied.data_dir).restored == 0
    assert copied.find(half.id).state == "queued"


def test_an_older_copy_gets_what_it_lacks(copied):
    data = copied.data_dir
    copied.close()
    older = sqlite3.connect(data / "catalogue.sqlite")
    copy = sqlite3.connect(data / "older")
    older.backup(copy)
    copy.close()
    older.close()
    store = Store.open(data)
    study = make_study("new", damping_ratio=0.3, metrics=METRICS)
    begun(store, study, range(3))
    first = make_study("study 1", damping_ratio=0.02, metrics=METRICS)
    begun(store, first, range(5, 9))
    before = {key: value["blocks_done"] for key, value in told(store).items()}
    store.close()
    (data / "older").replace(data / "catalogue.sqlite")
    with pytest.raises(StoreFault, match="older copy"):
        Store.open(data)
    found = rebuild(data)
    assert (found.studies, found.blocks) == (1, 7)
    again = Store.open(data)
    assert {key: value["blocks_done"] for key, value in told(again).items()} == before
    again.close()


def test_a_removal_that_was_cut_short_anywhere_brings_nothing_back(copied, tmp_path, monkeypatch):
    gone = copied.find("study 0").id
    copied.delete(gone)
    before = told(copied)
    copied.close()
    unlink, left = os.unlink, [0]

    def killed_after_some(*arguments, **more):
        if left[0] == 0:
            raise KeyboardInterrupt
        left[0] -= 1
        return unlink(*arguments, **more)

    number = sum(
        1 for file in next((copied.data_dir / "cubes").glob(f"{gone}-*")).rglob("*") if file.is_file()
    )
    for removed in {0, 1, number // 2, number - 1, number}:
        data = tmp_path / f"after {removed}"
        shutil.copytree(copied.data_dir, data)
        store = Store.open(data)
        cube = next((data / "cubes").glob(f"{gone}-*"))
        left[0] = removed
        with monkeypatch.context() as patched, suppress(KeyboardInterrupt):
            patched.setattr(os, "unlink", killed_after_some)
            store.bury()
        assert sum(1 for file in cube.rglob("*") if file.is_file()) == number - removed
        store.close()
        lose_catalogue(data)
        for _ in range(2):
            assert rebuild(data).trouble == []
            again = Store.open(data)
            assert told(again) == before
            again.close()
        again = Store.open(data)
        with pytest.raises(StudyNotFound):
            again.find(gone)
        again.bury()
        again.close()
        assert not cube.exists()


def test_a_study_submitted_again_after_its_deletion_is_the_one_that_comes_back(copied):
    data = copied.data_dir
    copied.delete(copied.find("study 0").id)
    study = make_study("study 0", damping_ratio=0.01, metrics=METRICS)
    begun(copied, study, range(3))
    before = told(copied)
    copied.close()
    lose_catalogue(data)
    found = rebuild(data)
    assert (found.studies, found.deleted, found.trouble) == (4, 1, [])
    again = Store.open(data)
    assert told(again) == before
    again.bury()
    assert again.cube(again.find("study 0").id)["status"].load().sizes
    again.close()


def test_a_cube_that_cannot_be_read_is_told_and_costs_no_other(copied):
    data = copied.data_dir
    lost = copied.find("study 1").id
    description = Path(copied.cube_path(lost), "zarr.json")
    copied.close()
    flip(description)
    damaged = description.read_bytes()
    lose_catalogue(data)
    found = rebuild(data)
    assert found.studies == 3
    (trouble,) = found.trouble
    assert lost in trouble
    assert description.read_bytes() == damaged


@pytest.mark.parametrize(
    "damage",
    [
        "UPDATE studies SET name = 'x' || name WHERE number = 1",
        "UPDATE studies SET deleted = 1.0 WHERE number = 1",
        "UPDATE studies SET id = 'x' || substr(id, 2) WHERE number = 1",
        "UPDATE done_blocks SET checksum = '0' WHERE study = 1 AND block = 3",
        "UPDATE events SET what = 'x' || what WHERE number = 1",
        "UPDATE done_blocks SET block = 'x' WHERE study = 1 AND block = 3",
        "UPDATE done_blocks SET points = 'x' WHERE study = 1 AND block = 3",
        "UPDATE studies SET created = 'x' WHERE number = 1",
        "UPDATE events SET at = 'x' WHERE number = 1",
        "UPDATE events SET what = CAST(x'ff41' AS TEXT) WHERE number = 1",
        "UPDATE studies SET name = CAST(x'ff41' AS TEXT) WHERE number = 1",
        "UPDATE done_blocks SET generation = CAST(x'ff41' AS TEXT) WHERE study = 1 AND block = 3",
        "UPDATE facts SET value = '' WHERE key = 'revision'",
        "ALTER TABLE studies RENAME COLUMN note TO nota",
        "ALTER TABLE events RENAME TO evens",
        "DELETE FROM facts WHERE key = 'revision'",
    ],
)
def test_rows_that_are_damaged_are_told_and_made_anew(copied, damage):
    data, before = copied.data_dir, told(copied)
    copied.close()
    write_behind(data, damage)
    with suppress(StoreFault):  # where it can be opened, the damage is told and costs no file
        again = Store.open(data)
        try:
            assert any("damperlab store rebuild" in line for line in check_catalogue(again))
            assert collect_garbage(again, -1.0).paths == 0
        finally:
            again.close()
    rebuild(data)
    again = Store.open(data)
    assert list(check_catalogue(again)) == []
    assert told(again) == before
    for record in again.page().records:
        assert list(verify(again, record)) == []
    again.close()


def test_an_attempt_of_another_solver_is_no_block_of_the_cube(store):
    study = make_study(metrics=METRICS)
    plan, block = make_plan_of(study), make_plan_of(study).block(0)
    record, _ = store.submit(study, plan, {"identity": "ours", "solver_version": "1"})
    path = store.cube_path(record.id)
    # the stranger's file comes first by its name, and of block 1 there is no other
    write_region(path, block, values_of(study, block), "a", {"identity": "theirs"})
    write_region(path, block, values_of(study, block), "b", {"identity": "ours"})
    write_region(path, plan.block(1), values_of(study, plan.block(1)), "a", {"identity": "theirs"})
    data = store.data_dir
    store.close()
    lose_catalogue(data)
    assert rebuild(data).blocks == 1
    again = Store.open(data)
    assert again.snapshot(record.id)[1] == {0: "b"}
    again.close()


def test_another_catalogue_with_studies_is_not_taken_over(copied, tmp_path):
    other = Store.open(tmp_path / "other")
    other.submit(
        make_study("other", damping_ratio=0.5), make_plan_of(make_study("other", damping_ratio=0.5)), {}
    )
    other.close()
    copied.close()
    (tmp_path / "other" / "catalogue.sqlite").replace(copied.data_dir / "catalogue.sqlite")
    with pytest.raises(StoreFault, match="whose cubes are not those"):
        rebuild(copied.data_dir)


@pytest.mark.parametrize(
    "damage",
    [
        "owner = 'bob'",
        "scopes = 'read,submit,admin'",
        "expires = 1e300",
        "revoked = NULL",
        "hash = hash || '0'",
    ],
)
def test_a_key_whose_row_is_damaged_opens_nothing(store, damage):
    keys = AccessKeys(store.catalogue)
    good, secret = keys.create("alice", ("read",), lasts_seconds=3600.0)
    bad, damaged = keys.create("rob", ("read",), lasts_seconds=60.0)
    if damage.startswith("revoked"):
        bad = keys.revoke(bad.id)
    write_behind(store.data_dir, f"UPDATE access_keys SET {damage} WHERE id = '{bad.id}'")
    assert keys.recognise(damaged) is None
    assert keys.recognise(secret) == good
    assert {key.id: (key.sound, key.valid) for key in keys.all()} == {
        good.id: (True, True),
        bad.id: (False, False),
    }
    for key in keys.all():
        assert key.document()["valid"] == (key.id == good.id)
    (told,) = check_catalogue(store)
    assert bad.id in told
    rebuild(store.data_dir)
    assert keys.all() == [good]
    assert list(check_catalogue(store)) == []
