"""Studies that come at once: each entered once, in shared transactions, and what is refused is refused alone."""

import threading
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from tests.filling import make_plan_of, make_study, write_behind

from damperlab.studies.store.care.verify import check_catalogue, verify
from damperlab.studies.store.catalogue.batches import Batches
from damperlab.studies.store.catalogue.quota import Quota
from damperlab.studies.store.faults import CatalogueDamaged, KeyTaken, QuotaReached
from damperlab.studies.store.life_cycle.entering import Submission
from damperlab.studies.store.store import Store

THREADS = 12


@pytest.fixture
def submission():
    def make(number: int, key: str | None = None) -> Submission:
        study = make_study(f"study {number}", damping_ratio=0.01 * (1 + number))
        return Submission(study, make_plan_of(study).chunk, {"kernels": "k"}, key=key)

    return make


def test_studies_of_many_threads_are_each_entered_once(store, submission):
    with ThreadPoolExecutor(THREADS) as pool:
        ends = list(pool.map(lambda number: store.submit_all([submission(number % 10)])[0], range(60)))
    assert sum(created for _, created in ends) == 10
    assert len({record.id for record, _ in ends}) == 10
    assert list(check_catalogue(store)) == []
    for record in store.page(limit=100).records:
        assert list(verify(store, record)) == []
        assert store.events(record.id)[0][1] == "submitted"


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


def test_a_key_that_stands_for_another_definition_refuses_its_list_alone(store, submission):
    taken, other, same = store._submit_lists(
        [[submission(0, "k")], [submission(1, "k")], [submission(0, "k")]]
    )
    assert isinstance(other, KeyTaken)
    assert (taken[0][1], same[0][1]) == (True, False)
    assert len(store.page().records) == 1


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
