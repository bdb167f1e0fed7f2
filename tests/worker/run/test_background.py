"""A background thread goes on after every exception of its work, and reports it."""

import asyncio
import ctypes
import threading
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest
from sqlalchemy.exc import TimeoutError as PoolTimeout
from tests.worker.run_here import linear_study, submit

from damperlab.studies.store.faults import StoreFault
from damperlab.studies.store.store import Store
from damperlab.worker.run.background import Background
from damperlab.worker.run.lease import Lease, hold

GIVE_UP_SECONDS = 300.0


class Mute(Exception):
    """An exception that cannot even be printed."""

    def __str__(self) -> str:
        raise ValueError("nothing to say")


ODD = [
    ValueError("a defect"),
    OSError(28, "No space left on device"),
    MemoryError(),
    RecursionError("too deep"),
    StoreFault("catalogue", "found", "allowed", "advice", "The catalogue is away."),
    PoolTimeout("QueuePool limit reached"),
    SystemExit(1),
    KeyboardInterrupt(),
    GeneratorExit(),
    asyncio.CancelledError(),
    Mute(),
]


class Work:
    """Raises once for each exception, and then does well."""

    def __init__(self, *errors: BaseException) -> None:
        self.errors = list(errors)
        self.well = threading.Event()

    def __call__(self) -> None:
        if self.errors:
            raise self.errors.pop(0)
        self.well.set()


@pytest.fixture
def begun() -> Iterator[list[Background]]:
    backgrounds: list[Background] = []
    yield backgrounds
    for background in backgrounds:
        background.close()


@pytest.mark.parametrize("error", ODD, ids=lambda error: type(error).__name__)
def test_no_exception_ends_the_rounds(
    error: BaseException, begun: list[Background], caplog: pytest.LogCaptureFixture
) -> None:
    work = Work(error, error)
    background = Background("test", work, 0.01)
    begun.append(background)
    background.start()
    assert work.well.wait(GIVE_UP_SECONDS)
    background.close()
    assert background.trouble is None
    assert background.failures == 2
    # a catalogue that does not answer is no defect of the service
    level = "WARNING" if isinstance(error, StoreFault) else "ERROR"
    assert {record.levelname for record in caplog.records} == (set() if isinstance(error, Mute) else {level})


def test_a_failed_round_is_told_until_the_next_one_ends_well(begun: list[Background]) -> None:
    gate = threading.Event()
    rounds = iter([ValueError("a defect")])

    def work() -> None:
        if (error := next(rounds, None)) is not None:
            raise error
        gate.wait(GIVE_UP_SECONDS)

    background = Background("test", work, 0.01)
    begun.append(background)
    background.start()
    while background.trouble is None:
        gate.wait(0.01)
    assert background.trouble == "ValueError: a defect"
    gate.set()
    while background.trouble is not None:
        threading.Event().wait(0.01)
    assert background.failures == 1


def test_an_exception_from_another_thread_ends_no_round_for_good(begun: list[Background]) -> None:
    work = Work()
    background = Background("test", work, 0.01)
    begun.append(background)
    background.start()
    for _ in range(20):
        assert work.well.wait(GIVE_UP_SECONDS)
        ident = background._thread.ident
        assert ident is not None
        ctypes.pythonapi.PyThreadState_SetAsyncExc(ctypes.c_ulong(ident), ctypes.py_object(SystemExit))
        work.well.clear()
    assert work.well.wait(GIVE_UP_SECONDS)
    assert background._thread.is_alive()


def test_a_thread_that_has_ended_is_told() -> None:
    background = Background("test", lambda: None, 0.01, lambda: False)
    background.start()
    background._thread.join(GIVE_UP_SECONDS)
    assert background.trouble == "its thread has ended"


@pytest.mark.parametrize(
    "error", [ValueError("a defect"), SystemExit(1)], ids=lambda error: type(error).__name__
)
def test_a_claim_is_renewed_whatever_one_renewal_raises(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, error: BaseException
) -> None:
    monkeypatch.setattr("damperlab.worker.run.lease.RENEW_SECONDS", 0.01)
    with closing(Store.open(tmp_path)) as store:
        record = submit(store, linear_study([0.8, 1.0]), None)
        renew, errors, renewed = store.renew, [error], threading.Event()

        def renew_at_last(study_id: str, owner: str) -> bool:
            if errors:
                raise errors.pop()
            renewed.set()
            return renew(study_id, owner)

        monkeypatch.setattr(store, "renew", renew_at_last)
        with hold(store, record.id) as lease:
            assert renewed.wait(GIVE_UP_SECONDS)
            assert lease.renewing.failures == 1
            assert not lease.over


def test_a_claim_is_renewed_no_longer_than_its_runner_lives(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("damperlab.worker.run.lease.RENEW_SECONDS", 0.01)
    with closing(Store.open(tmp_path)) as store:
        record = submit(store, linear_study([0.8, 1.0]), None)
        begun: list[Background] = []

        def run() -> None:
            lease = Lease(store, record.id)
            lease.renewing.start()
            begun.append(lease.renewing)

        runner = threading.Thread(target=run)
        runner.start()
        runner.join(GIVE_UP_SECONDS)
        begun[0]._thread.join(GIVE_UP_SECONDS)
        assert not begun[0]._thread.is_alive()
