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
from typing import IO

from tests.ready import Started, alike, ready

ROOT = Path(__file__).parents[2]


@contextmanager
def dask_process(
    command: str, *arguments: str, cwd: Path = ROOT, hidden: Path | None = None, anew: bool = False
) -> Iterator["subprocess.Popen[str] | Started"]:
    """Dask's `scheduler` or `worker`; `hidden` is a folder that it shall not see, by a mount of its own.

    It is forked from a process that has loaded it, where it shall see what this one sees and need not be started anew.
    """
    process: subprocess.Popen[str] | Started
    if not anew and cwd == ROOT and hidden is None and alike(dict(os.environ)):
        read, write = os.pipe()
        module = f"distributed.cli.dask_{command}"
        process = ready().loaded.fork(
            module, list(arguments), dict(os.environ), out=write, err=write, folder=ROOT
        )
        os.close(write)
        process.stdout = os.fdopen(read)
    else:
        process = _started_anew([sys.executable, "-m", "dask", command, *arguments], cwd, hidden)
    with ended(process):
        yield process


def _started_anew(command: list[str], cwd: Path, hidden: Path | None) -> "subprocess.Popen[str]":
    if hidden is not None:
        cover = f"mount -t tmpfs tmpfs {shlex.quote(str(hidden))} && exec {shlex.join(command)}"
        command = ["unshare", "--map-root-user", "--mount", "sh", "-c", cover]
    environment = {**os.environ, "PYTHONPATH": str(cwd)}
    return subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, env=environment, cwd=cwd
    )


@contextmanager
def ended(process: "subprocess.Popen[str] | subprocess.Popen[bytes] | Started") -> Iterator[None]:
    """End a process at the end of a block."""
    try:
        yield
    finally:
        process.kill()
        process.wait()
        if process.stdout is not None:
            process.stdout.close()


@contextmanager
def scheduler_process(
    *options: str, anew: bool = False
) -> Iterator[tuple[str, "subprocess.Popen[str] | Started"]]:
    always = ("--host", "127.0.0.1", "--port", "0", "--no-dashboard")
    with dask_process("scheduler", *always, *options, anew=anew) as process:
        for line in process.stdout:
            if found := re.search(r"Scheduler at:\s+(t(?:cp|ls)://\S+)", str(line)):
                # What it still prints must not fill the pipe.
                threading.Thread(target=process.stdout.read, daemon=True).start()
                yield found.group(1), process
                return
        raise AssertionError("the scheduler ended before it listened")


@contextmanager
def worker_process(
    address: str, *options: str, stderr: IO[bytes] | None = None
) -> Iterator["subprocess.Popen[bytes] | Started"]:
    """`damperlab admin worker`, forked from a process that has loaded it."""
    arguments = ["admin", "worker", address, *options]
    process: subprocess.Popen[bytes] | Started
    if alike(dict(os.environ)):
        process = ready().loaded.fork("damperlab", arguments, dict(os.environ), err=stderr, folder=ROOT)
    else:
        environment = {**os.environ, "PYTHONPATH": str(ROOT)}
        command = [sys.executable, "-m", "damperlab", *arguments]
        process = subprocess.Popen(command, cwd=ROOT, env=environment, stderr=stderr)
    with ended(process):
        yield process
