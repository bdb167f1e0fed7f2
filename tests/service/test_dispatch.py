"""The queue of a service beside users who change their minds faster than a run begins or ends."""

import threading
import time
from collections.abc import Iterator
from contextlib import closing, contextmanager
from functools import partial
from pathlib import Path

import pytest
from distributed import Client

from damperlab.service.cluster import SharedCluster
from damperlab.service.dispatch import Dispatcher
from damperlab.studies.definition import parse_study
from damperlab.studies.plan import make_plan
from damperlab.studies.store.record import Record
from damperlab.studies.store.store import Store
from damperlab.studies.store.submitter import submitter
from damperlab.worker.cluster.cluster import connect
from damperlab.worker.dispatch.cost_model import seconds_per_point
from damperlab.worker.provenance import provenance

GIVE_UP_SECONDS = 300.0


class Gate(SharedCluster):
    """A cluster that is lent once the gate is open."""

    def __init__(self) -> None:
        super().__init__(partial(connect, workers=1))
        self.asked = threading.Event()
        self.open = threading.Event()

    @contextmanager
    def borrow(self) -> Iterator[Client]:
        self.asked.set()
        assert self.open.wait(GIVE_UP_SECONDS)
        with super().borrow() as client:
            yield client


@pytest.fixture
def store(tmp_path: Path) -> Iterator[Store]:
    with closing(Store.open(tmp_path / "data")) as store:
        yield store


@pytest.fixture
def gate(store: Store) -> Iterator[tuple[Dispatcher, Gate]]:
    gate = Gate()
    dispatcher = Dispatcher(store, store, gate, 1)
    dispatcher.start()
    yield dispatcher, gate
    gate.open.set()
    dispatcher.close()


def submitted(store: Store) -> Record:
    study = parse_study(
        {
            "damping_ratio": 0.05,
            "axes": {"friction_ratio": 0, "frequency_ratio": [0.8, 1.0, 1.2]},
            "particle": False,
        }
    )
    return store.submit(study, make_plan(study, seconds_per_point), provenance())[0]


def ended(store: Store, study_id: str) -> Record:
    give_up = time.monotonic() + GIVE_UP_SECONDS
    while not (record := store.find(study_id)).ended:
        assert time.monotonic() < give_up, record
        time.sleep(0.05)
    return record


def test_a_study_that_was_cancelled_and_resumed_while_its_run_began_is_computed(
    store: Store, gate: tuple[Dispatcher, Gate]
) -> None:
    dispatcher, cluster = gate
    record = submitted(store)
    dispatcher.wake()
    assert cluster.asked.wait(GIVE_UP_SECONDS)
    assert dispatcher.cancel(record).state == "cancelled"
    assert dispatcher.resume(record).state == "queued"
    cluster.open.set()
    assert ended(store, record.id).state == "done"
    assert [what for _, what in store.events(record.id)].count("queued to cancelled") == 1
    assert "running to cancelled" not in [what for _, what in store.events(record.id)]


def test_a_study_that_was_cancelled_while_its_run_began_never_runs(
    store: Store, gate: tuple[Dispatcher, Gate]
) -> None:
    dispatcher, cluster = gate
    record = submitted(store)
    dispatcher.wake()
    assert cluster.asked.wait(GIVE_UP_SECONDS)
    dispatcher.cancel(record)
    cluster.open.set()
    give_up = time.monotonic() + GIVE_UP_SECONDS
    while dispatcher.running:
        assert time.monotonic() < give_up
        time.sleep(0.05)
    assert store.find(record.id).state == "cancelled"
    assert [what for _, what in store.events(record.id)] == ["submitted", "queued to cancelled"]


def test_study_of_the_highest_priority_begins_first_whoever_has_waited_longer(store: Store) -> None:
    def submit(place: int, priority: int) -> str:
        axes = {"friction_ratio": 0, "frequency_ratio": {"start": 0.8, "stop": 1.2, "num": 40}}
        study = parse_study({"damping_ratio": 0.01 + 0.001 * place, "axes": axes, "particle": False})
        plan = make_plan(study, seconds_per_point)
        return store.submit(study, plan, provenance(), priority=priority)[0].id

    priorities = (0, -1, 5, 0)
    ids = [submit(place, priority) for place, priority in enumerate(priorities)]
    dispatcher = Dispatcher(store, store, SharedCluster(partial(connect, workers=1)), 1)
    dispatcher.start()
    try:
        began = {name: ended(store, name).started or 0.0 for name in ids}
    finally:
        dispatcher.close()
    assert sorted(ids, key=lambda name: began[name]) == [ids[2], ids[0], ids[3], ids[1]]


def test_those_who_submit_take_turns_however_many_studies_one_of_them_has(store: Store) -> None:
    def submit(owner: str, damping_ratio: float) -> str:
        # too many points for the small ones that run together
        axes = {"friction_ratio": 0, "frequency_ratio": {"start": 0.8, "stop": 1.2, "num": 40}}
        study = parse_study({"damping_ratio": damping_ratio, "axes": axes, "particle": False})
        token = submitter.set(owner)
        try:
            return store.submit(study, make_plan(study, seconds_per_point), provenance())[0].id
        finally:
            submitter.reset(token)

    anns = [submit("ann", 0.01 + 0.001 * k) for k in range(5)]
    bobs = [submit("bob", 0.05 + 0.001 * k) for k in range(2)]
    # one of each is looked for, though ann's five are older
    assert [one.id for one in store.unclaimed(lambda owner: False, 1)] == [anns[0], bobs[0]]
    cluster = SharedCluster(partial(connect, workers=1))
    dispatcher = Dispatcher(store, store, cluster, 1)
    dispatcher.start()
    try:
        began = {name: ended(store, name).started for name in (*anns, *bobs)}
    finally:
        dispatcher.close()
    order = sorted(began, key=lambda name: began[name] or 0.0)
    assert order == [anns[0], bobs[0], anns[1], bobs[1], *anns[2:]]
