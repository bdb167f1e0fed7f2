"""A study that is stopped keeps what is done and can be resumed; a stop holds for all that follow."""

import json
import os
import signal
import time
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

import httpx
import pytest
from tests.service.cli.commands import END_SECONDS, LINEAR, run, start

from damperlab.service.cli.computing import Computer, Means
from damperlab.service.cli.run import find_or_submit
from damperlab.studies.definition import parse_study
from damperlab.studies.store.record import Record
from damperlab.studies.store.store import Store


def slow_study(name: str, frictions: int) -> dict[str, Any]:
    """Responses that never become periodic, with a tolerance that none reaches: most take all of their 100,000 cycles."""
    return {
        "name": name,
        "axes": {
            "clearance_ratio": {"start": 20, "stop": 24, "num": 5},
            "friction_ratio": {"start": 0.02, "stop": 0.3, "num": frictions},
            "frequency_ratio": 1,
        },
        "steady": {"max_cycles": 100_000, "tolerance": 1e-8},
    }


def wait_for_block(store: Store, running: Any) -> Record:
    """Wait until a block is done and the study is still on its way."""
    give_up = time.monotonic() + END_SECONDS
    while time.monotonic() < give_up and running.poll() is None:
        records = store.page(1).records
        if records and records[0].blocks_done and records[0].state == "running":
            return records[0]
        time.sleep(0.02)
    running.kill()
    raise AssertionError("no block was seen to be done while the study ran")


@pytest.mark.night
def test_interrupted_at_the_keyboard_then_resumed_to_the_end(tmp_path: Path) -> None:
    study = tmp_path / "short.json"
    study.write_text(json.dumps(slow_study("short", 4)))
    running = start("run", study, "--data-dir", tmp_path, "--workers", "1", "--json")
    store = Store.open(tmp_path)
    seen = wait_for_block(store, running)
    os.killpg(running.pid, signal.SIGINT)
    out, err = running.communicate(timeout=END_SECONDS)
    assert running.returncode == 1, err
    assert "Traceback" not in err
    assert f"damperlab run {seen.id}" in err
    record = json.loads(out)
    assert record["state"] == "cancelled"
    assert seen.blocks_done <= record["blocks_done"] < record["blocks_total"]

    document = json.loads(run("run", "short", "--data-dir", tmp_path, "--json").stdout)
    assert document["state"] == "done"
    assert document["points_done"] == document["points_total"] == 20
    assert document["points_failed"] == 0
    assert (store.cube(seen.id).status >= 0).all()
    store.close()


@pytest.mark.night
def test_run_follows_what_a_service_computes(own_service: Callable[..., Any], tmp_path: Path) -> None:
    running = own_service()
    study = slow_study("slow", 8)
    (tmp_path / "slow.json").write_text(json.dumps(study))
    posted = httpx.post(f"{running.url}/api/v1/studies", json=study, timeout=300).raise_for_status().json()
    with closing(Store.open(tmp_path / "data")) as store:
        assert wait_for_block(store, running.process).id == posted["id"]
        delete = ("delete", posted["id"], "--yes", "--data-dir", tmp_path / "data")
        assert "Cancel it first" in run(*delete, status=1).stderr
        followed = run("run", tmp_path / "slow.json", "--data-dir", tmp_path / "data", "--json")
    assert "another process" in followed.stderr
    shown = httpx.get(f"{running.url}/api/v1/studies/{posted['id']}", timeout=300).json()
    assert (json.loads(followed.stdout), shown["state"]) == (shown, "done")
    assert running.stop() == 0


class _StopsAtTheEnd:
    """Progress that asks the process to stop once every point is there."""

    def __init__(self, points: int) -> None:
        self._points = points
        self._asked = False

    def update(self, done: int, *_: Any) -> None:
        if done == self._points and not self._asked:
            self._asked = True  # asked twice it would end at once
            signal.raise_signal(signal.SIGTERM)


@contextmanager
def stopping(points: int) -> Iterator[Any]:
    yield _StopsAtTheEnd(points)


def test_a_stop_during_the_last_block_of_a_study_holds_for_the_next_study(tmp_path: Path) -> None:
    store = Store.open(tmp_path / "data")
    first, second = (parse_study(LINEAR | {"damping_ratio": each}) for each in (0.01, 0.02))
    with Computer(store, Means()) as computer:
        one = find_or_submit(store, first, False)
        assert computer.compute(one, shown=stopping(first.points)).state == "done"
        assert computer.compute(find_or_submit(store, second, False)).state == "queued"
    # whoever asks again has it computed
    with Computer(store, Means()) as computer:
        assert computer.compute(find_or_submit(store, second, False)).state == "done"
