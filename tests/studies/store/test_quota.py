"""Quotas: what is counted, what is refused, and what makes room."""

from pathlib import Path

import pytest
from tests.filling import enter, make_plan_of, make_study

from damperlab.studies.store.catalogue.quota import Quota, Usage
from damperlab.studies.store.cube.description import bytes_per_point
from damperlab.studies.store.faults import QuotaReached, TooManyUnfinished
from damperlab.studies.store.provenance import submitter
from damperlab.studies.store.store import Store


def test_a_study_beyond_the_quota_is_refused_and_nothing_is_stored(tmp_path: Path) -> None:
    study, other = make_study(), make_study(damping_ratio=0.2)
    size = study.points * bytes_per_point(study)
    with_room = Store.open(tmp_path, quota=Quota(bytes=2 * size - 1))
    record = enter(with_room, study)
    assert with_room.usage() == Usage(study.points, size)
    with pytest.raises(QuotaReached, match=f"{size:,} bytes.*{size - 1:,} bytes.*damperlab delete"):
        enter(with_room, other)
    assert [found.id for found in with_room.page().records] == [record.id]
    assert len(list((tmp_path / "cubes").glob("*.zarr"))) == 1
    assert with_room.submit(study, make_plan_of(study), {})[0] == record  # what is there is never refused
    with_room.delete(record.id)
    with_room.bury()
    assert with_room.usage() == Usage(0, 0)
    assert with_room.submit(other, make_plan_of(other), {})[1]
    with_room.close()


def test_owners_are_counted_each_for_itself(tmp_path: Path) -> None:
    first, second, third = (make_study(damping_ratio=each) for each in (0.1, 0.2, 0.3))
    each = Quota(points=2 * first.points, unfinished=1, setting="key_quota")
    store = Store.open(tmp_path, quota=Quota(of_owner=each))

    def submit(study, who: str | None):
        token = submitter.set(who)
        try:
            return store.submit(study, make_plan_of(study), {"note": '"submitted_by": "ann"'})[0]
        finally:
            submitter.reset(token)

    submit(first, 'an"n%')
    with pytest.raises(TooManyUnfinished, match="key_quota_unfinished"):
        submit(second, 'an"n%')
    submit(second, "ann")
    store.set_state(second.digest[:12], "cancelled")
    submit(third, "ann")
    with pytest.raises(QuotaReached, match="key_quota_points"):
        submit(make_study(damping_ratio=0.4), "ann")
    for damping in (0.5, 0.6, 0.7):
        submit(make_study(damping_ratio=damping), None)
    store.close()


def test_a_tombstone_counts_until_its_files_are_gone(tmp_path: Path) -> None:
    store = Store.open(tmp_path)
    study = make_study()
    record = enter(store, study)
    store.delete(record.id)
    assert store.usage().points == study.points
    store.bury()
    assert store.usage().points == 0
    store.close()
