"""Backups: whole, consistent while studies change, a data directory of their own, and nothing half-way."""

import shutil
import threading
from pathlib import Path

import pytest

from damperlab.studies.ground.kanai_tajimi import kanai_tajimi
from damperlab.studies.ground.shelf import Shelf as Records
from damperlab.studies.store.care.backup import copy_store
from damperlab.studies.store.care.rebuild import rebuild
from damperlab.studies.store.care.sweep import collect_garbage
from damperlab.studies.store.care.verify import verify
from damperlab.studies.store.cube.cube import write_region
from damperlab.studies.store.faults import StoreFault
from damperlab.studies.store.record import BlockOutcome
from damperlab.studies.store.store import Store

METRICS = ["amplitude_ratio", "period"]


def write(store: Store, study, plan, values, index: int, generation: str = "g") -> None:
    block = plan.block(index)
    study_id = study.digest[:12]
    found = write_region(store.cube_path(study_id), block, values(study, block), generation)
    store.mark(study_id, BlockOutcome(index, block.points, 0, 0.5, 0.4, None, generation, found))


@pytest.fixture
def filled(store, make_study, make_plan_of, values_of):
    """Three studies: done, deleted, and running with a claim and four of twelve blocks."""
    for number, blocks in enumerate((12, 1, 4)):
        study = make_study(f"study {number}", damping_ratio=0.01 * (1 + number), metrics=METRICS)
        plan = make_plan_of(study)
        store.submit(study, plan, {"kernels": "k"}, key=f"key {number}")
        for index in range(blocks):
            write(store, study, plan, values_of, index)
    store.set_state(store.find("study 0").id, "done")
    store.delete(store.find("study 1").id)
    running = store.find("study 2").id
    store.claim(running, "runner 7")
    store.set_state(running, "running")
    Path(store.cube_path(running), "blocks", "0~half").write_bytes(b"an attempt under way")
    return store


def test_a_backup_of_a_backup_is_what_was_there(filled, tmp_path):
    first, second = Store.open(tmp_path / "first"), Store.open(tmp_path / "second")
    assert copy_store(filled, first) == copy_store(first, second)
    for store in (first, second):
        assert [record.name for record in store.page().records] == ["study 2", "study 0"]
        for name in ("study 0", "study 2"):
            was, now = filled.find(name), store.find(name)
            assert list(verify(store, now)) == []
            assert store.cube(now.id).load().identical(filled.cube(was.id).load())
            assert store.events(now.id) == filled.events(was.id)
            assert now.provenance == was.provenance
        copied = store.find("study 2")
        assert (copied.state, copied.owner, copied.blocks_done) == ("queued", None, 4)
        assert collect_garbage(store, -1.0).paths == 0  # what is no study's did not come along
    first.close()
    second.close()


def test_a_backup_goes_on_living(filled, tmp_path, make_study, make_plan_of, values_of):
    copy = Store.open(tmp_path / "copy")
    copy_store(filled, copy)
    study = make_study("study 2", damping_ratio=0.03, metrics=METRICS)
    for index in copy.pending(study.digest[:12]):
        write(copy, study, make_plan_of(study), values_of, int(index), "later")
    assert copy.find("study 2").points_done == study.points
    new = make_study("new", damping_ratio=0.4)
    assert copy.submit(new, make_plan_of(new), {})[1]
    copy.close()


def test_a_backup_taken_while_blocks_come_and_go_is_of_one_moment(
    filled, tmp_path, make_study, make_plan_of, values_of
):
    study = make_study("study 2", damping_ratio=0.03, metrics=METRICS)
    plan = make_plan_of(study)
    filled.release(study.digest[:12], "runner 7")
    stop = threading.Event()

    def churn() -> None:
        turn = 0
        while not stop.is_set():
            turn += 1
            for index in (5, 6, 7):
                write(filled, study, plan, values_of, index, f"turn{turn}")
            filled.forget(study.digest[:12], [5, 6, 7], "churn")

    thread = threading.Thread(target=churn)
    thread.start()
    try:
        for number in range(3):
            copy = Store.open(tmp_path / f"copy {number}")
            copy_store(filled, copy)
            for record in copy.page().records:
                assert list(verify(copy, record)) == []
                assert (copy.cube(record.id)["status"] == 0).sum() == record.points_done
            copy.close()
    finally:
        stop.set()
        thread.join()


def test_a_store_with_studies_is_not_written_over(filled, store, tmp_path, make_study, make_plan_of):
    used = Store.open(tmp_path / "used")
    used.submit(make_study(), make_plan_of(make_study()), {})
    with pytest.raises(StoreFault, match="without studies"):
        copy_store(filled, used)
    assert len(used.page().records) == 1
    used.close()


def test_damage_is_not_backed_up_in_silence_and_leaves_no_half_backup(filled, tmp_path):
    lost = next(Path(filled.cube_path(filled.find("study 0").id), "blocks").glob("*"))
    lost.unlink()
    copy = Store.open(tmp_path / "copy")
    copied = copy_store(filled, copy)
    (told,) = copied.damaged
    assert "damperlab verify" in told
    assert (copied.studies, [record.name for record in copy.page().records]) == (1, ["study 2"])
    assert list(verify(copy, copy.find("study 2"))) == []
    copy.close()


def test_a_study_that_was_damaged_since_stays_in_the_backup_as_it_was(
    filled, tmp_path, make_study, make_plan_of, values_of
):
    copy = Store.open(tmp_path / "copy")
    copy_store(filled, copy)
    before = copy.cube(copy.find("study 0").id).load()
    record = filled.find("study 0")
    Path(filled.cube_path(record.id), "zarr.json").write_bytes(b"{}")
    study = make_study("later", damping_ratio=0.5, metrics=METRICS)
    filled.submit(study, make_plan_of(study), {"kernels": "k"})
    write(filled, study, make_plan_of(study), values_of, 0)
    copied = copy_store(filled, copy)
    assert (copied.studies, len(copied.damaged)) == (3, 1)
    assert copy.find("later").blocks_done == 1
    assert copy.cube(record.id).load().identical(before)
    assert list(verify(copy, copy.find(record.id))) == []
    copy.close()


def test_a_backup_does_not_forget_what_the_store_has_lost(filled, tmp_path):
    copy = Store.open(tmp_path / "copy")
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
    copy.close()


def inodes(folder: Path) -> dict[str, int]:
    return {str(file): file.stat().st_ino for file in folder.rglob("*~*")}


def test_a_backup_is_taken_again_and_copies_what_is_new(
    filled, tmp_path, make_study, make_plan_of, values_of
):
    copy = Store.open(tmp_path / "copy")
    first = copy_store(filled, copy)
    before = inodes(tmp_path / "copy")
    study = make_study("study 2", damping_ratio=0.03, metrics=METRICS)
    filled.release(study.digest[:12], "runner 7")
    write(filled, study, make_plan_of(study), values_of, 9)
    filled.delete(filled.find("study 0").id)
    second = copy_store(filled, copy)
    assert (first.blocks, second.blocks) == (16, 5)
    assert 0 < second.bytes < first.bytes / 8  # one block of sixteen
    after = inodes(tmp_path / "copy")
    assert {file: after[file] for file in before if file in after}.items() <= before.items()
    assert [record.name for record in copy.page().records] == ["study 2"]
    assert copy.find("study 2").blocks_done == 5
    assert list(verify(copy, copy.find("study 2"))) == []
    assert len(after) == 5
    copy.close()


def test_a_backup_that_was_cut_short_is_gone_on_with(filled, tmp_path):
    lost = Path(filled.cube_path(filled.find("study 2").id), "blocks", "2~g")
    content = lost.read_bytes()
    lost.unlink()
    copy = Store.open(tmp_path / "copy")
    assert copy_store(filled, copy).damaged
    copy.close()
    lost.write_bytes(content)
    copy = Store.open(tmp_path / "copy")
    assert copy_store(filled, copy).studies == 2
    for record in copy.page().records:
        assert list(verify(copy, record)) == []
    copy.close()


def test_an_update_that_was_cut_short_is_gone_on_with(filled, tmp_path, make_study, make_plan_of, values_of):
    copy = Store.open(tmp_path / "copy")
    copy_store(filled, copy)
    copy.close()
    study = make_study("later", damping_ratio=0.5, metrics=METRICS)
    filled.submit(study, make_plan_of(study), {"kernels": "k"})
    write(filled, study, make_plan_of(study), values_of, 0)
    # as a killed copy leaves it: files that the copy's catalogue does not know yet
    name = Path(filled.cube_path(filled.find("later").id)).name
    shutil.copytree(filled.data_dir / "cubes" / name, tmp_path / "copy" / "cubes" / name)
    copy = Store.open(tmp_path / "copy")
    assert copy_store(filled, copy).studies == 3
    assert copy.find("later").blocks_done == 1
    copy.close()


def test_a_backup_with_studies_of_its_own_is_not_written_over(filled, tmp_path, make_study, make_plan_of):
    copy = Store.open(tmp_path / "copy")
    copy_store(filled, copy)
    study = make_study("its own", damping_ratio=0.5)
    copy.submit(study, make_plan_of(study), {})
    with pytest.raises(StoreFault, match="holds other studies"):
        copy_store(filled, copy)
    assert copy.find("its own").points_total == study.points
    copy.close()


def test_a_flipped_bit_is_not_backed_up(filled, tmp_path):
    block = Path(filled.cube_path(filled.find("study 0").id), "blocks", "7~g")
    content = bytearray(block.read_bytes())
    content[-9] ^= 1
    block.write_bytes(bytes(content))
    copy = Store.open(tmp_path / "copy")
    (told,) = copy_store(filled, copy).damaged
    assert "Block 7" in told
    copy.close()


def test_a_damaged_or_lost_coordinate_is_not_backed_up(filled, tmp_path):
    axis = Path(filled.cube_path(filled.find("study 0").id), "clearance_ratio", "c.0")
    whole = axis.read_bytes()
    copy = Store.open(tmp_path / "copy")
    for content, told in ((bytes([whole[0] ^ 1]) + whole[1:], "clearance_ratio"), (None, "description")):
        axis.unlink() if content is None else axis.write_bytes(content)
        (sentence,) = copy_store(filled, copy).damaged
        assert told in sentence
    copy.close()


def test_a_file_that_was_cut_short_in_a_backup_is_copied_again(filled, tmp_path):
    copy = Store.open(tmp_path / "copy")
    copy_store(filled, copy)
    study = copy.find("study 0")
    block = Path(copy.cube_path(study.id), "blocks", "7~g")
    block.write_bytes(block.read_bytes()[:-5])
    assert copy_store(filled, copy).bytes == block.stat().st_size
    assert list(verify(copy, copy.find("study 0"))) == []
    copy.close()


def test_a_damaged_record_is_told_and_spoils_no_copy(filled, tmp_path):
    record_id, _ = Records(filled.data_dir).put(kanai_tajimi(1, 2.0, rise_s=0.5, fall_s=0.5))
    copy = Store.open(tmp_path / "copy")
    assert copy_store(filled, copy).damaged == ()
    samples = filled.data_dir / "records" / f"{record_id}.npy"
    content = bytearray(samples.read_bytes())
    content[-3] ^= 4
    samples.write_bytes(bytes(content))
    (told,) = copy_store(filled, copy).damaged
    assert record_id in told
    assert list(Records(tmp_path / "copy").damaged()) == []
    copy.close()


def test_uploaded_records_come_along(filled, tmp_path):
    records = filled.data_dir / "records"
    records.mkdir()
    (records / "mine.json").write_text("{}")
    copy, restored = Store.open(tmp_path / "copy"), Store.open(tmp_path / "restored")
    copy_store(filled, copy)
    copy_store(copy, restored)
    assert (tmp_path / "restored" / "records" / "mine.json").read_text() == "{}"
    copy.close()
    restored.close()
