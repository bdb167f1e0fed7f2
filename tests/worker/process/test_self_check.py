"""A worker that shows that it is alive by computing what is known, and leaves where that comes out otherwise."""

import asyncio
import signal
import time
from pathlib import Path

import numpy as np
import pytest
from tests.ports import free_port
from tests.worker.dask_processes import worker_process

from damperlab.studies.definition import Study
from damperlab.studies.plan import Block
from damperlab.worker.block import solve_block
from damperlab.worker.worker_process.examination import KNOWN, show_alive, wrong_answers

GIVE_UP_SECONDS = 600.0


def off_by_one_in_the_sixth_digit(study: Study, block: Block) -> dict[str, np.ndarray]:
    return {name: values * (1.0 + 1e-5) for name, values in solve_block(study, block).items()}


def nothing(study: Study, block: Block) -> dict[str, np.ndarray]:
    return {name: np.full(values.shape, np.nan) for name, values in solve_block(study, block).items()}


SOLVE = "damperlab.worker.worker_process.examination.solve_block"


def test_known_points_are_right_here_and_a_wrong_one_is_named_with_its_truth(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    assert wrong_answers() == ""
    monkeypatch.setattr(SOLVE, off_by_one_in_the_sixth_digit)
    said = wrong_answers()
    assert all(f"{truth:.9g} at friction ratio {friction:g}" in said for friction, truth in KNOWN.items())
    monkeypatch.setattr(SOLVE, nothing)
    assert wrong_answers().count("nan in place of") == len(KNOWN)


def test_file_is_not_touched_where_the_answers_are_wrong(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(SOLVE, off_by_one_in_the_sixth_digit)
    said: list[str] = []
    asyncio.run(show_alive(tmp_path / "alive", said.append))
    assert len(said) == 1
    assert said[0].startswith("it computes wrong values for known points: 131.5")
    assert not (tmp_path / "alive").exists()


def test_worker_that_waits_for_its_scheduler_is_alive_and_leaves_when_it_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "alive"
    monkeypatch.setenv("DAMPERLAB_CLUSTER_TLS", "")
    with worker_process(f"tcp://127.0.0.1:{free_port()}", "--alive", str(file)) as worker:
        give_up = time.monotonic() + GIVE_UP_SECONDS
        while not file.exists():
            assert worker.poll() is None
            assert time.monotonic() < give_up
            time.sleep(0.1)
        worker.send_signal(signal.SIGTERM)
        assert worker.wait(GIVE_UP_SECONDS) == 0
