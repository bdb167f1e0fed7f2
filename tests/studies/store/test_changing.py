"""What reads several files of a study beside what changes it: between any two touches of a file, nothing looks damaged."""

import multiprocessing
import shutil
from collections.abc import Callable, Iterator
from contextlib import closing
from functools import partial
from itertools import count
from pathlib import Path

import pytest
from starlette.requests import Request
from tests.filling import enter, make_plan_of, make_study, put, values_of, write
from tests.studies.store.racing import Watched, die_at

from damperlab.service.problems import Problem
from damperlab.service.questions.question import Subject
from damperlab.service.questions.resonance_map import RESONANCE_MAP
from damperlab.service.routes import zarr
from damperlab.service.work.apart import steady
from damperlab.studies.definition import Study
from damperlab.studies.questions import Plane, Selection, Subtracted, Window
from damperlab.studies.remarks import Remarks
from damperlab.studies.store.care.sweep import collect_garbage
from damperlab.studies.store.care.verify import check_catalogue, verify
from damperlab.studies.store.faults import StudyNotFound
from damperlab.studies.store.life_cycle.manifest import read_marks
from damperlab.studies.store.solver import solver
from damperlab.studies.store.store import Store

CHUNK = (1, 1, 1, 2, 3, 4)
"""Three blocks."""
DONE = make_study("done", metrics=["amplitude_ratio"])
BEGUN = make_study("begun", damping_ratio=0.2, metrics=["amplitude_ratio"])
SCOPE = {"type": "http", "headers": []}
DONE_ID, BEGUN_ID = DONE.digest[:12], BEGUN.digest[:12]


@pytest.fixture(scope="module")
def made(tmp_path_factory) -> Path:
    """A study that is done with a block that was given up, and one that was cancelled after a block."""
    store = Store.open(tmp_path_factory.mktemp("made") / "data")
    for study, blocks in ((DONE, (1, 2)), (BEGUN, (0,))):
        enter(store, study, CHUNK, identity="one", solver=solver())
        put(store, study, *blocks, generation="first")
    block = make_plan_of(DONE, CHUNK).block(0)
    told = {"message": "its worker died"}
    write(store, DONE_ID, block, values_of(DONE, block), "given-up", told)
    store.set_state(DONE_ID, "done")
    store.set_state(BEGUN_ID, "cancelled")
    store.close()
    return store.data_dir


def again(store: Store, study: Study) -> None:
    """Compute what a study lacks and end the study, as a runner does, and remove what was superseded."""
    study_id = study.digest[:12]
    assert store.claim(study_id, "runner")
    store.set_state(study_id, "running", owner="runner")
    put(store, study, *map(int, store.pending(study_id)), generation="again")
    store.set_state(study_id, "done", owner="runner")
    store.release(study_id, "runner")
    collect_garbage(store, 0.0, orphan_seconds=0.0)


def retry(store: Store) -> None:
    store.retry(DONE_ID)
    again(store, DONE)


def repair_all(store: Store) -> None:
    """As after damage to every block; and another solver computes them."""
    store.forget(DONE_ID, [0, 1, 2], "by hand")
    store.begin(DONE_ID, {"identity": "two"})
    again(store, DONE)


def resume(store: Store) -> None:
    store.set_state(BEGUN_ID, "queued")
    again(store, BEGUN)


def cancel_again(store: Store) -> None:
    store.set_state(BEGUN_ID, "queued")
    store.set_state(BEGUN_ID, "cancelled")


def delete(store: Store) -> None:
    store.delete(DONE_ID)
    store.bury()


def submit_again(store: Store) -> None:
    delete(store)
    enter(store, DONE, CHUNK, identity="two")
    again(store, DONE)


def restore(store: Store) -> None:
    store.delete(DONE_ID, keep_seconds=600.0)
    store.undelete(DONE_ID)


def recompute(store: Store) -> None:
    store.recompute(BEGUN_ID, {"identity": "two"})


def remark(store: Store) -> None:
    store.remark(DONE_ID, Remarks(("steel",), "n", "renamed"))


NIGHT = [
    pytest.param(change, marks=pytest.mark.night)
    for change in (submit_again, repair_all, resume, cancel_again, delete, restore, recompute, remark)
]


def damage(store: Store) -> list[str]:
    """Everything that is called damaged. A study that is deleted meanwhile is not."""
    found = list(check_catalogue(store))
    for record in store.page().records:
        try:
            found += [f"{record.name}: {one.found}" for one in verify(store, record)]
        except StudyNotFound:
            continue
    return found


def meanwhile(
    made: Path, folder: Path, what: Callable[[Store], object], other: Callable[[Store], object]
) -> Iterator[tuple[object, list[object]]]:
    """Do `what` again and again, each time with `other` before another touch of a file, until there are no more touches."""
    for touch in count():
        data = shutil.copytree(made, folder / str(touch))
        with closing(Store.open(data)) as store:
            beside = Store(data, store.catalogue, store.shelf, store.quota)
            before = Before(touch, partial(other, beside))
            shelf = Watched(store.shelf.address)
            shelf.catalogue, shelf.before = store.catalogue, before
            store.shelf = shelf
            yield what(store), before.answers
            if not before.answers:
                assert touch
                return
            assert damage(beside) == []
        shutil.rmtree(data)


class Before:
    """Does something before one touch of a file."""

    def __init__(self, touch: int, other: Callable[[], object]) -> None:
        self._left = touch
        self._other = other
        self.answers: list[object] = []

    def __call__(self, name: str) -> None:
        self._left -= 1
        if self._left == -1:
            self.answers.append(self._other())


@pytest.mark.parametrize("change", [retry, *NIGHT])
def test_a_study_that_is_changed_while_it_is_verified_is_not_called_damaged(made, tmp_path, change):
    for found, _ in meanwhile(made, tmp_path, damage, change):
        assert found == []


@pytest.mark.parametrize("change", [retry, *NIGHT])
def test_a_study_that_is_verified_while_it_is_changed_is_not_called_damaged(made, tmp_path, change):
    for _, found in meanwhile(made, tmp_path, change, damage):
        assert found in ([], [[]])


@pytest.mark.parametrize("change", [retry, *NIGHT])
def test_a_study_that_is_changed_while_it_is_exported_or_sent_is_not_called_damaged(made, tmp_path, change):
    """A chunk of several blocks over HTTP; a study that changed or was deleted may be refused, saying so."""

    def read(store: Store) -> list[int]:
        try:
            record = store.find(DONE_ID)
            steady(store, record, lambda there, now: there.cube(now.id).load())
            answer = zarr._read(store, record, None, "amplitude_ratio/0.0.0.0.0.0", Request(SCOPE))
        except StudyNotFound:
            return [404]
        except Problem as problem:
            return [problem.status]
        return [answer.status_code]

    for found, _ in meanwhile(made, tmp_path, read, change):
        assert found in ([200], [404], [409])


def test_a_second_study_that_is_changed_while_two_maps_are_compared_is_read_again(made, tmp_path):
    axes = Plane(x="clearance_ratio", y="friction_ratio")

    def compare(store: Store) -> tuple[str, ...]:
        subject = Subject(store.find(BEGUN_ID), store, RESONANCE_MAP.command)
        found = RESONANCE_MAP.of(subject, axes, Selection(), Subtracted(minus=DONE_ID), Window())
        return tuple(found.attrs["studies"])

    for found, _ in meanwhile(made, tmp_path, compare, retry):
        assert found == (BEGUN_ID, DONE_ID)


def test_a_retry_that_is_killed_leaves_nothing_that_looks_damaged_and_the_list_is_written_again(copied):
    """Its list of marks is gone, and its blocks are not invalidated."""
    before = read_marks(copied.find_cube(DONE_ID))
    process = multiprocessing.get_context("spawn").Process(
        target=die_at, args=("_take_back", retry, copied.data_dir)
    )
    process.start()
    process.join()
    assert process.exitcode == -9
    assert read_marks(copied.find_cube(DONE_ID)) is None
    assert damage(copied) == []
    copied.keep_late_marks()
    assert read_marks(copied.find_cube(DONE_ID)) == before
    retry(copied)
    assert damage(copied) == []
