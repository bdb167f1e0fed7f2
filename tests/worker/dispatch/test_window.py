"""The bounded window on real worker processes: blocks that fail, workers that die, work that is stopped."""

import asyncio
import errno
import os
import signal
import time
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

import pytest
from distributed import Client, get_worker
from distributed.core import Status
from distributed.nanny import WorkerProcess

from damperlab.studies.store.record import BlockOutcome
from damperlab.worker.cluster.cluster import connect
from damperlab.worker.dispatch.window import WAIT_SECONDS, Window
from damperlab.worker.dispatch.workers import BLOCKS_PER_THREAD
from damperlab.worker.outcomes import RETRIES, Failure, Outage
from damperlab.worker.provenance import require_code


def _outcome(index: int) -> BlockOutcome:
    return BlockOutcome(index, points=1, failed=0, seconds=0.0, kernel_seconds=0.0)


@pytest.fixture(scope="module")
def client() -> Iterator[Client]:
    with connect(workers=2) as client:
        yield client


def window_of(
    client: Client, task: Callable[[int], BlockOutcome], count: int, wait_seconds: float = WAIT_SECONDS
) -> Window:
    return Window(client, lambda index, key: (task, index), range(count), wait_seconds=wait_seconds)


def in_order(ended: list[BlockOutcome | Failure]) -> list[BlockOutcome | Failure]:
    return sorted(ended, key=lambda each: each.index)


def pump(window: Window, seconds: float = 900.0) -> list[BlockOutcome | Failure]:
    ended: list[BlockOutcome | Failure] = []
    deadline = time.monotonic() + seconds
    window.fill()
    while not window.empty:
        assert time.monotonic() < deadline, f"only {len(ended)} blocks ended"
        ended.extend(window.collect(0.2))
        window.fill()
    return ended


def test_block_that_fails_too_often_is_given_up_and_the_rest_goes_on(client: Client, tmp_path: Path) -> None:
    """The third always fails, the fourth as often as it may."""

    def task(index: int) -> BlockOutcome:
        tries = tmp_path / f"{index}"
        with tries.open("a") as file:
            file.write("x")
        if index == 3 or (index == 4 and len(tries.read_text()) <= RETRIES):
            raise ZeroDivisionError(f"in {index}")
        return _outcome(index)

    ended = pump(window_of(client, task, 12))
    assert in_order(ended) == [
        Failure(3, "ZeroDivisionError: in 3") if index == 3 else _outcome(index) for index in range(12)
    ]
    assert [len((tmp_path / f"{index}").read_text()) for index in (3, 4, 5)] == [1 + RETRIES, 1 + RETRIES, 1]


def test_block_that_kills_its_worker_is_given_up_and_its_neighbours_are_not(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    # each death costs the start of a process
    monkeypatch.setattr("damperlab.worker.dispatch.workers.RETRIES", 1)

    def task(index: int) -> BlockOutcome:
        if index == 0:
            os.kill(os.getpid(), signal.SIGKILL)
        time.sleep(0.05)
        return _outcome(index)

    # On one worker the killer always has neighbours waiting behind it, which die with it.
    with connect(workers=1) as client:
        ended = pump(window_of(client, task, 16))
    failures = [failure for failure in ended if isinstance(failure, Failure)]
    assert [failure.index for failure in failures] == [0]
    assert "its process died 2 times (ended by SIGKILL" in failures[0].message
    assert sorted(each.index for each in ended) == list(range(16))


@pytest.mark.parametrize(
    ("error", "words"),
    [
        (
            PermissionError(13, "Permission denied", "cube"),
            r"none of the 2 workers can compute: .* left out: .*Permission denied",
        ),
        (
            OSError(errno.ENOSPC, "No space left on device", "cube"),
            r"no room for the study's data .*No space left",
        ),
    ],
    ids=["refused", "full disk"],
)
def test_data_that_cannot_be_written_anywhere_stops_the_study_instead_of_failing_points(
    client: Client, error: OSError, words: str
) -> None:
    def task(index: int) -> BlockOutcome:
        raise error

    client.wait_for_workers(2)  # one that an earlier test ended comes back
    window = window_of(client, task, 3, wait_seconds=1.0)
    with pytest.raises(Outage, match=words):
        pump(window)
    window.close()


def fails(error: Exception) -> None:
    raise error


@pytest.mark.parametrize(
    ("trouble", "most", "reason"),
    [
        # what had been sent there already is refused too, and nothing more is sent
        (partial(require_code, "0" * 64), BLOCKS_PER_THREAD, "holds damperlab"),
        (partial(fails, RuntimeError("broken memory")), 30, "broken memory"),
        (
            partial(fails, OSError(errno.ENOSPC, "No space left on device", "cube")),
            30,
            "there is no room for the study's data",
        ),
    ],
    ids=["other code", "broken memory", "full disk"],
)
def test_worker_at_which_blocks_fail_that_others_compute_is_left_out(
    client: Client, tmp_path: Path, trouble: Callable[[], None], most: int, reason: str
) -> None:
    client.wait_for_workers(2)
    broken = min(client.nthreads())

    def task(index: int) -> BlockOutcome:
        if get_worker().address == broken:
            (tmp_path / f"{time.monotonic_ns()}").touch()
            trouble()
        time.sleep(0.01)
        return _outcome(index)

    window = window_of(client, task, 30)
    assert in_order(pump(window)) == [_outcome(index) for index in range(30)]
    (out,) = window.workers.left_out()
    assert out.address == broken
    assert reason in out.reason
    assert 1 <= len(list(tmp_path.iterdir())) <= most


def assert_comes_back(began: Path) -> None:
    """Assert that a worker whose first block ends it computes the block after its restart."""

    def task(index: int) -> BlockOutcome:
        try:
            began.touch(exist_ok=False)
        except FileExistsError:
            return _outcome(index)
        os.kill(os.getpid(), signal.SIGKILL)
        raise AssertionError

    with connect(workers=1) as client:
        assert pump(window_of(client, task, 1)) == [_outcome(0)]


@pytest.mark.night
def test_worker_whose_first_block_ends_it_is_started_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """However late the process that watches it has learnt that it runs."""
    monkeypatch.setattr(WorkerProcess, "_init_msg_interval", 2.0)
    assert_comes_back(tmp_path / "began")


@pytest.mark.night
def test_worker_whose_restart_takes_long_is_waited_for(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Dask alone would give it up after 15 s, and with it the only worker."""
    start = WorkerProcess.start

    async def start_late(self: WorkerProcess) -> Status:
        if (tmp_path / "began").exists():
            await asyncio.sleep(20.0)
        return await start(self)

    monkeypatch.setattr(WorkerProcess, "start", start_late)
    assert_comes_back(tmp_path / "began")


@pytest.mark.parametrize(("grace", "lasts"), [(20.0, 1.0), (0.2, 5.0)], ids=["enough", "too short"])
def test_stopped_window_lets_running_blocks_finish_within_its_grace_and_drops_the_rest(
    client: Client, tmp_path: Path, grace: float, lasts: float
) -> None:
    def task(index: int) -> BlockOutcome:
        (tmp_path / f"began-{index}").touch()
        time.sleep(lasts)
        return _outcome(index)

    window = window_of(client, task, 50)
    window.fill()
    while len(list(tmp_path.iterdir())) < 2:
        time.sleep(0.02)
    ended = list(window.drain(grace))
    assert not window.workers.in_flight
    began = {f"began-{each.index}" for each in ended}
    assert len(ended) >= 2 if grace > lasts else not ended
    begun = {path.name for path in tmp_path.iterdir()}
    # Between the question what runs and the dropping of the rest, each worker may have begun one more.
    assert began <= begun
    assert len(begun) <= len(began) + 2


def test_a_client_that_has_closed_with_its_scheduler_is_an_outage_and_no_other_error() -> None:
    """A client gives up by itself where its scheduler is lost, between any two calls, and raises errors of its own then."""

    def task(index: int) -> BlockOutcome:
        time.sleep(60.0)
        return _outcome(index)

    with connect(workers=1) as client:
        windows = [window_of(client, task, 16) for _ in range(4)]
        for window in windows:
            window.fill()
            assert window.workers.in_flight
        client.close()
        closes, drains, sends, looks = windows
        closes.close()
        assert not closes.workers.in_flight
        with pytest.raises(Outage, match="scheduler was lost"):
            list(drains.drain(30.0))
        with pytest.raises(Outage, match="scheduler was lost"):
            sends._tasks.send("block-of-the-test", next(iter(sends.workers.states)), (task, 1))
        looks._looked = float("-inf")
        with pytest.raises(Outage, match="scheduler was lost"):
            looks.fill()
        for window in windows:
            window.close()
