"""Dask's own commands as processes on loopback, for tests that need a cluster of somebody else."""

import os
import re
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

ROOT = Path(__file__).parents[2]


@contextmanager
def dask_process(*arguments: str, cwd: Path = ROOT) -> Iterator[subprocess.Popen[str]]:
    environment = {**os.environ, "PYTHONPATH": str(cwd)}
    process = subprocess.Popen(
        [sys.executable, "-m", "dask", *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        env=environment,
        cwd=cwd,
    )
    try:
        yield process
    finally:
        process.kill()
        process.wait()
        assert process.stdout is not None
        process.stdout.close()


@contextmanager
def scheduler_process() -> Iterator[tuple[str, subprocess.Popen[str]]]:
    with dask_process("scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard") as process:
        assert process.stdout is not None
        for line in process.stdout:
            if found := re.search(r"Scheduler at:\s+(tcp://\S+)", line):
                # What it still prints must not fill the pipe.
                threading.Thread(target=process.stdout.read, daemon=True).start()
                yield found.group(1), process
                return
        raise AssertionError("the scheduler ended before it listened")
