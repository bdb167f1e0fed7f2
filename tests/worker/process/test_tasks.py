"""What a worker does for a block, in a process of the block's own; how that ended is seen."""

import json
import os
import pickle
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import psutil
import pytest
from tests.worker.dask_processes import ROOT
from tests.worker.run_here import planned, submit

from damperlab.studies.definition import Study, parse_study
from damperlab.studies.store.store import Store
from damperlab.studies.variables import VARIABLES, Status
from damperlab.worker.block import solve_block
from damperlab.worker.cluster.cluster import connect
from damperlab.worker.dispatch.tasks import Tasks, sealed
from damperlab.worker.provenance import WrongCode, code_hash, computing
from damperlab.worker.worker_process.examination import examine
from damperlab.worker.worker_process.tasks import failed_values, run_block

CHUNK = 50


def study_of(values: int, metrics: list[str] | None = None) -> Study:
    document = {
        "name": "linear",
        "damping_ratio": 0.0,
        "axes": {"friction_ratio": 0, "frequency_ratio": [1.0 + 1e-3 * i for i in range(values)]},
        "particle": False,
    }
    return parse_study(document if metrics is None else {**document, "metrics": metrics})


def test_block_is_solved_stored_and_counted(store: Store) -> None:
    study = study_of(100)
    plan, record = planned(study, CHUNK), submit(store, study, CHUNK)
    path = store.cube_path(record.id)
    outcomes = [run_block(path, study.digest, plan.block(index), code_hash(), "g") for index in range(2)]
    # Undamped at exactly r = 1, the first point of the first block has no bounded response.
    assert [(outcome.points, outcome.failed) for outcome in outcomes] == [(50, 1), (50, 0)]
    assert all(0.0 < outcome.kernel_seconds < outcome.seconds for outcome in outcomes)
    for outcome in outcomes:
        store.mark(record.id, outcome)
    cube = store.cube(record.id)
    for index in range(2):
        block = plan.block(index)
        for name, values in solve_block(study, block).items():
            if name != "run_time":
                np.testing.assert_array_equal(cube[name].values[block.slices], values, err_msg=name)


def test_message_of_a_task_does_not_grow_with_the_study() -> None:
    sizes = []
    for values in (100, 10_000):
        study = study_of(values)
        block = planned(study, CHUNK).block(1)
        sizes.append(len(pickle.dumps((run_block, "cube", study.digest, block, code_hash(), "g"))))
    assert sizes[0] == sizes[1]


def test_other_code_and_other_studies_are_refused(store: Store, tmp_path: Path) -> None:
    study, other = study_of(100), study_of(101)
    plan, record = planned(study, CHUNK), submit(store, study, CHUNK)
    path = store.cube_path(record.id)
    with pytest.raises(WrongCode):
        run_block(path, study.digest, plan.block(0), "0" * 64, "g")
    with pytest.raises(OSError, match=other.digest):
        run_block(path, other.digest, plan.block(0), code_hash(), "g")
    with pytest.raises(FileNotFoundError):
        run_block(str(tmp_path / "none"), study.digest, plan.block(0), code_hash(), "g")


def test_failed_block_has_its_status_and_nothing_else() -> None:
    study = study_of(100)
    block = planned(study, CHUNK).block(1)
    values = failed_values(study, block)
    assert set(values) == set(study.metrics)
    for name, column in values.items():
        assert (column.shape, column.dtype) == (block.shape, np.dtype(VARIABLES[name].dtype))
        if name == "status":
            assert (column == Status.BLOCK_FAILED).all()
        else:
            np.testing.assert_array_equal(column, np.full(block.shape, VARIABLES[name].fill))


def test_a_sealed_call_can_be_made_by_who_knows_its_function_alone() -> None:
    """A worker of an earlier version then answers that it is one, and not that it lacks a module."""
    _, call = sealed(examine, "", "", "other", None)
    assert examine.__module__.encode() in call
    assert sealed.__module__.encode() not in call


@pytest.mark.night
@pytest.mark.usefixtures("anew")
def test_a_scheduler_loads_neither_solver_nor_store_for_what_workers_do() -> None:
    with connect(workers=1) as client:
        (address,) = client.nthreads()
        tasks = Tasks(client, 0)
        facts = tasks.send(tasks.key("facts"), address, (computing,)).result()
        assert facts["identity"] == computing()["identity"]
        # what it raises comes back as well
        refused = tasks.send(tasks.key("examination"), address, (examine, "", "", "other", None)).exception()
        assert type(refused).__name__ == "WrongCode"
        loaded = client.run_on_scheduler(eval, "list(__import__('sys').modules)")
    assert "distributed.scheduler" in loaded
    assert not {"numba", "pydantic", "sqlalchemy", computing.__module__, examine.__module__} & set(loaded)


CALLING = """
import json, os, signal, sys, threading, time
from pathlib import Path
from damperlab.worker.worker_process.block_process import call_apart
from damperlab.worker.outcomes import Crashed, Leaving
def said(function, *arguments):
    try:
        return ["returned", call_apart(function, *arguments)]
    except Exception as error:
        return [type(error).__name__, str(error)]
"""


def start(code: str) -> "subprocess.Popen[str]":
    """A process that stands in for a worker."""
    environment = {**os.environ, "PYTHONPATH": f"{ROOT / 'src'}"}
    command = [sys.executable, "-c", CALLING + code]
    return subprocess.Popen(command, env=environment, text=True, stdout=subprocess.PIPE)


def told(code: str) -> Any:
    with start(code) as process:
        out, _ = process.communicate(timeout=900)
    assert process.returncode == 0
    return json.loads(out.splitlines()[-1])


def test_a_call_ends_as_it_would_here_and_how_its_process_ended_is_seen() -> None:
    def kill(number: int) -> str:
        return f"said(lambda: os.kill(os.getpid(), {number}))"

    found = told(
        f"""
def talk():
    print("no part of the answer", flush=True)
    return os.getpid()
print(json.dumps([
    said(talk), os.getpid(), said(int, "x"), said(bytes.hex, b"0" * 1_000_000),
    {kill(signal.SIGKILL)}, {kill(signal.SIGSEGV)}, said(lambda: os._exit(3)), {kill(signal.SIGTERM)}, said(abs, -1),
]))""",
    )
    (how, other), own, refused, long, killed, crashed, left, ended, after = found
    assert how == "returned"
    assert other != own
    assert refused == ["ValueError", "invalid literal for int() with base 10: 'x'"]
    assert long == ["returned", "30" * 1_000_000]
    assert killed[0] == crashed[0] == left[0] == "Crashed"
    assert "by SIGKILL" in killed[1]
    assert "by SIGSEGV" in crashed[1]
    assert "with status 3" in left[1]
    assert ended == ["Leaving", "the process of a block was ended by SIGTERM"]
    assert after == ["returned", 1]


@pytest.mark.parametrize("number", [signal.SIGKILL, pytest.param(signal.SIGTERM, marks=pytest.mark.night)])
def test_no_process_outlives_its_worker(number: int, tmp_path: Path) -> None:
    sign = tmp_path / "begun"
    with start(f"said(lambda: (Path({str(sign)!r}).touch(), time.sleep(600)))") as process:
        deadline = time.monotonic() + 900.0
        while not sign.exists():
            assert time.monotonic() < deadline
            time.sleep(0.02)
        beside = psutil.Process(process.pid).children(recursive=True)
        assert len(beside) == 1
        process.send_signal(number)
        process.wait()
        _, alive = psutil.wait_procs(beside, timeout=900)
        assert not alive
