"""Stores that released versions have made: opened, read to the last bit, verified, resumed, copied and rebuilt.

`store-0.1.0.tar.xz` was made by 0.1.0: two studies of a structure alone, one complete, one cancelled after two of four
blocks. Without friction and particle the response is the transmissibility in closed form.
"""

import tarfile
from pathlib import Path

import numpy as np
import pytest
from sqlalchemy import select
from tests.archives import extract_all
from tests.oracles.transmissibility import absolute_amplitude

from damperlab.studies.definition import parse_study
from damperlab.studies.plan import plan_with_chunk
from damperlab.studies.store.care.backup import copy_store
from damperlab.studies.store.care.rebuild import rebuild
from damperlab.studies.store.care.sweep import collect_garbage
from damperlab.studies.store.care.verify import check_catalogue, verify
from damperlab.studies.store.catalogue.quota import Taken
from damperlab.studies.store.catalogue.tables import done_blocks
from damperlab.studies.store.cube.cube import bytes_per_point, write_region
from damperlab.studies.store.record import BlockOutcome
from damperlab.studies.store.store import Store

FREQUENCIES = np.array([0.8, 0.9, 1.0, 1.1, 1.2, 1.3, 1.4])


@pytest.fixture
def first(tmp_path: Path) -> Path:
    with tarfile.open(Path(__file__).with_name("store-0.1.0.tar.xz")) as archive:
        extract_all(archive, tmp_path / "first")
    return tmp_path / "first"


def test_a_store_of_the_first_release_is_read_as_it_is(first):
    before = {file: file.read_bytes() for file in (first / "cubes").rglob("*") if file.is_file()}
    store = Store.open(first)
    assert list(check_catalogue(store)) == []
    for name, zeta, done in (("complete", 0.02, 7), ("half done", 0.05, 4)):
        record = store.find(name)
        assert record.points_done == done
        assert list(verify(store, record)) == []
        found = store.cube(record.id)["amplitude_ratio"].values.reshape(-1)
        np.testing.assert_allclose(
            found[:done], [absolute_amplitude(zeta, r) for r in FREQUENCIES[:done]], rtol=1e-12
        )
        assert np.isnan(found[done:]).all()
        assert store.cube(record.id).attrs["complete"] == ("yes" if done == 7 else "no")
    # counted by their definitions: that catalogue kept no sizes
    studies = [parse_study(record.definition) for record in store.page().records]
    assert store.taken() == Taken(14, sum(each.points * bytes_per_point(each) for each in studies))
    assert collect_garbage(store, -1.0, trash_seconds=-1.0).paths == 0
    store.close()
    assert {file: file.read_bytes() for file in before} == before
    Store.open(first).close()  # and once more, now that it is migrated


def test_a_study_of_the_first_release_goes_on_where_it_was(first):
    store = Store.open(first)
    record = store.find("half done")
    study = parse_study(record.definition)
    plan = plan_with_chunk(study, record.chunk, lambda _, at: np.ones(len(at["mass_ratio"])))
    before = store.cube(record.id).load()
    for index in store.pending(record.id):
        block = plan.block(int(index))
        values = {name: array.values[block.slices] for name, array in before.data_vars.items()}
        values["amplitude_ratio"] = np.full(block.shape, 3.0)
        found = write_region(store.cube_path(record.id), block, values, "later")
        store.mark(record.id, BlockOutcome(block.index, block.points, 0, 1.0, 1.0, None, "later", found))
    done = store.set_state(record.id, "done")
    assert list(verify(store, done)) == []
    after = store.cube(record.id)["amplitude_ratio"].values.reshape(-1)
    np.testing.assert_array_equal(after[:4], before["amplitude_ratio"].values.reshape(-1)[:4])
    np.testing.assert_array_equal(after[4:], 3.0)
    store.close()


def test_a_store_of_the_first_release_is_copied(first, tmp_path):
    store, copy = Store.open(first), Store.open(tmp_path / "copy")
    assert copy_store(store, copy).studies == 2
    for record in copy.page().records:
        assert list(verify(copy, record)) == []
        assert copy.cube(record.id).load().identical(store.cube(record.id).load())
    copy.close()
    store.close()


def test_a_store_of_the_first_release_is_rebuilt_with_every_block(first):
    store = Store.open(first)
    before = {record.id: (record, store.cube(record.id).load()) for record in store.page().records}
    marks = {
        study_id: [
            (mark.block, mark.generation, mark.points, mark.failed, mark.checksum)
            for mark in marks_in(store, study_id)
        ]
        for study_id in before
    }
    store.close()
    for file in first.glob("catalogue.sqlite*"):
        file.unlink()
    found = rebuild(first)
    assert (found.studies, found.blocks, found.trouble) == (2, 4 + 2, [])
    again = Store.open(first)
    for study_id, (record, cube) in before.items():
        now = again.find(study_id)
        assert (now.points_done, now.points_failed, now.outdated) == (
            record.points_done,
            record.points_failed,
            record.outdated,
        )
        assert now.state == ("done" if record.state == "done" else "queued")
        assert again.cube(study_id).load().identical(cube)
        told = [
            (mark.block, mark.generation, mark.points, mark.failed, mark.checksum)
            for mark in marks_in(again, study_id)
        ]
        # the first catalogues kept no checksum of every block
        assert [mark[:4] for mark in told] == [mark[:4] for mark in marks[study_id]]
        for one, other in zip(told, marks[study_id], strict=True):
            assert other[4] in (None, one[4])
        assert list(verify(again, now)) == []
    again.close()


def test_a_block_of_the_first_release_that_is_not_whole_is_told_and_not_taken(first):
    store = Store.open(first)
    record = store.find("complete")
    cube = Path(store.cube_path(record.id))
    store.close()
    lost, damaged = cube / "period" / "c.0.0.0.0.0.1~g1", cube / "period" / "c.0.0.0.0.0.2~g2"
    lost.unlink()
    content = bytearray(damaged.read_bytes())
    content[-1] ^= 1
    damaged.write_bytes(bytes(content))
    for file in first.glob("catalogue.sqlite*"):
        file.unlink()
    found = rebuild(first)
    (trouble,) = found.trouble
    assert "block 2" in trouble
    again = Store.open(first)
    np.testing.assert_array_equal(again.pending(record.id), [1, 2])
    again.close()


def marks_in(store: Store, study_id: str):
    with store.catalogue.reading() as connection:
        number = store.number(connection, study_id)
        query = select(done_blocks).where(done_blocks.c.study == number).order_by(done_blocks.c.block)
        return connection.execute(query).all()
