"""Studies that come at once, each entered once; quotas; and studies that are deleted for a while, and restored."""

import threading
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from tests.filling import enter, make_plan_of, make_study, write_behind

from damperlab.studies.store.care.sweep import collect_garbage
from damperlab.studies.store.care.verify import verify
from damperlab.studies.store.catalogue.batches import Batches
from damperlab.studies.store.catalogue.quota import Quota, Usage
from damperlab.studies.store.cube.description import bytes_per_point
from damperlab.studies.store.faults import (
    CatalogueDamaged,
    NothingToDo,
    QuotaReached,
    StudyNotFound,
    TooManyUnfinished,
)
from damperlab.studies.store.files.shelf import TOMBSTONE
from damperlab.studies.store.life_cycle.entering import Submission
from damperlab.studies.store.life_cycle.lookup import Wanted
from damperlab.studies.store.provenance import submitter
from damperlab.studies.store.store import Store


@pytest.fixture
def submission():
    def make(number: int) -> Submission:
        study = make_study(f"study {number}", damping_ratio=0.01 * (1 + number))
        return Submission(study, make_plan_of(study).chunk, {"kernels": "k"})

    return make


def test_a_list_is_entered_in_its_order_and_names_what_it_holds_twice(store, submission):
    first = store.submit_all([submission(3)])[0][0]
    ends = store.submit_all([submission(number) for number in (5, 3, 5, 1)])
    assert [record.name for record, _ in ends] == [f"study {number}" for number in (5, 3, 5, 1)]
    assert [created for _, created in ends] == [True, False, False, True]
    assert ends[1][0].id == first.id
    # the newest of a list is its last
    assert [record.name for record in store.page().records] == ["study 1", "study 5", "study 3"]


def test_a_list_beyond_the_quota_leaves_nothing_and_the_others_alone(store, submission):
    points = submission(0).study.points
    limited = Store.open(store.data_dir, quota=Quota(points=4 * points))
    outcomes = limited._submit_lists(
        [[submission(0), submission(1)], [submission(2), submission(3), submission(4)], [submission(2)]]
    )
    assert isinstance(outcomes[1], QuotaReached)
    assert f"quota_points` does not suffice: the study would take {3 * points} points" in str(outcomes[1])
    assert [len(end) for end in (outcomes[0], outcomes[2])] == [2, 1]
    assert {record.name for record in limited.page().records} == {"study 0", "study 1", "study 2"}
    assert len([path for path in (store.data_dir / "cubes").iterdir() if path.suffix == ".zarr"]) == 3
    limited.close()


def test_a_damaged_row_refuses_who_asks_for_it_alone(store, submission):
    study_id = store.submit_all([submission(0)])[0][0].id
    write_behind(store.data_dir, "UPDATE studies SET name = 'another'")
    ours, other = store._submit_lists([[submission(0)], [submission(1)]])
    assert isinstance(ours, CatalogueDamaged)
    assert study_id in str(ours)
    assert other[0][1]


def test_a_cube_that_cannot_be_written_leaves_none_of_its_turn(store, submission):
    store.submit_all([submission(0)])
    cubes = store.data_dir / "cubes"
    # a file where the second cube's folder would be
    (cubes / f"{submission(2).study.digest[:12]}-3.zarr").write_text("in the way")
    with pytest.raises(Exception, match="cubes"):
        store.submit_all([submission(1), submission(2)])
    assert [record.name for record in store.page().records] == ["study 0"]
    assert [path.name for path in cubes.iterdir() if path.is_dir()] == [
        Path(store.cube_path(store.find("study 0").id)).name
    ]


def test_turns_answer_everybody_whatever_comes_of_one(store):
    done: list[list[int]] = []
    gate = threading.Event()

    def work(asked):
        gate.wait(60)
        done.append(list(asked))
        if 13 in asked:
            raise ValueError("thirteen")
        return [number if number % 2 else KeyError(number) for number in asked]

    batches = Batches[int, int](work, 4)

    def ask(number: int) -> object:
        try:
            return batches.ask(number)
        except (KeyError, ValueError) as error:
            return type(error)

    with ThreadPoolExecutor(20) as pool:
        answers = pool.map(ask, range(20))
        gate.set()
        found = dict(zip(range(20), answers, strict=True))
    unlucky = next(some for some in done if 13 in some)
    assert sorted(number for some in done for number in some) == list(range(20))
    assert max(map(len, done)) <= 4
    for number, answer in found.items():
        assert answer == (ValueError if number in unlucky else number if number % 2 else KeyError)


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
    assert with_room.usage().points == study.points  # until its files are gone
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


WEEK = 7 * 86_400.0


def ids(store, **wanted):
    return [record.id for record in store.page(wanted=Wanted(**wanted)).records]


def test_a_study_is_taken_back_from_the_trash_as_it_was(store):
    record = enter(store, make_study())
    store.delete(record.id, WEEK)
    assert (ids(store), ids(store, trash=True)) == ([], [record.id])
    with pytest.raises(StudyNotFound, match="in the trash until"):
        store.find(record.id)
    with pytest.raises(StudyNotFound, match=f"in the trash until .* `damperlab undelete {record.id}`"):
        store.find(record.name)
    store.bury()  # what may still be restored stays
    assert collect_garbage(store, 0.0).paths == 0
    assert store.trashed(record.id).name == record.name
    assert store.undelete(record.id) == record
    assert (ids(store), ids(store, trash=True)) == ([record.id], [])
    # and nothing beside its blocks says that it was deleted
    assert TOMBSTONE not in {entry.key for entry in store.cube_shelf(record.id, 1).entries()}
    assert list(verify(store, record)) == []
    store.bury()
    assert store.find(record.id) == record
    with pytest.raises(StudyNotFound):
        store.undelete(record.id)


def test_what_is_deleted_for_good_or_was_submitted_again_is_not_taken_back(store):
    record = enter(store, make_study())
    store.delete(record.id)
    with pytest.raises(StudyNotFound):
        store.undelete(record.id)
    again = enter(store, make_study())
    store.delete(again.id, WEEK)
    enter(store, make_study())
    with pytest.raises(NothingToDo):
        store.undelete(again.id)
