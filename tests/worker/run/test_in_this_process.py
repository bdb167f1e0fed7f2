"""Small studies computed in the process that runs them, without a cluster; and who has a say in a study that runs."""

import subprocess
import sys
import threading
import time
from collections.abc import Callable
from contextlib import closing
from itertools import count
from pathlib import Path
from typing import Any

import pytest
from tests.worker.run_here import (
    AMPLE_SECONDS,
    BLOCKS,
    friction_study,
    linear_study,
    of_one_piece,
    run_here,
    submit,
)

from damperlab.studies.store.files.shelf import ShelfAway
from damperlab.studies.store.record import BlockOutcome
from damperlab.studies.store.store import Store
from damperlab.worker.outcomes import Failure, Outage
from damperlab.worker.run.in_this_process import InThisProcess
from damperlab.worker.run.progress import Progress
from damperlab.worker.run.small_batch import compute_together


def test_a_closed_form_study_is_run_without_loading_the_library_of_the_cluster(tmp_path: Path) -> None:
    file = tmp_path / "study.yaml"
    file.write_text("particle: false\naxes: {friction_ratio: 0, frequency_ratio: [0.5, 2]}\n")
    script = f"""
import sys
sys.argv = ["damperlab", "run", {str(file)!r}, "--data-dir", {str(tmp_path / "data")!r}, "--json"]
from damperlab.service.cli.main import main
try:
    main()
finally:
    print([name for name in ("dask", "distributed", "xarray") if name in sys.modules], file=sys.stderr)
"""
    ended = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert ended.returncode == 0, ended.stderr
    assert ended.stderr.splitlines()[-1] == "[]"


def test_studies_of_several_blocks_are_computed_together_with_the_bits_of_a_run(
    store: Store, tmp_path: Path
) -> None:
    ids = [submit(store, friction_study()).id, submit(store, linear_study([0.5, 1.5]), 1).id]
    blocks = count()
    assert compute_together(store, ids[:1], lambda: next(blocks) >= BLOCKS // 2) == set()
    stopped = store.find(ids[0])
    assert (stopped.state, stopped.blocks_done, stopped.owner) == ("queued", 0, None)
    # a study that has begun once is left to a run of its own
    assert compute_together(store, ids, lambda: False) == set(ids[1:])
    together = submit(store, linear_study([0.25, 0.5, 0.75, 1.25], 0.1), 1).id
    assert compute_together(store, [together], lambda: False) == {together}
    ended = store.find(together)
    assert (ended.state, ended.blocks_done, ended.points_done, ended.owner) == ("done", 4, 4, None)
    with closing(Store.open(tmp_path / "alone")) as other:
        run_here(other, submit(other, linear_study([0.25, 0.5, 0.75, 1.25], 0.1), 2).id)
        for name in ("amplitude_ratio", "status"):
            one, two = (each.cube(together)[name].values for each in (store, other))
            assert one.tobytes() == two.tobytes()


def test_studies_computed_together_take_earlier_points_only_if_they_may(store: Store) -> None:
    run_here(store, submit(store, linear_study([0.5, 1.5]), 1).id)
    allowed = {1.0: True, 1.25: False}
    ids = [submit(store, linear_study([0.5, end]), 1, reuse=reuse).id for end, reuse in allowed.items()]
    assert compute_together(store, ids, lambda: False) == set(ids)
    assert [store.find(study_id).points_reused for study_id in ids] == [1, 0]


def test_a_block_that_raises_an_exception_fails() -> None:
    def run() -> BlockOutcome:
        raise ArithmeticError("no number")

    with closing(InThisProcess(lambda index, key: (run,), iter([7]))) as here:
        here.fill()
        assert list(here.drain(0.0)) == [Failure(7, "ArithmeticError: no number")]
        assert here.empty


def test_data_out_of_reach_is_an_outage_at_once() -> None:
    def run() -> BlockOutcome:
        raise ShelfAway("the bucket is away")

    with closing(InThisProcess(lambda index, key: (run,), iter([0]))) as here:
        here.fill()
        with pytest.raises(Outage, match="the bucket is away"):
            list(here.drain(0.0))


def test_every_core_has_a_block(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("damperlab.worker.run.in_this_process.core_count", lambda: 3)
    together = threading.Barrier(3, timeout=AMPLE_SECONDS)

    def run(index: int) -> BlockOutcome:
        if index < 3:
            together.wait()  # each goes on once all three are at it
        return BlockOutcome(index, 1, 0, 1.0, 1.0)

    with closing(InThisProcess(lambda index, key: (run, index), iter(range(4)))) as here:
        ended: set[int] = set()
        here.fill()
        while not here.empty:
            ended |= {outcome.index for outcome in here.collect(AMPLE_SECONDS)}
            here.fill()
    assert ended == {0, 1, 2, 3}


STUDY = linear_study([0.8, 1.0, 1.2])
RENEW_SECONDS = 0.05


class Late(Store):
    """A store in which something happens once a study has been claimed, before it runs."""

    after_claim: Callable[[], Any]

    def claim(self, *arguments: Any, **more: Any) -> bool:
        taken = super().claim(*arguments, **more)
        self.after_claim()
        return taken


@pytest.fixture
def late(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Late:
    monkeypatch.setattr("damperlab.worker.run.lease.RENEW_SECONDS", RENEW_SECONDS)
    return Late.open(tmp_path / "data")  # type: ignore[return-value]


def test_a_study_whose_runner_waits_for_its_turn_at_writing_is_not_cancelled(late: Late) -> None:
    study_id = submit(late, STUDY, 1).id
    # as when many submissions are before it: its claim is renewed several times meanwhile
    late.after_claim = lambda: time.sleep(20 * RENEW_SECONDS)
    record = run_here(late, study_id)
    assert (record.state, record.blocks_done) == ("done", record.blocks_total)
    assert [what for _, what in late.events(study_id)][1:3] == ["queued to running", "running to done"]


def test_a_study_that_is_cancelled_as_its_runner_begins_stays_cancelled(late: Late) -> None:
    study_id = submit(late, STUDY, 1).id
    late.after_claim = lambda: late.set_state(study_id, "cancelled", only_from=("queued", "running"))
    record = run_here(late, study_id, only_from=("queued", "running"))
    assert (record.state, record.blocks_done, record.owner) == ("cancelled", 0, None)
    late.after_claim = lambda: None
    assert run_here(late, study_id).state == "done"


def test_a_runner_whose_claim_was_taken_while_it_stood_still_spoils_nothing(
    store: Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What it brings in afterwards is not marked, and the study's end is left to who has the claim now."""
    monkeypatch.setattr("damperlab.worker.run.progress.REPORT_SECONDS", 0.0)
    study_id = submit(store, STUDY, 1).id
    kept: list[int] = []

    def take(progress: Progress) -> None:
        if progress.blocks_done and not kept:
            kept.append(progress.blocks_done)
            with monkeypatch.context() as patch:  # as if it had not been renewed for long
                patch.setattr("damperlab.studies.store.life_cycle.claims.CLAIM_SECONDS", -1.0)
                store.renew(study_id, str(store.find(study_id).owner))
            assert store.claim(study_id, "next")

    record = run_here(store, study_id, take)
    assert (record.state, record.blocks_done, record.owner) == ("running", kept[0], "next")
    store.release(study_id, "next")
    ended = run_here(store, study_id)
    assert (ended.state, ended.blocks_done) == ("done", ended.blocks_total)
    assert of_one_piece(store, study_id, STUDY)
