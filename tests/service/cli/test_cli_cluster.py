"""Commands that compute in jobs of a batch system, and a service whose workers are jobs."""

import json
import os
import signal
import time
from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest
from tests.batch_system import LASTING, make_queue, running, wait_until_ended
from tests.service.cli.commands import run
from tests.service.cli.test_cli_design import SPECIFICATION
from tests.worker.run_here import give_up, planned, submit

from damperlab import Client
from damperlab.studies.definition import Study, parse_study
from damperlab.studies.store.record import Record
from damperlab.studies.store.store import Store
from damperlab.studies.variables import Status
from damperlab.worker.block import solve_block
from damperlab.worker.worker_process.examination import bits_of

pytestmark = pytest.mark.night

FRICTION: dict[str, Any] = {
    "particle": False,
    "damping_ratio": 0.05,
    "axes": {
        "friction_ratio": {"start": 0.5, "stop": 1.1, "num": 4},
        "frequency_ratio": [0.9, 1.0, 1.1, 1.2],
    },
}
WORK_SECONDS = 3000.0


@pytest.fixture
def queue(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    return make_queue(tmp_path, monkeypatch)


@pytest.fixture
def store(tmp_path: Path) -> Iterator[Store]:
    with closing(Store.open(tmp_path / "data")) as opened:
        yield opened


def submitted(store: Store, study: Study, failed: int, **facts: str) -> Record:
    """A study of which one block was given up, and no other is computed."""
    record = submit(store, study, (1, 1, 1, 1, 4, 4), **facts)
    give_up(store, record, study, failed)
    return record


def jobs(queue: Path) -> int:
    return len(list(queue.glob("*.sh")))


def test_what_is_computed_again_is_computed_in_jobs(store: Store, queue: Path) -> None:
    data = ("--data-dir", store.data_dir, "--workers", "1")
    long = {**FRICTION, "axes": {**FRICTION["axes"], "friction_ratio": {"start": 0.5, "stop": 1.1, "num": 8}}}
    record = submitted(store, parse_study({**long, "name": "again"}), 1)
    assert record.blocks_total == 2
    run("run", record.id, *data, "--cluster", "slurm")
    assert (store.find(record.id).points_failed, jobs(queue)) == (16, 1)
    run("run", record.id, "--retry", *data, "--cluster", "slurm", "--wait", "200")
    assert (store.find(record.id).points_failed, jobs(queue)) == (0, 2)
    assert (store.cube(record.id)["status"] == Status.CONVERGED).all()
    before = store.cube(record.id).load()
    file = next(Path(store.cube_path(record.id), "blocks").iterdir())
    file.write_bytes(file.read_bytes()[:40])
    run("store", "verify", record.id, "--repair", *data, "--cluster", "slurm")
    assert jobs(queue) == 3
    assert store.cube(record.id).load().drop_vars("run_time").equals(before.drop_vars("run_time"))
    other = {"solver": "0" * 16, "identity": "0" * 16}
    older = submitted(store, parse_study({**FRICTION, "name": "older"}), 0, **other)
    run("recompute", older.id, *data, "--cluster", "slurm")
    newest = store.newest(older.digest)
    assert newest is not None
    assert (newest.id, newest.state, jobs(queue)) == (f"{older.id}-2", "done", 4)
    wait_until_ended(queue)


def test_a_study_its_follow_ups_and_those_of_a_design_are_computed_in_jobs(
    tmp_path: Path, queue: Path
) -> None:
    data = ("--data-dir", tmp_path / "data")
    slurm = ("--cluster", "slurm", "--workers", "1")
    (tmp_path / "locking.json").write_text(json.dumps({**FRICTION, "name": "locking"}))
    run("run", tmp_path / "locking.json", *data, *slurm, "--wait", "200")
    assert jobs(queue) == 1
    asked = ["refine", "locking", "--tolerance", "0.01", *data]
    found = json.loads(run(*asked, *slurm, "--json").stdout)
    assert (found["known"], bool(found["with"]), jobs(queue)) == (True, True, 2)
    (tmp_path / "spec.json").write_text(json.dumps(SPECIFICATION))
    answer = run("design", tmp_path / "spec.json", *data, *slurm, "--json")
    assert json.loads(answer.stdout)["worst"]["value"] <= 0.005
    assert jobs(queue) == 3
    wait_until_ended(queue)
    refused = run(*asked, "--cluster", "slurm", "--scheduler", "tcp://127.0.0.1:8786", status=2)
    assert "cannot be combined" in refused.stderr


def test_service_has_jobs_as_there_is_work_and_outlives_them(
    own_service: Callable[..., Any], tmp_path: Path, queue: Path
) -> None:
    service = own_service(DAMPERLAB_CLUSTER="slurm", DAMPERLAB_WORKERS="2")
    assert jobs(queue) == 0
    with Client(service.url) as client:
        study = client.submit(LASTING)
        deadline = time.monotonic() + WORK_SECONDS
        while not study.record.blocks_done:
            assert time.monotonic() < deadline
            time.sleep(0.2)
        # every job is killed, as where a partition is taken out of service
        for pid in running(queue):
            os.killpg(pid, signal.SIGKILL)
        assert study.wait().state == "done"
    assert jobs(queue) > 1
    assert service.stop() == 0
    wait_until_ended(queue)
    assert not list((tmp_path / "data" / "jobs").rglob("*.pem"))
    asked = parse_study(LASTING)
    whole = solve_block(asked, planned(asked, asked.shape).block(0))
    with closing(Store.open(tmp_path / "data")) as store:
        record = store.find("lasting")
        assert record.points_failed == 0
        assert bits_of(whole) == bits_of({name: store.cube(record.id)[name].values for name in whole})
