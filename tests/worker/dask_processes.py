"""Dask's own commands as processes on loopback, for tests that need a cluster of somebody else."""

import os
import re
import shlex
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

ROOT = Path(__file__).parents[2]


@contextmanager
def dask_process(
    *arguments: str, cwd: Path = ROOT, hidden: Path | None = None
) -> Iterator[subprocess.Popen[str]]:
    """One of Dask's commands; `hidden` is a folder that it shall not see, by a mount of its own."""
    command = [sys.executable, "-m", "dask", *arguments]
    if hidden is not None:
        cover = f"mount -t tmpfs tmpfs {shlex.quote(str(hidden))} && exec {shlex.join(command)}"
        command = ["unshare", "--map-root-user", "--mount", "sh", "-c", cover]
    environment = {**os.environ, "PYTHONPATH": str(cwd)}
    process = subprocess.Popen(
        command,
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
def scheduler_process(*options: str) -> Iterator[tuple[str, subprocess.Popen[str]]]:
    always = ("--host", "127.0.0.1", "--port", "0", "--no-dashboard")
    with dask_process("scheduler", *always, *options) as process:
        assert process.stdout is not None
        for line in process.stdout:
            if found := re.search(r"Scheduler at:\s+(t(?:cp|ls)://\S+)", line):
                # What it still prints must not fill the pipe.
                threading.Thread(target=process.stdout.read, daemon=True).start()
                yield found.group(1), process
                return
        raise AssertionError("the scheduler ended before it listened")


@contextmanager
def worker_process(
    address: str, *options: str, stderr: int | None = None
) -> Iterator[subprocess.Popen[bytes]]:
    """`damperlab admin worker`."""
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    process = subprocess.Popen(
        [sys.executable, "-m", "damperlab", "admin", "worker", address, *options],
        cwd=ROOT,
        env=environment,
        stderr=stderr,
    )
    try:
        yield process
    finally:
        process.kill()
        process.wait()
