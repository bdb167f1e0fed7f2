"""A study goes on while everything that computes it is replaced by another version: first the service, then the workers."""

import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import pytest
from tests.worker.dask_processes import ROOT, scheduler_process
from tests.worker.run_here import of_one_piece, submit

from damperlab.studies.definition import parse_study
from damperlab.studies.store.store import Store

pytestmark = pytest.mark.night

HANGS_SECONDS = 300.0
BLOCKS = 24


@contextmanager
def damperlab(version: Path, *arguments: object) -> Iterator[subprocess.Popen[bytes]]:
    """A command of one version."""
    command = [sys.executable, "-m", "damperlab", *map(str, arguments)]
    environment = {**os.environ, "PYTHONPATH": str(version)}
    process = subprocess.Popen(command, cwd=version, env=environment)
    try:
        yield process
    finally:
        process.kill()
        process.wait()


def earlier_version(folder: Path) -> Path:
    """Other code with the same solver, and slower, so that it is met in the middle of its work."""
    shutil.copytree(
        ROOT / "src" / "damperlab", folder / "damperlab", ignore=shutil.ignore_patterns("kernels")
    )
    source = folder / "damperlab" / "worker" / "provenance.py"
    text = source.read_text()
    begin = "def require_code("
    assert text.count(begin) == 1
    slow = "\n\ndef require_code(code: str) -> None:\n    import time\n\n    time.sleep(1.0)\n    _require_code(code)\n"
    source.write_text(text.replace(begin, "def _require_code(") + slow)
    return folder


def until(true: Callable[[], bool], *processes: subprocess.Popen[bytes]) -> None:
    deadline = time.monotonic() + HANGS_SECONDS
    while not true():
        assert time.monotonic() < deadline
        assert [process.poll() for process in processes] == [None] * len(processes)
        time.sleep(0.1)


def told_to_end(process: subprocess.Popen[bytes]) -> int:
    process.send_signal(signal.SIGTERM)
    return process.wait(HANGS_SECONDS)


def test_service_and_workers_are_replaced_while_a_study_runs(tmp_path: Path) -> None:
    old, new = earlier_version(tmp_path / "old"), ROOT
    axes = {
        "friction_ratio": {"start": 0.1, "stop": 0.6, "num": BLOCKS},
        "frequency_ratio": {"start": 0.7, "stop": 1.3, "num": 12},
    }
    study = parse_study({"damping_ratio": 0.05, "axes": axes, "particle": False})
    data = tmp_path / "data"
    store = Store.open(data)
    record = submit(store, study, 12)

    def done() -> int:
        return store.find(record.id).blocks_done

    def left_out() -> bool:
        return any("is left out: " in what and "sources" in what for _, what in store.events(record.id))

    with ExitStack() as stack:
        address, _ = stack.enter_context(scheduler_process())
        serve = "serve", "--port=0", f"--data-dir={data}", f"--scheduler={address}"
        service = stack.enter_context(damperlab(old, *serve))
        worker = stack.enter_context(damperlab(old, "admin", "worker", address))
        until(lambda: done() > 0, service, worker)
        assert told_to_end(service) == 0
        kept = done()
        assert 0 < kept < BLOCKS
        assert store.find(record.id).state == "queued"

        service = stack.enter_context(damperlab(new, *serve))
        # the worker of the other version is named, and waits for somebody of its own
        until(left_out, service, worker)
        assert done() == kept
        newer = stack.enter_context(damperlab(new, "admin", "worker", address))
        until(lambda: done() > kept, service, worker, newer)
        assert told_to_end(worker) == 0
        until(lambda: store.find(record.id).state != "running", service, newer)
        assert told_to_end(service) == 0
        assert told_to_end(newer) == 0
    ended = store.find(record.id)
    assert (ended.state, ended.points_failed, ended.blocks_done) == ("done", 0, BLOCKS)
    assert of_one_piece(store, record.id, study)
    store.close()
