"""The bounded window on real worker processes: blocks that fail, workers that die, work that is stopped."""

import os
import signal
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import psutil
import pytest
from distributed import Client, Future

from damperlab.studies.store.record import BlockOutcome
from damperlab.worker.cluster import connect
from damperlab.worker.outcomes import RETRIES, Failure, Interrupted
from damperlab.worker.provenance import require_code
from damperlab.worker.window import BLOCKS_PER_THREAD, Window


def _outcome(index: int) -> BlockOutcome:
    return BlockOutcome(index, points=1, failed=0, seconds=0.0, kernel_seconds=0.0)


@pytest.fixture(scope="module")
def client() -> Iterator[Client]:
    with connect(workers=2) as client:
        yield client


def window_of(client: Client, task: Callable[[int], BlockOutcome], count: int) -> Window:
    def submit(index: int, key: str) -> Future:
        return client.submit(task, index, key=key, pure=False)

    return Window(client, submit, iter(range(count)))


def pump(window: Window, seconds: float = 90.0) -> list[BlockOutcome | Failure]:
    ended: list[BlockOutcome | Failure] = []
    deadline = time.monotonic() + seconds
    window.fill()
    while not window.empty:
        assert time.monotonic() < deadline, f"only {len(ended)} blocks ended"
        ended.extend(window.collect(0.2))
        window.fill()
    return ended


def test_every_block_ends_once_and_few_are_at_the_cluster(client: Client) -> None:
    sent = 0
    most = 0

    def submit(index: int, key: str) -> Future:
        nonlocal sent
        sent += 1
        return client.submit(_outcome_of, index, key=key, pure=False)

    def _outcome_of(index: int) -> BlockOutcome:
        return BlockOutcome(index, 1, 0, 0.0, 0.0)

    window = Window(client, submit, iter(range(100)))
    ended: list[int] = []
    window.fill()
    while not window.empty:
        most = max(most, sent - len(ended))
        ended.extend(outcome.index for outcome in window.collect(0.2))
        window.fill()
    assert sorted(ended) == list(range(100))
    assert most == 2 * BLOCKS_PER_THREAD


def test_block_that_always_fails_is_given_up_and_the_rest_goes_on(client: Client, tmp_path: Path) -> None:
    def task(index: int) -> BlockOutcome:
        with (tmp_path / f"{index}").open("a") as tries:
            tries.write("x")
        if index == 3:
            raise ZeroDivisionError("the third")
        return BlockOutcome(index, 1, 0, 0.0, 0.0)

    ended = pump(window_of(client, task, 12))
    assert [failure for failure in ended if isinstance(failure, Failure)] == [
        Failure(3, "ZeroDivisionError: the third")
    ]
    assert sorted(each.index for each in ended) == list(range(12))
    assert len((tmp_path / "3").read_text()) == 1 + RETRIES
    assert len((tmp_path / "4").read_text()) == 1


def test_block_that_fails_as_often_as_it_may_succeeds(client: Client, tmp_path: Path) -> None:
    def task(index: int) -> BlockOutcome:
        tries = tmp_path / f"{index}"
        with tries.open("a") as file:
            file.write("x")
        if len(tries.read_text()) <= RETRIES:
            raise ValueError("not yet")
        return BlockOutcome(index, 1, 0, 0.0, 0.0)

    ended = pump(window_of(client, task, 4))
    assert sorted(ended, key=lambda each: each.index) == [_outcome(index) for index in range(4)]


def test_block_that_kills_its_worker_is_given_up_and_its_neighbours_are_not() -> None:
    def task(index: int) -> BlockOutcome:
        if index == 0:
            os.kill(os.getpid(), signal.SIGKILL)
        time.sleep(0.05)
        return BlockOutcome(index, 1, 0, 0.0, 0.0)

    # On one worker the killer always has neighbours waiting behind it, which die with it.
    with connect(workers=1) as client:
        ended = pump(window_of(client, task, 16))
    failures = [failure for failure in ended if isinstance(failure, Failure)]
    assert [failure.index for failure in failures] == [0]
    assert f"its worker died {RETRIES + 1} times" in failures[0].message
    assert sorted(each.index for each in ended) == list(range(16))


def test_worker_killed_from_outside_costs_no_block(client: Client) -> None:
    def task(index: int) -> BlockOutcome:
        time.sleep(0.1)
        return BlockOutcome(index, 1, 0, 0.0, 0.0)

    window = window_of(client, task, 20)
    window.fill()
    ended = list(window.collect(5.0))
    victim = next(iter(client.run(os.getpid).values()))
    os.kill(victim, signal.SIGKILL)
    ended.extend(pump(window))
    assert sorted(ended, key=lambda each: each.index) == [_outcome(index) for index in range(20)]
    assert not psutil.pid_exists(victim)


def test_data_that_cannot_be_written_interrupts_instead_of_failing_points(client: Client) -> None:
    def task(index: int) -> BlockOutcome:
        raise PermissionError(13, "Permission denied", "cube")

    window = window_of(client, task, 3)
    with pytest.raises(Interrupted, match="Permission denied"):
        pump(window)
    window.close()
    assert window.empty


def test_worker_with_other_code_interrupts_at_once(client: Client, tmp_path: Path) -> None:
    def task(index: int) -> BlockOutcome:
        (tmp_path / f"{time.monotonic_ns()}").touch()
        require_code("0" * 64)
        return BlockOutcome(index, 1, 0, 0.0, 0.0)

    with pytest.raises(Interrupted, match="holds damperlab"):
        pump(window_of(client, task, 1))
    assert len(list(tmp_path.iterdir())) == 1


def test_stopped_window_lets_running_blocks_finish_and_drops_the_rest(client: Client, tmp_path: Path) -> None:
    def task(index: int) -> BlockOutcome:
        (tmp_path / f"began-{index}").touch()
        time.sleep(1.0)
        return BlockOutcome(index, 1, 0, 0.0, 0.0)

    window = window_of(client, task, 50)
    window.fill()
    while len(list(tmp_path.iterdir())) < 2:
        time.sleep(0.02)
    ended = list(window.drain(20.0))
    assert window.empty
    began = {f"began-{each.index}" for each in ended}
    assert 2 <= len(ended) <= 4 < 2 * BLOCKS_PER_THREAD
    begun = {path.name for path in tmp_path.iterdir()}
    # Between the question what runs and the dropping of the rest, each worker may have begun one more.
    assert began <= begun
    assert len(begun) <= len(began) + 2


def test_grace_ends_for_blocks_that_take_longer(client: Client, tmp_path: Path) -> None:
    def task(index: int) -> BlockOutcome:
        (tmp_path / f"began-{index}").touch()
        while not (tmp_path / "end").exists():
            time.sleep(0.02)
        return BlockOutcome(index, 1, 0, 0.0, 0.0)

    window = window_of(client, task, 4)
    window.fill()
    while len(list(tmp_path.iterdir())) < 2:
        time.sleep(0.02)
    try:
        assert list(window.drain(0.2)) == []
    finally:
        (tmp_path / "end").touch()
    assert window.empty
