"""Which block goes to whom, and what becomes of it where workers leave, are lost or cannot compute it."""

import pytest
from tests.benchmarks import model

from damperlab.worker.dispatch.backlog import Backlog
from damperlab.worker.dispatch.crew import Crew
from damperlab.worker.dispatch.roster import STUCK_SECONDS


def crew_of(workers: int, backlog: Backlog) -> Crew:
    crew = Crew(backlog)
    names = {f"w{number}": 1 for number in range(workers)}
    crew.see(names, names)
    for name in names:
        crew.admit(name)
    return crew


def held_by(crew: Crew) -> dict[str, list[int]]:
    return {name: [one.index for one in member.held.values()] for name, member in crew.members.items()}


def fill(crew: Crew) -> dict[str, list[int]]:
    for number, (address, attempt) in enumerate(crew.assignments(), len(crew._where)):
        crew.sent(f"{address}-{attempt.index}-{attempt.tries}-{number}", address, attempt)
    return held_by(crew)


def test_blocks_that_run_for_too_long_go_to_others_but_from_a_worker_that_leaves() -> None:
    crew = crew_of(3, Backlog(range(20)))
    held = fill(crew)
    crew.see(dict.fromkeys(held, 1), ("w0", "w1"))  # w2 was told to leave; it still finishes what it runs
    assert crew.take_away(0.0) == []
    crew.ended(next(iter(crew.members["w1"].held)))
    assert crew.take_away(STUCK_SECONDS) == []
    lost = crew.take_away(STUCK_SECONDS + 1.0)
    assert [key.partition("-")[0] for key in lost] == ["w0", "w0"]
    assert len(crew.members["w2"].held) == 1


def test_what_a_lost_worker_ran_is_suspect_and_what_waited_there_is_not() -> None:
    crew = crew_of(3, Backlog(range(20)))
    held = fill(crew)
    assert [len(blocks) for blocks in held.values()] == [2, 2, 2]
    ran, waited = held["w0"]
    crew.see({"w1": 1, "w2": 1}, ("w1", "w2"))
    for key in [next(iter(member.held)) for member in crew.members.values()]:
        crew.ended(key)
    fill(crew)
    again = {
        one.index: one
        for member in crew.members.values()
        for one in member.held.values()
        if one.index in (ran, waited)
    }
    assert (again[ran].apart, again[waited].apart) == (True, False)
    # at two workers, side by side
    assert sum(bool(again.keys() & blocks) for blocks in map(set, held_by(crew).values())) == 2


def test_worker_that_is_tried_again_is_told_with_the_reason_for_which_it_was_left_out() -> None:
    crew = crew_of(1, Backlog(range(4)))
    crew.leave_out("w0", "its store says 503")
    assert "w0 is left out: its store says 503" in crew.words()
    crew.admit("w0")
    assert not crew.able
    assert "w0 was left out and is tried again: its store says 503" in crew.words()
    fill(crew)
    crew.ended(next(iter(crew.members["w0"].held)))
    assert crew.able
    assert crew.members["w0"].reason == ""


def test_worker_that_is_told_to_leave_ends_what_it_runs_and_gets_nothing_more() -> None:
    crew = crew_of(2, Backlog(range(20)))
    ran, waited = fill(crew)["w0"]
    names = {"w0": 1, "w1": 1}
    assert len(crew.see(names, ("w1",))) == 1
    assert [one.index for one in crew.members["w0"].held.values()] == [ran]
    fill(crew)
    assert len(crew.members["w0"].held) == 1
    crew.see({"w1": 1}, ("w1",))
    for key in list(crew.members["w1"].held):
        crew.ended(key)
    fill(crew)
    again = {one.index: one for one in crew.members["w1"].held.values()}
    assert again.keys() == {ran, waited}
    assert not any(one.apart for one in again.values())


def test_what_happens_to_a_block_is_told_with_its_number_and_its_worker() -> None:
    crew = crew_of(2, Backlog(range(1)))
    fill(crew)
    (first,) = (name for name, blocks in held_by(crew).items() if blocks)
    crew.failed(next(iter(crew.members[first].held)), ValueError("no"), 0.0)
    fill(crew)
    (second,) = (name for name, blocks in held_by(crew).items() if blocks)
    assert first != second
    crew.vanish(second)
    assert crew.incidents == [
        f"block 0 was not computed by worker {first}: ValueError: no",
        f"block 0 was computed by worker {second}, which is gone",
    ]
    for _ in range(2):
        fill(crew)
        crew.failed(next(iter(crew.members[first].held)), ValueError("again"), 0.0)
    assert crew.incidents[-1] == "block 0 is given up: ValueError: again"
    assert crew.retries == 3


@pytest.mark.parametrize("workers", [2, 8, 32])
def test_workers_are_nearly_as_busy_as_they_can_be(workers: int) -> None:
    """With what real points took, 18 blocks and more a worker: within four points of the best."""
    share = model.busy(4, workers)
    assert share["best"] - 0.04 <= share["busy"] <= 1.0
