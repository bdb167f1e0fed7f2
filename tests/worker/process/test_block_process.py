"""Blocks in processes of their own: started anew, and forked from one that waits beside a worker."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import psutil
import pytest
from tests.worker.dask_processes import ROOT

BOTH = pytest.mark.parametrize("forked", [False, True], ids=["anew", "forked"])
CALLING = """
import json, os, signal, sys, threading, time
from pathlib import Path
from damperlab.worker.worker_process.block_process import call_apart, stand_by
from damperlab.worker.outcomes import Crashed, Leaving
if {forked}:
    stand_by()
def said(function, *arguments):
    try:
        return ["returned", call_apart(function, *arguments)]
    except Exception as error:
        return [type(error).__name__, str(error)]
"""


def start(forked: bool, code: str) -> "subprocess.Popen[str]":
    """A process that stands in for a worker."""
    environment = {**os.environ, "PYTHONPATH": f"{ROOT / 'src'}"}
    command = [sys.executable, "-c", CALLING.replace("{forked}", str(forked)) + code]
    return subprocess.Popen(command, env=environment, text=True, stdout=subprocess.PIPE)


def told(forked: bool, code: str) -> Any:
    with start(forked, code) as process:
        out, _ = process.communicate(timeout=900)
    assert process.returncode == 0
    return json.loads(out.splitlines()[-1])


@BOTH
def test_a_call_ends_as_it_would_here_and_how_its_process_ended_is_seen(forked: bool) -> None:
    def kill(number: int) -> str:
        return f"said(lambda: os.kill(os.getpid(), {number}))"

    found = told(
        forked,
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


def test_a_process_beside_a_worker_has_loaded_what_a_block_needs() -> None:
    """And where the one that waits is gone, a process is started anew."""
    found = told(
        True,
        """
def loaded():
    return "damperlab.worker.worker_process.tasks" in sys.modules, os.getppid()
first = said(loaded)
def end_the_one_that_waits():
    keeper = os.getppid()
    waiting = int(Path(f"/proc/{keeper}/stat").read_text().rsplit(")")[1].split()[1])
    os.kill(waiting, signal.SIGKILL)
    return waiting
waiting = said(end_the_one_that_waits)[1]
os.waitpid(waiting, 0)
print(json.dumps([first, said(loaded)]))""",
    )
    ((_, (first, _)), (how, (second, _))) = found
    assert (first, how, second) == (True, "returned", False)


@pytest.mark.parametrize(
    ("forked", "number"),
    [
        (True, signal.SIGKILL),
        *(
            pytest.param(forked, number, marks=pytest.mark.night)
            for forked, number in ((True, signal.SIGTERM), (False, signal.SIGKILL), (False, signal.SIGTERM))
        ),
    ],
)
def test_no_process_outlives_its_worker(forked: bool, number: int, tmp_path: Path) -> None:
    sign = tmp_path / "begun"
    with start(forked, f"said(lambda: (Path({str(sign)!r}).touch(), time.sleep(600)))") as process:
        deadline = time.monotonic() + 900.0
        while not sign.exists():
            assert time.monotonic() < deadline
            time.sleep(0.02)
        beside = psutil.Process(process.pid).children(recursive=True)
        assert len(beside) == (3 if forked else 1)
        process.send_signal(number)
        process.wait()
        _, alive = psutil.wait_procs(beside, timeout=900)
        assert not alive
