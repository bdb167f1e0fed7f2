"""Which block goes to whom, and what becomes of it where workers leave, are lost or cannot compute it."""

import pytest
from tests.benchmarks import model

from damperlab.worker.dispatch.workers import LONGER_TIMES, STUCK_SECONDS, Workers


def workers_of(count: int, blocks: int, threads: int = 1) -> Workers:
    workers = Workers(range(blocks))
    names = {f"w{number}": threads for number in range(count)}
    workers.see(names, names)
    for name in names:
        workers.admit(name)
    return workers


def held_by(workers: Workers) -> dict[str, list[int]]:
    return {name: [one.index for one in worker.held.values()] for name, worker in workers.states.items()}


def fill(workers: Workers) -> dict[str, list[int]]:
    for number, (address, attempt) in enumerate(workers.assignments(), len(workers._where)):
        workers.sent(f"{address}-{attempt.index}-{attempt.tries}-{number}", address, attempt)
    return held_by(workers)


def test_blocks_that_run_for_too_long_go_to_others() -> None:
    workers = workers_of(3, 20)
    held = fill(workers)
    workers.see(dict.fromkeys(held, 1), ("w0", "w1"))  # w2 was told to leave; it still finishes what it runs
    assert workers.take_away(0.0) == []
    workers.ended(next(iter(workers.states["w1"].held)))
    assert workers.take_away(STUCK_SECONDS) == []
    lost = workers.take_away(STUCK_SECONDS + 1.0)
    assert sorted(key.partition("-")[0] for key in lost) == ["w0", "w0", "w2"]
    assert held_by(workers) == {"w0": [], "w1": held["w1"][1:], "w2": []}


def test_a_block_stays_at_the_only_worker_but_not_at_one_that_leaves_and_never_ends() -> None:
    workers = workers_of(1, 6)
    fill(workers)
    workers.take_away(0.0)
    assert workers.take_away(STUCK_SECONDS + 1.0) == []
    workers.see({"w0": 1}, ())
    assert workers.able
    assert len(workers.take_away(STUCK_SECONDS + 2.0)) == 1
    assert not workers.able  # so that the study says so instead of waiting for ever
    assert "w0 leaves, and block 0 has been there for" in workers.incidents[-1]
    workers.see({"w0": 1, "w1": 1}, ["w1"])
    workers.admit("w1")
    waited, moved = fill(workers)["w1"]
    assert (waited, moved) == (1, 0)
    workers.ended(next(iter(workers.states["w1"].held)))
    workers.see({"w0": 1, "w1": 1}, ())
    workers.take_away(0.0)
    # though it was moved before; but not so soon that a block that takes long would never end
    assert workers.take_away(LONGER_TIMES * STUCK_SECONDS) == []
    assert len(workers.take_away(LONGER_TIMES * STUCK_SECONDS + 1.0)) == 1


def test_all_blocks_of_a_worker_go_to_others_if_two_of_them_run_for_too_long() -> None:
    workers = workers_of(2, 20, threads=2)
    held = fill(workers)
    assert len(held["w0"]) == 4
    workers.take_away(0.0)
    for key in list(workers.states["w1"].held):
        workers.ended(key)
    lost = workers.take_away(STUCK_SECONDS + 1.0)
    assert sorted(int(key.split("-")[1]) for key in lost) == sorted(held["w0"])


def test_what_a_lost_worker_ran_is_suspect_and_what_waited_there_is_not() -> None:
    workers = workers_of(3, 20)
    held = fill(workers)
    assert [len(blocks) for blocks in held.values()] == [2, 2, 2]
    ran, waited = held["w0"]
    workers.see({"w1": 1, "w2": 1}, ("w1", "w2"))
    for key in [next(iter(worker.held)) for worker in workers.states.values()]:
        workers.ended(key)
    fill(workers)
    again = {
        one.index: one
        for worker in workers.states.values()
        for one in worker.held.values()
        if one.index in (ran, waited)
    }
    assert (again[ran].apart, again[waited].apart) == (True, False)
    # at two workers, side by side
    assert sum(bool(again.keys() & blocks) for blocks in map(set, held_by(workers).values())) == 2


def test_a_block_whose_worker_was_lost_with_others_is_suspect_when_it_is_lost_again() -> None:
    workers = workers_of(4, 1)
    seen = []
    for left in (("w2", "w3"), ()):
        fill(workers)
        (holder,) = (name for name, worker in workers.states.items() if worker.held)
        seen.append(next(iter(workers.states[holder].held.values())).apart)
        workers.see(dict.fromkeys(set(left) - {holder}, 1), left)
    assert seen == [False, False]
    workers.see({"w4": 1}, ("w4",))
    workers.admit("w4")
    fill(workers)
    assert next(iter(workers.states["w4"].held.values())).apart


def test_worker_that_is_tried_again_is_told_with_the_reason_for_which_it_was_left_out() -> None:
    workers = workers_of(1, 4)
    workers.leave_out("w0", "its store says 503")
    assert "w0 is left out: its store says 503" in workers.words()
    workers.admit("w0")
    assert not workers.able
    assert "w0 was left out and is tried again: its store says 503" in workers.words()
    fill(workers)
    workers.ended(next(iter(workers.states["w0"].held)))
    assert workers.able
    assert workers.states["w0"].reason == ""


def test_worker_that_is_told_to_leave_ends_what_it_runs_and_gets_nothing_more() -> None:
    workers = workers_of(2, 20)
    ran, waited = fill(workers)["w0"]
    names = {"w0": 1, "w1": 1}
    assert len(workers.see(names, ("w1",))) == 1
    assert [one.index for one in workers.states["w0"].held.values()] == [ran]
    fill(workers)
    assert len(workers.states["w0"].held) == 1
    workers.see({"w1": 1}, ("w1",))
    for key in list(workers.states["w1"].held):
        workers.ended(key)
    fill(workers)
    again = {one.index: one for one in workers.states["w1"].held.values()}
    assert again.keys() == {ran, waited}
    # however often that happens, it speaks against no block
    assert not any(one.apart or one.tries for one in again.values())


def test_what_happens_to_a_block_is_told_with_its_number_and_its_worker() -> None:
    workers = workers_of(2, 1)
    fill(workers)
    (first,) = (name for name, blocks in held_by(workers).items() if blocks)
    workers.failed(next(iter(workers.states[first].held)), ValueError("no"), 0.0)
    fill(workers)
    (second,) = (name for name, blocks in held_by(workers).items() if blocks)
    assert first != second
    workers.vanish(second)
    assert workers.incidents == [
        f"block 0 was not computed by worker {first}: ValueError: no",
        f"block 0 was not completed by worker {second}, which is gone",
    ]
    for _ in range(2):
        fill(workers)
        workers.failed(next(iter(workers.states[first].held)), ValueError("again"), 0.0)
    assert workers.incidents[-1] == "block 0 is given up: ValueError: again"
    assert workers.retries == 3


@pytest.mark.parametrize("workers", [2, 8, 32])
def test_workers_are_nearly_as_busy_as_they_can_be(workers: int) -> None:
    """With what real points took, 18 blocks and more a worker: within four points of the best."""
    share = model.busy(4, workers)
    assert share["best"] - 0.04 <= share["busy"] <= 1.0
