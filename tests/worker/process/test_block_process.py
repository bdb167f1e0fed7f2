"""Blocks in processes of their own."""

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
