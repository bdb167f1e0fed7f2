"""What happens to files behind the store's back is found, told, and mended; it is never read as a result."""

import shutil
from pathlib import Path

import numpy as np
import pytest
from tests.filling import (
    enter,
    flip,
    lose_catalogue,
    make_plan_of,
    make_study,
    put,
    values_of,
    write,
    write_behind,
)

from damperlab.studies.store.care.rebuild import rebuild
from damperlab.studies.store.care.sweep import collect_garbage, sweep
from damperlab.studies.store.care.verify import check_catalogue, repair, verify
from damperlab.studies.store.cube.coding import checksum
from damperlab.studies.store.faults import BlockDamaged, CatalogueDamaged, StoreFault, StudyBusy
from damperlab.studies.store.store import Store

METRICS = ["amplitude_ratio", "cycles", "run_time"]
PAGE = 4096


@pytest.fixture(scope="module")
def made(tmp_path_factory) -> Path:
    """A store with a whole study, every block of a generation of its own."""
    store = Store.open(tmp_path_factory.mktemp("made") / "data")
    study = make_study(metrics=METRICS)
    record = enter(store, study)
    for index in range(record.blocks_total):
        put(store, study, index, generation=f"g{index}")
    store.set_state(record.id, "done")
    store.close()
    return store.data_dir


@pytest.fixture
def store(copied):
    return copied


@pytest.fixture
def written(store):
    return store.page().records[0]


def file_of(store: Store, record, index: int) -> Path:
    return Path(store.cube_path(record.id), "blocks", f"{index}~g{index}")


def test_every_damage_is_found_told_on_reading_and_mended(store, written):
    """Of each block another one."""
    before = store.cube(written.id).load()
    content = file_of(store, written, 0).read_bytes()
    half = content[: len(content) // 2].ljust(len(content), b"\0")
    harms = [content[:-7], b"", half, bytes(len(content)), None, file_of(store, written, 8).read_bytes()]
    for index, harmed in enumerate(harms):
        file = file_of(store, written, index)
        file.unlink() if harmed is None else file.write_bytes(harmed)
    flip(file_of(store, written, 6), content.index(b"{") + 9, 0x10)
    assert [damage.block for damage in verify(store, written)] == list(range(7))
    blocks = list(map(make_plan_of(make_study(metrics=METRICS)).block, range(7)))
    cube = store.cube(written.id)
    for block in blocks:
        with pytest.raises(BlockDamaged, match=r"damperlab store verify --repair"):
            cube.isel(dict(zip(cube.dims, block.slices, strict=True))).load()
    left = repair(store, written, list(verify(store, written)))
    assert (left.state, left.blocks_done) == ("queued", left.blocks_total - 7)
    np.testing.assert_array_equal(store.pending(written.id), range(7))
    lost = store.cube(written.id).load()
    assert (lost["status"].values == -1).sum() == sum(block.points for block in blocks)
    for block in blocks:
        assert np.isnan(lost["amplitude_ratio"].values[block.slices]).all()
        write(store, written.id, block, values_of(make_study(metrics=METRICS), block), "second")
    assert list(verify(store, store.find(written.id))) == []
    assert store.cube(written.id).load().identical(before)


@pytest.mark.parametrize("name", ["zarr.json", "marks.json", "clearance_ratio/c.0"])
def test_damage_beside_the_blocks_is_found_written_anew_and_costs_no_block(store, written, name):
    before = store.cube(written.id).load()
    file = Path(store.cube_path(written.id)) / name
    content = file.read_bytes()
    zeros = bytes(len(content)), content[: len(content) // 2].ljust(len(content), b"\0")
    for changed in (*zeros, b"", b"{" * 40, None):
        file.unlink() if changed is None else file.write_bytes(changed)
        damages = list(verify(store, written))
        assert [damage.block for damage in damages] == [None]
        if name != "marks.json":
            told = f"{written.id} .*damperlab store verify --repair {written.id}"
            with pytest.raises(BlockDamaged, match=told):
                store.cube(written.id)
        assert repair(store, written, damages).blocks_done == written.blocks_total
        assert list(verify(store, written)) == []
        assert store.cube(written.id).load().equals(before)


def test_no_page_of_the_catalogue_is_lost_unseen(store, written):
    """With any one page damaged the store opens unchanged, or is refused and rebuilt from the cubes.

    Every other page is zeros; at the others the file is cut off.
    """
    data, before = store.data_dir, store.cube(written.id).load()
    store.close()
    catalogue = data / "catalogue.sqlite"
    whole = catalogue.read_bytes()
    refused = set_aside = 0
    for page, start in enumerate(range(0, len(whole), PAGE)):
        rest = b"" if page % 2 else bytes(PAGE) + whole[start + PAGE :]
        catalogue.write_bytes(whole[:start] + rest)
        try:
            opened = Store.open(data)
            try:
                assert [record.id for record in opened.page().records] == [written.id]
                assert opened.cube(written.id).load().identical(before)
                assert list(check_catalogue(opened)) == []
            finally:
                opened.close()
        except StoreFault:
            refused += 1
        damaged = catalogue.read_bytes()
        aside = rebuild(data).set_aside
        assert aside is None or Path(aside).read_bytes() == damaged
        set_aside += aside is not None
        opened = Store.open(data)
        assert opened.find(written.id).blocks_done == written.blocks_total
        assert opened.cube(written.id).load().equals(before)
        opened.close()
        lose_catalogue(data)
    assert refused > len(whole) // PAGE // 2
    assert set_aside


def test_a_done_mark_of_no_block_hides_none(store, written):
    """Its block would read as not computed."""
    before = store.cube(written.id).load()
    for index in ("999", "-3", "4.5", "'x'"):
        write_behind(store.data_dir, f"UPDATE done_blocks SET block = {index} WHERE block = 4")
        opened = Store.open(store.data_dir)
        for ask in (opened.pending, opened.cube, opened.lost_blocks):
            with pytest.raises(CatalogueDamaged, match="that does not exist"):
                ask(written.id)
        assert any("done-mark" in damage.found for damage in verify(opened, written))
        opened.close()
        rebuild(store.data_dir)
        assert list(verify(store, store.find(written.id))) == []
        assert store.cube(written.id).load().equals(before)


def test_a_claim_that_ends_at_no_time_is_over(store, written):
    assert store.claim(written.id, "one")
    write_behind(store.data_dir, "UPDATE studies SET claim_expires = 'x'")
    assert store.find(written.id).owner is None
    assert store.claim(written.id, "next")


def test_a_lost_done_mark_is_told_by_whoever_asks_what_is_left(store, written):
    write_behind(store.data_dir, "DELETE FROM done_blocks WHERE block = 4")
    for ask in (store.pending, store.cube):
        with pytest.raises(CatalogueDamaged, match="damperlab store verify"):
            ask(written.id)
    repair(store, written, list(verify(store, written)))
    np.testing.assert_array_equal(store.pending(written.id), [4])


def test_a_late_twin_of_a_done_block_changes_nothing_and_is_swept(store, written):
    block = make_plan_of(make_study(metrics=METRICS)).block(2)
    before = store.cube(written.id).load()
    other = values_of(make_study(metrics=METRICS), block) | {"run_time": np.full(block.shape, 9.0)}
    # an attempt whose runner lost its claim ends after its block was done by somebody else
    write(store, written.id, block, other, "late")
    assert store.cube(written.id).load().identical(before)
    assert list(verify(store, written)) == []
    assert sweep(store, written.id, dry_run=True).paths == sweep(store, written.id).paths == 1
    assert sweep(store, written.id).paths == 0
    assert store.cube(written.id).load().identical(before)


def test_an_opened_cube_never_shows_a_block_that_was_replaced(store, written):
    opened = store.cube(written.id)
    block = make_plan_of(make_study(metrics=METRICS)).block(0)
    store.forget(written.id, [0], "by hand")
    newer = values_of(make_study(metrics=METRICS), block) | {"amplitude_ratio": np.full(block.shape, 77.0)}
    write(store, written.id, block, newer, "newer")
    # the older files stay until they are swept, and with them what was opened before
    assert (opened["amplitude_ratio"].values[block.slices] == 0).all()
    assert (store.cube(written.id)["amplitude_ratio"].values[block.slices] == 77).all()
    sweep(store, written.id)
    with pytest.raises(BlockDamaged, match="replaced since the cube was opened"):
        opened["amplitude_ratio"].load()


def test_blocks_are_not_taken_back_from_under_a_runner(store, written):
    store.claim(written.id, "runner 7")
    with pytest.raises(StudyBusy, match="runner 7"):
        store.forget(written.id, [1], "by hand")
    assert store.find(written.id).blocks_done == written.blocks_total


def test_garbage_is_collected_and_nothing_else(store, written, tmp_path):
    other = make_study(damping_ratio=0.2, metrics=METRICS)
    record = enter(store, other)
    claimed = Path(store.cube_path(record.id), "blocks", "0~attempt")
    claimed.write_bytes(b"of a runner that is at work")
    store.claim(record.id, "runner 7")
    partial = Path(store.cube_path(written.id), "blocks", "0~g0.0123.partial")
    partial.write_bytes(b"half")
    unknown = store.data_dir / "cubes" / "0123456789ab-99.zarr"
    unknown.mkdir()
    # a study whose row went with the tail of the catalogue's log, and whose number another one got
    elsewhere = Store.open(tmp_path / "elsewhere")
    third = make_study(damping_ratio=0.3, metrics=METRICS)
    gone = Path(elsewhere.cube_path(enter(elsewhere, third).id))
    elsewhere.close()
    lost = store.data_dir / "cubes" / gone.name
    shutil.copytree(gone, lost)
    # a submission that was killed, whose number another study got
    orphan = store.data_dir / "cubes" / "0123456789ab-1.zarr"
    orphan.mkdir()
    export = store.data_dir / "export-abc"
    export.mkdir()
    assert collect_garbage(store).paths == 0  # too young: it may be in use
    before, there = store.cube(written.id).load(), sorted(store.data_dir.rglob("*"))
    assert not any(orphan.name in line for line in collect_garbage(store, -1.0, dry_run=True).what)
    would = collect_garbage(store, -1.0, orphan_seconds=-1.0, dry_run=True)
    assert sorted(store.data_dir.rglob("*")) == there
    did = collect_garbage(store, -1.0, orphan_seconds=-1.0)
    assert (did.paths, did.what) == (3, would.what)
    assert any(unknown.name in line for line in would.unknown)
    assert not any(path.exists() for path in (partial, orphan, *store.data_dir.glob("export-*")))
    assert claimed.exists()
    assert unknown.exists()  # nobody knows whose it is
    assert lost.exists()
    assert collect_garbage(store, -1.0, orphan_seconds=-1.0).paths == 0
    assert store.cube(written.id).load().identical(before)


def test_a_checksum_tells_values_types_and_places_apart():
    one = {"a": np.arange(6.0).reshape(2, 3), "b": np.zeros(2, np.int8)}
    same = {"b": np.zeros(2, np.int8), "a": np.asfortranarray(np.arange(6.0).reshape(2, 3))}
    assert checksum(one) == checksum(same)
    others = [
        {**one, "a": one["a"].reshape(3, 2)},
        {**one, "a": one["a"].astype("f4")},
        {**one, "a": -one["a"]},  # -0.0 is not 0.0
        {"a": one["a"], "c": one["b"]},
    ]
    assert len({checksum(values) for values in (one, *others)}) == 5


def test_what_happened_to_a_study_is_kept(store, written):
    store.forget(written.id, [3], "by hand")
    store.delete(written.id)
    said = [what for _, what in store.events(written.id)]
    assert said == ["submitted", "queued to done", "1 blocks invalidated: by hand", "deleted"]
