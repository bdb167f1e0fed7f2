"""Stores of 0.2.0 are read by every later version: a kept store is opened, verified, read and rebuilt."""

from contextlib import closing
from pathlib import Path

from tests.filling import lose_catalogue, make_plan_of, values_of
from tests.studies.store.kept import STUDY, unpack

from damperlab.studies.store.care.rebuild import rebuild
from damperlab.studies.store.care.verify import verify
from damperlab.studies.store.store import Store


def test_a_kept_store_is_opened_verified_read_and_rebuilt(tmp_path: Path) -> None:
    data_dir = unpack(tmp_path)
    plan = make_plan_of(STUDY)
    for lost in (False, True):
        if lost:
            lose_catalogue(data_dir)
            rebuild(data_dir)
        with closing(Store.open(data_dir)) as store:
            (record,) = store.page().records
            assert (record.digest, record.state, record.points_done) == (STUDY.digest, "done", plan.points)
            assert list(verify(store, record)) == []
            cube = store.cube(record.id)
            for block in map(plan.block, range(plan.count)):
                for name, values in values_of(STUDY, block).items():
                    assert cube[name].values[block.slices].tobytes() == values.tobytes()
