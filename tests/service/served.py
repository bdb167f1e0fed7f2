"""`damperlab serve` whose processes that compute for requests are forked from the one that has loaded everything.

Started anew, each of them loads every library first: most of what a short answer takes. They do not end with a service that is
killed; tests of that have their service started anew (fixture `anew`).
"""

import io
import os
import runpy
import socket
import sys
from contextlib import suppress
from pathlib import Path
from typing import Any

import anyio
from anyio import to_process
from anyio.abc import UNIXSocketStream
from tests.ready import Ready, Started, alike, ready

HERE = "tests.service.served"
COMPUTES = "a process computes for requests: "
"""What the log of a service says of each, before its id and when it began."""


def began(pid: int) -> str:
    """When a process began, in ticks: tells it from an earlier one of the same id; nothing if it is gone."""
    with suppress(OSError):
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[19]
    return ""


def start(environment: dict[str, str], out: Any) -> Started:
    """Start the service; what it prints goes to a file."""
    if alike(environment):
        return ready().loaded.fork(HERE, ["serve"], environment, out=out, err=out)
    return ready().start("damperlab", ["serve"], environment, out, out)


class Computing:
    """What `anyio` asks of a process; it is spoken to over a socket.

    Parameters
    ----------
    process : Started
        The process.
    stream : UNIXSocketStream
        Its input and its output.
    """

    def __init__(self, process: Started, stream: UNIXSocketStream) -> None:
        self.process = process
        self.stdin = self.stdout = stream

    @property
    def returncode(self) -> int | None:
        return self.process.poll()

    def kill(self) -> None:
        self.process.kill()

    async def aclose(self) -> None:
        await self.stdin.aclose()
        while self.returncode is None:
            await anyio.sleep(0.005)


async def _open_process(command: object, **streams: object) -> Computing:
    """Take the place of what `anyio` starts an interpreter with."""
    here, there = socket.socketpair()
    with there:
        process = _from().fork(HERE, ["compute"], dict(os.environ), given=there, out=there)
    sys.stderr.write(f"{COMPUTES}{process.pid} {began(process.pid)}\n")
    return Computing(process, await UNIXSocketStream.from_socket(here))


def _from() -> Ready:
    """The process that this one was forked from."""
    from damperlab.worker.cluster import scheduler

    given: Ready = scheduler._started.args[0]()  # type: ignore[attr-defined]
    return given


def main() -> None:
    """Be a service, or compute for one."""
    if sys.argv[1] == "compute":
        # as `python -u` has it
        sys.stdout = io.TextIOWrapper(io.FileIO(1, "wb"), write_through=True)
        to_process.process_worker()
    else:
        to_process.open_process = _open_process  # type: ignore[assignment]
        runpy.run_module("damperlab", run_name="__main__", alter_sys=True)


if __name__ == "__main__":
    main()
