"""Backups: whole, consistent while studies change, a data directory of their own, and nothing half-way."""

import shutil
import threading
from collections.abc import Callable
from functools import partial
from pathlib import Path

import pytest
from tests.filling import enter, flip, make_plan_of, make_study, put

from damperlab.studies.definition import Study
from damperlab.studies.ground.kanai_tajimi import kanai_tajimi
from damperlab.studies.ground.shelf import Shelf as Records
from damperlab.studies.store.care.backup import copy_store
from damperlab.studies.store.care.rebuild import rebuild
from damperlab.studies.store.care.sweep import collect_garbage
from damperlab.studies.store.care.verify import verify
from damperlab.studies.store.faults import StoreFault
from damperlab.studies.store.store import Store

METRICS = ["amplitude_ratio", "period"]


def study(number: int) -> Study:
    """Make one of the studies of the store by its number, or another."""
    return make_study(f"study {number}", damping_ratio=0.01 * (1 + number), metrics=METRICS)


@pytest.fixture(scope="module")
def made(tmp_path_factory) -> Path:
    """Where three studies lie: done, deleted, and begun with four of twelve blocks."""
    store = Store.open(tmp_path_factory.mktemp("made") / "data")
    for number, blocks in enumerate((12, 1, 4)):
        made = study(number)
        store.submit(made, make_plan_of(made), {"kernels": "k"})
        put(store, made, *range(blocks), generation="g")
    store.set_state(store.find("study 0").id, "done")
    store.delete(store.find("study 1").id)
    store.close()
    return store.data_dir


@pytest.fixture
def filled(copied):
    """A copy of them; the one that is begun is running with a claim."""
    running = copied.find("study 2").id
    copied.claim(running, "runner 7")
    copied.set_state(running, "running")
    Path(copied.cube_path(running), "blocks", "0~half").write_bytes(b"an attempt under way")
    return copied


def is_sound(store: Store) -> bool:
    return all(list(verify(store, record)) == [] for record in store.page().records)


def names(store: Store) -> list[str]:
    return [record.name for record in store.page().records]


def test_a_backup_of_a_backup_is_what_was_there_and_goes_on_living(filled, copy, tmp_path):
    second = Store.open(tmp_path / "second")
    assert copy_store(filled, copy) == copy_store(copy, second)
    for store in (copy, second):
        assert names(store) == ["study 2", "study 0"]
        assert is_sound(store)
        for name in names(store):
            was, now = filled.find(name), store.find(name)
            assert store.cube(now.id).load().identical(filled.cube(was.id).load())
            assert (store.events(now.id), now.provenance) == (filled.events(was.id), was.provenance)
        copied = store.find("study 2")
        assert (copied.state, copied.owner, copied.blocks_done) == ("queued", None, 4)
        assert collect_garbage(store, -1.0).paths == 0  # what is no study's did not come along
    pending = map(int, second.pending(study(2).digest[:12]))
    put(second, study(2), *pending)
    assert second.find("study 2").points_done == study(2).points
    assert second.submit(study(7), make_plan_of(study(7)), {})[1]
    second.close()


def test_a_backup_taken_while_blocks_come_and_go_is_of_one_moment(filled, tmp_path):
    running = study(2)
    filled.release(running.digest[:12], "runner 7")
    stop = threading.Event()

    def churn() -> None:
        turn = 0
        while not stop.is_set():
            turn += 1
            put(filled, running, 5, 6, 7, generation=f"turn{turn}")
            filled.forget(running.digest[:12], [5, 6, 7], "churn")

    thread = threading.Thread(target=churn)
    thread.start()
    try:
        for number in range(2):
            copy = Store.open(tmp_path / f"copy {number}")
            copy_store(filled, copy)
            assert is_sound(copy)
            for record in copy.page().records:
                assert (copy.cube(record.id)["status"] == 0).sum() == record.points_done
            copy.close()
    finally:
        stop.set()
        thread.join()


@pytest.mark.parametrize(("before", "told"), [(False, "without studies"), (True, "holds other studies")])
def test_a_store_with_studies_of_its_own_is_not_written_over(filled, copy, before, told):
    """Neither where it was no backup before, nor where it was one."""
    if before:
        copy_store(filled, copy)
    own = enter(copy, study(7))
    with pytest.raises(StoreFault, match=told):
        copy_store(filled, copy)
    assert copy.find("study 7") == own


def test_a_folder_that_a_backup_was_restored_into_is_said_to_hold_its_studies(filled, copy, tmp_path):
    copy_store(filled, copy)
    restored = Store.open(tmp_path / "restored")
    copy_store(copy, restored, for_good=True)
    with pytest.raises(StoreFault, match="holds these studies already"):
        copy_store(copy, restored, for_good=True)
    restored.close()


@pytest.mark.parametrize(
    ("file", "harm", "told"),
    [
        ("blocks/7~g", Path.unlink, "damperlab store verify"),
        ("blocks/7~g", partial(flip, at=-9), "Block 7"),
        ("clearance_ratio/c.0", partial(flip, at=0), "clearance_ratio"),
        ("clearance_ratio/c.0", Path.unlink, "description"),
    ],
)
def test_damage_is_not_backed_up_in_silence_and_leaves_no_half_backup(
    filled, copy, file: str, harm: Callable[[Path], None], told: str
):
    harm(Path(filled.cube_path(filled.find("study 0").id)) / file)
    copied = copy_store(filled, copy)
    (sentence,) = copied.damaged
    assert told in sentence
    assert (copied.studies, names(copy)) == (1, ["study 2"])
    assert is_sound(copy)


def test_a_study_that_was_damaged_since_stays_in_the_backup_as_it_was(filled, copy):
    copy_store(filled, copy)
    record = filled.find("study 0")
    before = copy.cube(record.id).load()
    Path(filled.cube_path(record.id), "zarr.json").write_bytes(b"{}")
    filled.submit(study(7), make_plan_of(study(7)), {"kernels": "k"})
    put(filled, study(7), 0, generation="g")
    copied = copy_store(filled, copy)
    assert (copied.studies, len(copied.damaged)) == (3, 1)
    assert copy.find("study 7").blocks_done == 1
    assert copy.cube(record.id).load().identical(before)
    assert is_sound(copy)


def test_a_backup_does_not_forget_what_the_store_has_lost(filled, copy):
    copy_store(filled, copy)
    lost = filled.find("study 0")
    cube = Path(filled.cube_path(lost.id))
    filled.close()
    # the catalogue is lost, and a part of the folder: what is left is a store of its own, without that study
    shutil.rmtree(cube)
    for file in filled.data_dir.glob("catalogue.sqlite*"):
        file.unlink()
    assert rebuild(filled.data_dir).studies == 1
    again = Store.open(filled.data_dir)
    with pytest.raises(StoreFault, match=rf"{cube.name}, which .* has lost"):
        copy_store(again, copy)
    assert list(verify(copy, copy.find(lost.id))) == []
    # as its advice says
    again.close()
    shutil.copytree(copy.cube_path(lost.id), cube)
    assert rebuild(filled.data_dir).studies == 1
    again = Store.open(filled.data_dir)
    assert again.cube(lost.id).load().identical(copy.cube(lost.id).load())
    assert copy_store(again, copy).studies == 2
    again.close()


def inodes(folder: Path) -> dict[str, int]:
    return {str(file): file.stat().st_ino for file in folder.rglob("*~*")}


def test_a_backup_is_taken_again_and_copies_what_is_new(filled, copy):
    first = copy_store(filled, copy)
    before = inodes(copy.data_dir)
    filled.release(study(2).digest[:12], "runner 7")
    put(filled, study(2), 9, generation="g")
    filled.delete(filled.find("study 0").id)
    second = copy_store(filled, copy)
    assert (first.blocks, second.blocks) == (16, 5)
    assert 0 < second.bytes < first.bytes / 8  # one block of sixteen
    after = inodes(copy.data_dir)
    assert {file: after[file] for file in before if file in after}.items() <= before.items()
    assert (names(copy), copy.find("study 2").blocks_done, len(after)) == (["study 2"], 5, 5)
    assert is_sound(copy)


def test_a_backup_that_was_cut_short_is_gone_on_with(filled, copy):
    """At its first time, as it was brought up to date, and where a file of it is half there."""
    lost = Path(filled.cube_path(filled.find("study 2").id), "blocks", "2~g")
    content = lost.read_bytes()
    lost.unlink()
    assert copy_store(filled, copy).damaged
    lost.write_bytes(content)
    assert copy_store(filled, copy).studies == 2
    assert is_sound(copy)
    filled.submit(study(7), make_plan_of(study(7)), {"kernels": "k"})
    put(filled, study(7), 0, generation="g")
    # as a killed copy leaves it: files that the copy's catalogue does not know yet
    name = Path(filled.cube_path(filled.find("study 7").id)).name
    shutil.copytree(filled.data_dir / "cubes" / name, copy.data_dir / "cubes" / name)
    assert copy_store(filled, copy).studies == 3
    assert copy.find("study 7").blocks_done == 1
    block = Path(copy.cube_path(copy.find("study 0").id), "blocks", "7~g")
    block.write_bytes(block.read_bytes()[:-5])
    assert copy_store(filled, copy).bytes == block.stat().st_size
    assert is_sound(copy)


def test_records_come_along_and_a_damaged_one_is_told_and_spoils_no_copy(filled, copy, tmp_path):
    record_id, _ = Records(filled.data_dir).put(kanai_tajimi(1, 2.0, rise_s=0.5, fall_s=0.5))
    restored = Store.open(tmp_path / "restored")
    assert copy_store(filled, copy).damaged == ()
    copy_store(copy, restored)
    assert record_id in Records(tmp_path / "restored").ids()
    samples = filled.data_dir / "records" / f"{record_id}.npy"
    flip(samples, -3, 4)
    (told,) = copy_store(filled, copy).damaged
    assert record_id in told
    assert list(Records(copy.data_dir).damaged()) == []
    restored.close()
