"""Claims under clocks that are wrong, and owners that were thought dead and are not."""

import time
from collections.abc import Callable
from dataclasses import replace

import pytest
from tests.filling import enter, make_plan_of, make_study, outcome_of, values_of

import damperlab.studies.store.catalogue.rows
import damperlab.studies.store.life_cycle.blocks
import damperlab.studies.store.life_cycle.claims
import damperlab.studies.store.life_cycle.states
from damperlab.studies.store.care.sweep import collect_garbage
from damperlab.studies.store.care.verify import verify
from damperlab.studies.store.cube.block_file import write_region
from damperlab.studies.store.life_cycle.claims import CLAIM_SECONDS
from damperlab.studies.store.store import Store

DAY = 86_400.0


class Clocks:
    """The clock on the wall, which may be set, and one that nobody sets; both stand still unless they are moved."""

    def __init__(self) -> None:
        self.wall, self.steady = time.time(), time.monotonic()

    def time(self) -> float:
        return self.wall

    def monotonic(self) -> float:
        return self.steady

    def wait(self, seconds: float) -> None:
        self.wall += seconds
        self.steady += seconds


@pytest.fixture
def clocks(monkeypatch: pytest.MonkeyPatch) -> Clocks:
    found = Clocks()
    monkeypatch.setattr(damperlab.studies.store.life_cycle.claims, "time", found)
    monkeypatch.setattr(damperlab.studies.store.catalogue.rows, "time", found)
    return found


@pytest.fixture
def claim_elsewhere(store: Store, clocks: Clocks) -> Callable[..., bool]:
    """Claim a study by a store of its own, as another process does, whose clock is ahead, or behind."""

    def claim(study_id: str, owner: str, ahead_seconds: float) -> bool:
        other = Store.open(store.data_dir)
        clocks.wall += ahead_seconds
        try:
            return other.claim(study_id, owner)
        finally:
            clocks.wall -= ahead_seconds
            other.close()

    return claim


@pytest.fixture
def study_id(store: Store) -> str:
    return enter(store, make_study()).id


def test_a_clock_that_was_set_back_keeps_no_dead_owner_alive(
    store: Store, study_id: str, clocks: Clocks, claim_elsewhere
) -> None:
    # an owner elsewhere died; then the clock was set back by a day, so that its claim ends tomorrow
    assert claim_elsewhere(study_id, "elsewhere:1:0123abcd", DAY)
    assert store.find(study_id).owner == "elsewhere:1:0123abcd"
    assert not store.abandoned(study_id)
    assert not store.claim(study_id, "next")
    clocks.wait(CLAIM_SECONDS + 1.0)
    assert store.abandoned(study_id)
    assert store.claim(study_id, "next")
    assert not store.abandoned(study_id)


def test_a_living_owner_keeps_its_claim_whatever_the_clock_says(
    store: Store, study_id: str, clocks: Clocks, claim_elsewhere
) -> None:
    assert claim_elsewhere(study_id, "living", DAY)
    for _ in range(4):
        clocks.wait(0.4 * CLAIM_SECONDS)
        assert claim_elsewhere(study_id, "living", DAY)  # renewed
        assert not store.claim(study_id, "next")


def test_an_owner_whose_claim_was_taken_marks_nothing_and_ends_nothing(
    store: Store, study_id: str, claim_elsewhere
) -> None:
    plan = make_plan_of(make_study())
    # its clock is behind by more than a claim lasts: to everybody else its claim is over
    assert claim_elsewhere(study_id, "slow", -3600.0)
    assert store.claim(study_id, "next")
    store.set_state(study_id, "running", owner="next")
    assert not store.mark(study_id, outcome_of(plan.block(0)), owner="slow")
    assert store.set_state(study_id, "cancelled", "by one who lost it", owner="slow").state == "running"
    assert not store.renew(study_id, "slow")
    assert store.pending(study_id).size == plan.count
    assert store.mark(study_id, outcome_of(plan.block(0)), outcome_of(plan.block(3)), owner="next")
    assert store.find(study_id).blocks_done == 2


def test_a_study_that_was_deleted_and_submitted_anew_takes_no_marks_of_the_first(
    store: Store, study_id: str
) -> None:
    study, plan = make_study(), make_plan_of(make_study())
    assert store.claim(study_id, "first")
    store.set_state(study_id, "cancelled")
    store.delete(study_id)
    assert store.submit(study, plan, {})[0].id == study_id
    # the files of this block went with the first cube
    assert not store.mark(study_id, outcome_of(plan.block(0)), owner="first")
    assert store.find(study_id).blocks_done == 0


def test_garbage_is_not_collected_from_under_an_owner_whose_claim_seems_over(
    store: Store, study_id: str, claim_elsewhere
) -> None:
    study, plan = make_study(), make_plan_of(make_study())
    block = plan.block(2)
    assert claim_elsewhere(study_id, "slow", -3600.0)
    write_region(store.cube_path(study_id), block, values_of(study, block), "slow")
    assert collect_garbage(store, -1.0).paths == 0  # it may yet be marked
    write_region(store.cube_path(study_id), block, values_of(study, block), "quick")
    store.mark(study_id, replace(outcome_of(block), generation="quick"))
    assert collect_garbage(store, -1.0).paths == 1
    # what it wrote is gone, and so is its leave to say that it is there
    assert not store.mark(study_id, outcome_of(plan.block(3)), owner="slow")
    record = store.find(study_id)
    assert (record.blocks_done, record.owner) == (1, None)
    assert list(verify(store, record)) == []


def test_studies_that_wait_are_told_by_their_priority_and_then_the_oldest_first(store: Store) -> None:
    """Without those that somebody works on, and those that have ended."""
    priorities = (0, -3, 7, 0, 7, -3, 10, 0, 0)
    ids = []
    for place, priority in enumerate(priorities):
        study = make_study(damping_ratio=0.1 + 0.05 * place)
        record, _ = store.submit(study, make_plan_of(study), {}, priority=priority)
        # handed in again it keeps its own
        assert store.submit(study, make_plan_of(study), {}, priority=1)[0].priority == priority
        ids.append(record.id)
    store.claim(ids[7], "runner 7")
    store.claim(ids[3], "dead")
    store.set_state(ids[3], "running")
    store.set_state(ids[8], "done")
    order = sorted(range(7), key=lambda place: -priorities[place])
    assert [one.id for one in store.unclaimed(lambda owner: owner == "dead")] == [ids[at] for at in order]
    assert store.unclaimed(lambda owner: False, 1)[0].id == ids[6]


@pytest.mark.parametrize("jump", [-DAY, 10.0])
def test_what_is_left_is_told_by_no_clock_that_was_set_back(
    store: Store, study_id: str, clocks: Clocks, monkeypatch: pytest.MonkeyPatch, jump: float
) -> None:
    for module in (damperlab.studies.store.life_cycle.states, damperlab.studies.store.life_cycle.blocks):
        monkeypatch.setattr(module, "time", clocks)
    plan = make_plan_of(make_study())
    store.set_state(study_id, "running")
    clocks.wait(4.0)
    store.mark(study_id, outcome_of(plan.block(0)))
    left = store.find(study_id).seconds_left
    assert left == pytest.approx(4.0 * (60 - plan.block(0).points) / plan.block(0).points)
    clocks.wall += jump
    now = store.find(study_id).seconds_left
    assert now == pytest.approx(left - max(0.0, jump))
    store.mark(study_id, outcome_of(plan.block(1)))
    assert (store.find(study_id).seconds_left is None) == (jump < 0.0)
