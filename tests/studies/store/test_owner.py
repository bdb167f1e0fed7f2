"""Cubes and catalogue know each other: what does not belong together is refused, and nothing is removed."""

import shutil
from pathlib import Path

import pytest
from sqlalchemy import delete
from tests.filling import enter, fill, make_study, put

from damperlab.studies.store.care.rebuild import rebuild
from damperlab.studies.store.care.sweep import collect_garbage
from damperlab.studies.store.catalogue.rows import study_row
from damperlab.studies.store.catalogue.tables import done_blocks, studies
from damperlab.studies.store.faults import StoreFault
from damperlab.studies.store.files.folder import Folder
from damperlab.studies.store.store import Store

METRICS = ["amplitude_ratio"]


def filled(store: Store, damping_ratio: float) -> str:
    return fill(store, make_study(damping_ratio=damping_ratio, metrics=METRICS)).id


def files(folder: Path) -> set[Path]:
    return {path for path in folder.rglob("*") if path.is_file()}


def test_an_empty_or_foreign_catalogue_is_refused(tmp_path):
    mine, other = Store.open(tmp_path / "mine"), Store.open(tmp_path / "other")
    filled(mine, 0.01)
    filled(other, 0.02)
    for store in (mine, other):
        store.close()
    before = files(tmp_path / "mine" / "cubes")
    shutil.copy(tmp_path / "other" / "catalogue.sqlite", tmp_path / "mine" / "catalogue.sqlite")
    with pytest.raises(StoreFault, match="belongs to a catalogue other than"):
        Store.open(tmp_path / "mine")
    Store.open(tmp_path / "empty").close()
    shutil.copy(tmp_path / "empty" / "catalogue.sqlite", tmp_path / "mine" / "catalogue.sqlite")
    with pytest.raises(StoreFault, match="belongs to a catalogue other than"):
        Store.open(tmp_path / "mine")
    assert files(tmp_path / "mine" / "cubes") == before


def test_a_disk_that_is_not_mounted_is_told(tmp_path):
    store = Store.open(tmp_path)
    filled(store, 0.01)
    store.close()
    (tmp_path / "cubes").rename(tmp_path / "unmounted")
    with pytest.raises(StoreFault, match="mounted"):
        rebuild(tmp_path)
    with pytest.raises(StoreFault, match="mounted"):
        Store.open(tmp_path)
    (tmp_path / "cubes").rmdir()
    (tmp_path / "unmounted").rename(tmp_path / "cubes")
    Store.open(tmp_path).close()


def test_a_marker_that_is_lost_is_put_back_and_a_damaged_one_is_told(tmp_path):
    store = Store.open(tmp_path)
    filled(store, 0.01)
    store.close()
    marker = tmp_path / "cubes" / "damperlab.json"
    content = marker.read_bytes()
    marker.unlink()
    Store.open(tmp_path).close()
    assert marker.read_bytes() == content
    for at in range(0, 8 * len(content), 7):
        damaged = bytearray(content)
        damaged[at // 8] ^= 1 << at % 8
        marker.write_bytes(bytes(damaged))
        with pytest.raises(StoreFault, match="damperlab store rebuild"):
            Store.open(tmp_path)


@pytest.mark.parametrize("look", [1, 2, 3])
def test_a_new_folder_that_another_opens_and_fills_meanwhile_is_no_foreign_one(tmp_path, monkeypatch, look):
    """The other comes whenever the cubes are looked for: before or after this one has looked for marker and catalogue."""
    shelves, looks, meanwhile = Folder.shelves, [], []

    def shelves_of(folder):
        looks.append(folder)
        if len(looks) == look:
            other = Store.open(tmp_path)
            meanwhile.append(filled(other, 0.01))
            other.close()
        return shelves(folder)

    monkeypatch.setattr(Folder, "shelves", shelves_of)
    store = Store.open(tmp_path)
    monkeypatch.undo()
    assert [record.id for record in store.page().records] == meanwhile
    store.close()


@pytest.mark.parametrize("before", [False, True])
def test_an_older_copy_costs_no_block_that_was_computed_since(tmp_path, before):
    """For the first time, or anew."""
    data = tmp_path / "data"
    study = make_study(metrics=METRICS)
    store = Store.open(data)
    record = enter(store, study)
    if before:
        put(store, study, 2, generation="first")
    store.close()
    shutil.copy(data / "catalogue.sqlite", tmp_path / "older")
    store = Store.open(data)
    if before:
        store.forget(record.id, [2], "damaged")
    put(store, study, 2, generation="second")
    collect_garbage(store, -1.0)
    store.close()
    kept = files(data / "cubes")
    shutil.copy(tmp_path / "older", data / "catalogue.sqlite")
    store = Store.open(data)
    assert collect_garbage(store, -1.0, orphan_seconds=-1.0).paths == 0
    assert files(data / "cubes") == kept
    store.close()


def test_results_that_lie_under_the_number_of_another_study_are_told_and_brought_back(tmp_path):
    data = tmp_path / "data"
    store, other = Store.open(data), Store.open(tmp_path / "other")
    filled(store, 0.01)
    brought = Path(other.cube_path(filled(other, 0.02)))
    cube = other.cube(other.page().records[0].id).load()
    shutil.copytree(brought, data / "cubes" / brought.name)
    before = files(data / "cubes")
    swept = collect_garbage(store, -1.0, orphan_seconds=-1.0)
    assert (swept.paths, files(data / "cubes")) == (0, before)
    assert "holds results" in swept.unknown[0]
    (trouble,) = rebuild(data).trouble
    assert "rename its folder" in trouble
    assert files(data / "cubes") == before
    (data / "cubes" / brought.name).rename(data / "cubes" / brought.name.replace("-1.zarr", "-7.zarr"))
    assert (rebuild(data).studies, rebuild(data).trouble) == (1, [])
    again = Store.open(data)
    assert again.cube(other.page().records[0].id).load().identical(cube)
    for each in (store, other, again):
        each.close()


def test_a_submission_removes_no_results_that_have_its_number(tmp_path):
    store = Store.open(tmp_path)
    filled(store, 0.01)
    study_id = filled(store, 0.02)
    before = files(tmp_path / "cubes")
    # as an older copy that was put in its place: it knows nothing of the second, nor that its number was given
    with store.catalogue.writing() as connection:
        number = study_row(connection, study_id).number
        connection.execute(delete(done_blocks).where(done_blocks.c.study == number))
        connection.execute(delete(studies).where(studies.c.number == number))
        connection.exec_driver_sql(f"UPDATE sqlite_sequence SET seq = {number - 1} WHERE name = 'studies'")
    with pytest.raises(StoreFault, match="older copy"):
        filled(store, 0.02)
    assert files(tmp_path / "cubes") == before
    store.close()
