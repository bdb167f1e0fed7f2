"""The queue of a service beside users who change their minds faster than a run begins or ends."""

import threading
import time
from asyncio import CancelledError
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing, contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from distributed import Client
from tests.worker.run_here import linear_study, submit

from damperlab.service.cluster import SharedCluster
from damperlab.service.dispatch import Dispatcher
from damperlab.studies.store.faults import StoreFault
from damperlab.studies.store.provenance import submitter
from damperlab.studies.store.record import Record
from damperlab.studies.store.store import Store
from damperlab.worker.cluster.cluster import connect

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


def until(true: Callable[[], bool]) -> None:
    give_up = time.monotonic() + GIVE_UP_SECONDS
    while not true():
        assert time.monotonic() < give_up
        time.sleep(0.05)


def ended(store: Store, study_id: str) -> Record:
    until(lambda: store.find(study_id).ended)
    return store.find(study_id)


@pytest.mark.parametrize("resumed", [False, True])
def test_a_study_that_was_cancelled_while_its_run_began_is_computed_only_where_it_was_resumed(
    store: Store, gate: tuple[Dispatcher, Gate], resumed: bool
) -> None:
    dispatcher, cluster = gate
    record = submit(store, linear_study([0.8, 1.0, 1.2]), None)
    dispatcher.wake()
    assert cluster.asked.wait(GIVE_UP_SECONDS)
    assert dispatcher.cancel(record).state == "cancelled"
    if resumed:
        assert dispatcher.resume(record).state == "queued"
    cluster.open.set()
    until(lambda: not dispatcher.running and store.find(record.id).ended)
    assert store.find(record.id).state == ("done" if resumed else "cancelled")
    told = [what for _, what in store.events(record.id)]
    assert told[:2] == ["submitted", "queued to cancelled"]
    assert len(told) == 2 or resumed
    assert told.count("queued to cancelled") == 1
    assert "running to cancelled" not in told


class Broken(SharedCluster):
    """A cluster that cannot be had."""

    def __init__(self, error: BaseException) -> None:
        super().__init__(partial(connect, workers=1))
        self.error = error

    @contextmanager
    def borrow(self) -> Iterator[Client]:
        raise self.error
        yield


def test_those_who_submit_take_turns_however_many_studies_one_of_them_has(store: Store) -> None:
    def submit_as(owner: str, damping_ratio: float) -> str:
        token = submitter.set(owner)
        try:
            # too many points for the small ones that run together
            return submit(store, linear_study(np.linspace(0.8, 1.2, 40).tolist(), damping_ratio), None).id
        finally:
            submitter.reset(token)

    anns = [submit_as("ann", 0.01 + 0.001 * k) for k in range(5)]
    bobs = [submit_as("bob", 0.05 + 0.001 * k) for k in range(2)]
    # one of each is looked for, though ann's five are older
    assert [one.id for one in store.unclaimed(lambda owner: False, 1)] == [anns[0], bobs[0]]
    dispatcher = Dispatcher(store, store, Broken(ValueError("a defect")), 1)
    dispatcher.start()
    try:
        came = {name: ended(store, name).finished for name in (*anns, *bobs)}
    finally:
        dispatcher.close()
    order = sorted(came, key=lambda name: came[name] or 0.0)
    assert order == [anns[0], bobs[0], anns[1], bobs[1], *anns[2:]]


@pytest.mark.parametrize("error", [SystemExit(1), CancelledError(), MemoryError(), ValueError("a defect")])
def test_a_run_that_ends_oddly_leaves_no_study_waiting_for_ever(
    store: Store, monkeypatch: pytest.MonkeyPatch, error: BaseException
) -> None:
    monkeypatch.setattr("damperlab.service.dispatch.AGAIN_SECONDS", 0.1)
    locked = [StoreFault("catalogue", "database is locked", "allowed", "advice")]
    set_state = store.set_state

    def set_state_at_last(study_id: str, state: str, *rest: Any, **named: Any) -> Record:
        # that the study has failed cannot be written at first
        if state == "failed" and locked:
            raise locked.pop()
        return set_state(study_id, state, *rest, **named)

    monkeypatch.setattr(store, "set_state", set_state_at_last)
    record = submit(store, linear_study([0.8, 1.0, 1.2]), None)
    dispatcher = Dispatcher(store, store, Broken(error), 1)
    dispatcher.start()
    try:
        end = ended(store, record.id)
    finally:
        dispatcher.close()
    assert end.state == "failed"
    assert not locked
    assert type(error).__name__ in str(end.message)


def test_cancelling_holds_no_lock_while_the_store_writes(
    store: Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    dispatcher = Dispatcher(store, store, SharedCluster(partial(connect, workers=1)), 1)
    record = submit(store, linear_study([0.8, 1.0, 1.2]), None)
    set_state, writes, written = store.set_state, threading.Event(), threading.Event()

    def set_state_slowly(*given: Any, **named: Any) -> Record:
        writes.set()
        assert written.wait(GIVE_UP_SECONDS)
        return set_state(*given, **named)

    monkeypatch.setattr(store, "set_state", set_state_slowly)
    with ThreadPoolExecutor(1) as threads:
        cancelled = threads.submit(dispatcher.cancel, record)
        assert writes.wait(GIVE_UP_SECONDS)
        assert dispatcher._lock.acquire(blocking=False)
        dispatcher._lock.release()
        written.set()
        assert cancelled.result().state == "cancelled"
