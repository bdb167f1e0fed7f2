"""A study is cancelled by who asks for it and by nobody else, and only one runner at a time has a say in it."""

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from tests.worker.run_here import linear_study, of_one_piece, run_here, submit

from damperlab.studies.store.store import Store
from damperlab.worker.run.progress import Progress

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
            store.renew(study_id, str(store.find(study_id).owner), seconds=-1.0)
            assert store.claim(study_id, "next")

    record = run_here(store, study_id, take)
    assert (record.state, record.blocks_done, record.owner) == ("running", kept[0], "next")
    store.release(study_id, "next")
    ended = run_here(store, study_id)
    assert (ended.state, ended.blocks_done) == ("done", ended.blocks_total)
    assert of_one_piece(store, study_id, STUDY)
