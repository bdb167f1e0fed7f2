"""The cube: what a block writes is what a reader gets, once the block is marked, and lazily."""

import json
import os
import threading
import tracemalloc
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from tests.filling import enter, entered, make_plan_of, make_study, outcome_of, put, values_of

import damperlab.studies.store.files.folder
from damperlab.studies.store.cube.block_file import write_region
from damperlab.studies.store.faults import StoreFault
from damperlab.studies.store.store import Store
from damperlab.studies.variables import DIMENSIONS, STANDARD, VARIABLES, Status


def test_the_cube_has_the_contracts_names_units_and_flags(store):
    study = make_study()
    record = enter(store, study, solver_version="3.2")
    cube = store.cube(record.id)
    assert tuple(cube.sizes) == DIMENSIONS
    assert tuple(cube.data_vars) == STANDARD
    for name, values in study.coordinates.items():
        np.testing.assert_array_equal(cube[name], values)
    for name in (*DIMENSIONS, *STANDARD):
        assert cube[name].attrs["units"]
        assert cube[name].attrs["long_name"]
    assert dict(
        zip(cube["status"].attrs["flag_meanings"].split(), cube["status"].attrs["flag_values"], strict=True)
    ) == {status.name.lower(): status.value for status in Status}
    assert cube.attrs["digest"] == study.digest
    assert cube.attrs["solver_version"] == "3.2"
    assert json.loads(cube.attrs["study"]) == study.document()


def test_every_block_comes_back_where_it_belongs(store):
    study, plan, study_id = entered(store)
    expected = np.full(study.shape, np.nan)
    for index in (0, 4, 7, 11):  # whole chunks and ones cut by each edge
        put(store, study, index)
        expected[plan.block(index).slices] = index
    cube = store.cube(study_id)
    for name in set(STANDARD) - {"status"}:
        known = np.where(np.isnan(expected), VARIABLES[name].fill, expected)
        np.testing.assert_array_equal(cube[name], known)
        assert cube[name].dtype == VARIABLES[name].dtype
    np.testing.assert_array_equal(cube["status"], np.where(np.isnan(expected), -1, 0))


def test_a_study_of_one_point_takes_a_handful_of_files(store):
    axes = dict.fromkeys(
        ("clearance_ratio", "friction_ratio", "restitution", "mass_ratio", "frequency_ratio"), 0.5
    )
    study, _, study_id = entered(store, (1,) * 6, axes=axes)
    put(store, study, 0)
    store.set_state(study_id, "done")
    files = [file for file in Path(store.cube_path(study_id)).rglob("*") if file.is_file()]
    assert sorted(file.name for file in files) == ["0~", "marks.json", "zarr.json"]
    seen = store.cube(study_id).load()
    assert {name: seen[name].item() for name in axes} == axes


def test_every_way_of_indexing_hides_the_same_points(store):
    study, plan, study_id = entered(store)
    for index in range(plan.count):
        block = plan.block(index)
        write_region(store.cube_path(study_id), block, values_of(study, block))
        if index % 3:
            store.mark(study_id, outcome_of(block))
    whole = store.cube(study_id)["amplitude_ratio"].load()
    assert 0 < np.isnan(whole).sum() < whole.size
    rng = np.random.default_rng(5)
    for _ in range(25):
        index: dict[str, object] = {}
        for name in DIMENSIONS:
            extent = whole.sizes[name]
            index[name] = (
                int(rng.integers(extent)),
                slice(None, None, int(rng.choice([-2, -1, 1, 2]))),
                rng.integers(extent, size=3),
                slice(int(rng.integers(extent)), None),
            )[rng.integers(4)]
        xr.testing.assert_identical(
            store.cube(study_id)["amplitude_ratio"].isel(index).load(), whole.isel(index)
        )
    points = {name: ("point", rng.integers(whole.sizes[name], size=9)) for name in DIMENSIONS}
    xr.testing.assert_identical(
        store.cube(study_id)["amplitude_ratio"].isel(points).load(), whole.isel(points)
    )


def test_blocks_done_after_the_cube_was_opened_stay_hidden(store):
    study, plan, study_id = entered(store)
    before = store.cube(study_id)
    put(store, study, 0)
    assert (before["status"] == -1).all()
    assert (store.cube(study_id)["status"] == 0).sum() == plan.block(0).points


def test_a_reader_beside_a_writer_never_sees_a_torn_block(store):
    more = {"clearance_ratio": {"start": 1, "stop": 9, "num": 20}}
    study, plan, study_id = entered(store, axes=make_study().document()["axes"] | more)
    put(store, study, 0)

    def write() -> None:
        with closing(Store.open(store.data_dir)) as other:
            for index in range(1, plan.count):
                put(other, study, index)

    writer = threading.Thread(target=write)
    writer.start()
    seen = [1]
    while seen[-1] < plan.count:
        assert writer.is_alive() or store.find(study_id).blocks_done == plan.count
        # what the record says is done must be there in full in the cube that is opened after it
        promised = store.find(study_id).points_done
        cube = store.cube(study_id).load()
        there = cube["status"].values == 0
        assert there.sum() >= promised
        for name in set(STANDARD) - {"status"}:
            np.testing.assert_array_equal(cube[name].values[there], cube["amplitude_ratio"].values[there])
            np.testing.assert_array_equal(cube[name].values[~there], VARIABLES[name].fill)
        seen.append(np.unique(cube["amplitude_ratio"].values[there]).size)
    writer.join()
    assert sorted(seen) == seen
    assert len(set(seen)) > 2  # it was read while it was written


@pytest.fixture
def synced(monkeypatch) -> set[int]:
    """Files and folders that were synced, by number: a file is synced before it gets its name."""
    found: set[int] = set()
    real = os.fsync

    def record(descriptor: int) -> None:
        found.add(os.fstat(descriptor).st_ino)
        real(descriptor)

    monkeypatch.setattr(damperlab.studies.store.files.folder.os, "fsync", record)
    return found


def test_a_region_is_on_the_disk_before_it_is_reported(store, synced):
    study, plan, study_id = entered(store)
    path = Path(store.cube_path(study_id))
    synced.clear()
    before = set(path.rglob("*"))
    values = values_of(study, plan.block(2)) | {"floquet_multiplier": np.full(plan.block(2).shape, np.nan)}
    write_region(str(path), plan.block(2), values)
    (chunk,) = set(path.rglob("*")) - before
    assert {chunk.stat().st_ino, chunk.parent.stat().st_ino} <= synced


def test_a_new_cube_is_on_the_disk_before_its_record(store, synced):
    *_, study_id = entered(store)
    path = Path(store.cube_path(study_id))
    assert {made.stat().st_ino for made in (path, path.parent, *path.rglob("*"))} <= synced


def test_a_writer_finds_out_that_the_cube_is_gone(store):
    study, plan, study_id = entered(store)
    path = store.cube_path(study_id)
    store.delete(study_id)
    store.bury()
    with pytest.raises(FileNotFoundError):
        write_region(path, plan.block(0), values_of(study, plan.block(0)))
    assert not Path(path).exists()


def test_values_that_do_not_fit_are_an_error_of_the_program(store):
    study = make_study()
    plan = make_plan_of(study)
    path = store.cube_path(store.submit(study, plan, {})[0].id)
    values = values_of(study, plan.block(0))
    with pytest.raises(ValueError, match="cycles has shape"):
        write_region(path, plan.block(0), values | {"cycles": np.zeros((1, 1), np.int32)})
    del values["cycles"]
    with pytest.raises(KeyError, match="cycles"):
        write_region(path, plan.block(0), values)
    assert list(Path(path, "blocks").iterdir()) == []


def test_a_cube_whose_files_are_lost_is_told(store):
    *_, study_id = entered(store)
    Path(store.cube_path(study_id)).rename(store.data_dir / "elsewhere")
    with pytest.raises(StoreFault, match="computed again"):
        store.cube(study_id)


def test_a_cube_of_ten_million_points_is_opened_and_sliced_in_little_memory(store):
    axes = {
        "clearance_ratio": {"start": 1, "stop": 25, "num": 250},
        "friction_ratio": {"start": 0, "stop": 1, "num": 200},
        "restitution": 0.5,
        "mass_ratio": 0.1,
        "frequency_ratio": {"start": 0.5, "stop": 1.5, "num": 200},
    }
    study = make_study(axes=axes)
    assert study.points == 10**7
    plan = make_plan_of(study, (1, 1, 1, 5, 10, 10))
    study_id = store.submit(study, plan, {})[0].id
    store.cube(study_id)
    tracemalloc.start()
    cube = store.cube(study_id)
    corner = cube["amplitude_ratio"].isel(frequency_ratio=0).values
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert corner.shape == (1, 1, 1, 250, 200)
    # the slice touches 1/20 of the chunks; a whole variable would take 80 MB
    assert peak < 16e6
