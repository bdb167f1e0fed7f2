"""Commands in processes of their own that need not load every library first: most of what a short command takes.

A process that has loaded libraries, and nothing of damperlab, waits for commands. For each it forks a child, which is what it
would be as a process started anew: its own arguments, environment, folder, streams and exit status, and damperlab loaded by
itself. What a command loads, and that it starts at all, is tested with processes that are started anew.
"""

import atexit
import gc
import json
import os
import runpy
import signal
import socket
import subprocess
import sys
from contextlib import suppress
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import IO, Any

ROOT = Path(__file__).parents[1]
LIBRARIES = (
    "alembic.command",
    "cryptography.x509",
    "dask.array",
    "distributed",
    "fastapi",
    "h5netcdf",
    "matplotlib.backends.backend_agg",
    "numba.np.arraymath",
    "pydantic_settings",
    "rich.console",
    "sqlalchemy.dialects.postgresql",
    "sqlalchemy.dialects.sqlite",
    "typer",
    "uvicorn.protocols.http.h11_impl",
    "xarray",
)
"""What commands load of others. None of it starts a thread that a fork would lose: OpenBLAS starts its own again."""
_SIZE = 1 << 20


class Ready:
    """The process that waits, one for each process of tests."""

    def __init__(self) -> None:
        self._socket, other = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        with other:
            self._process = subprocess.Popen(
                [sys.executable, "-m", "tests.ready", str(other.fileno())],
                cwd=ROOT,
                pass_fds=[other.fileno()],
            )
        atexit.register(self.close)

    def close(self) -> None:
        """End the process, which is idle."""
        self._socket.close()
        self._process.wait()

    def start(
        self,
        module: str,
        arguments: list[str],
        environment: dict[str, str],
        out: int | IO[Any] | None = None,
        err: int | IO[Any] | None = None,
    ) -> "Started":
        """Start a module as ``python -m`` does, without input; streams that are not given are those of this process."""
        command = {
            "module": module,
            "arguments": arguments,
            "environment": environment,
            "folder": str(Path.cwd()),
        }
        here, there = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        with Path(os.devnull).open("rb") as nothing, there:
            streams = [
                default if stream is None else stream if isinstance(stream, int) else stream.fileno()
                for stream, default in ((nothing, 0), (out, 1), (err, 2))
            ]
            socket.send_fds(self._socket, [json.dumps(command).encode()], [*streams, there.fileno()])
        return Started([module, *arguments], here)

    def run(
        self, module: str, arguments: list[str], environment: dict[str, str], seconds: float
    ) -> subprocess.CompletedProcess[str]:
        """Run a module to its end and collect what it prints.

        Raises
        ------
        subprocess.TimeoutExpired
            It took longer than that; it is killed.
        """
        with _Stream() as out, _Stream() as err:
            started = self.start(module, arguments, environment, out.descriptor, err.descriptor)
            try:
                status = started.wait(seconds)
            finally:
                started.kill()
                started.wait()
            return subprocess.CompletedProcess(started.args, status, out.text(), err.text())


class Started:
    """A command that was started, with what `subprocess.Popen` calls the same.

    Parameters
    ----------
    args : list of str
        Module and arguments.
    told : socket
        What tells the id of its process, and then its exit status.
    """

    def __init__(self, args: list[str], told: socket.socket) -> None:
        self.args = args
        self.pid = int(told.recv(_SIZE))
        self.returncode: int | None = None
        self._told = told

    def poll(self) -> int | None:
        """Exit status; None while it runs."""
        try:
            return self.wait(0.0)
        except subprocess.TimeoutExpired:
            return None

    def wait(self, timeout: float | None = None) -> int:
        """Exit status, once it has ended.

        Raises
        ------
        subprocess.TimeoutExpired
            It runs for longer than `timeout` [s].
        """
        if self.returncode is None:
            self._told.settimeout(timeout)
            try:
                self.returncode = int(self._told.recv(_SIZE))
            except (TimeoutError, BlockingIOError):
                raise subprocess.TimeoutExpired(self.args, timeout or 0.0) from None
            self._told.close()
        return self.returncode

    def send_signal(self, number: int) -> None:
        """Send it a signal, where it runs."""
        if self.poll() is None:
            os.kill(self.pid, number)

    def kill(self) -> None:
        """Kill it, where it runs."""
        self.send_signal(signal.SIGKILL)


class _Stream:
    """A file in memory that a process writes to: a pipe would have to be emptied meanwhile."""

    def __init__(self) -> None:
        self.descriptor = os.memfd_create("stream")

    def __enter__(self) -> "_Stream":
        return self

    def __exit__(self, *_: object) -> None:
        os.close(self.descriptor)

    def text(self) -> str:
        """What was written, with line ends as text streams have them."""
        size = os.fstat(self.descriptor).st_size
        return os.pread(self.descriptor, size, 0).decode().replace("\r\n", "\n")


@cache
def ready() -> Ready:
    """The one of this process."""
    return Ready()


def _serve(connection: socket.socket) -> dict[str, Any] | None:
    """Fork a child for each command, in which this returns the command; None when nobody asks any more.

    Between the two stands a process that waits for the child and tells how it ended, so that this one is free again.
    """
    while True:
        told, descriptors, _, _ = socket.recv_fds(connection, _SIZE, 4)
        if not told:
            return None
        signal.signal(signal.SIGCHLD, signal.SIG_IGN)  # nobody asks how those that wait have ended
        if os.fork() != 0:
            for each in descriptors:
                os.close(each)
            continue
        signal.signal(signal.SIGCHLD, signal.SIG_DFL)
        connection.close()
        child = os.fork()
        *streams, asked = descriptors
        if child == 0:
            os.close(asked)
            for place, stream in enumerate(streams):
                os.dup2(stream, place)
                os.close(stream)
            return dict(json.loads(told))
        for place in (0, 1, 2, *streams):
            os.close(place)
        with socket.socket(fileno=asked) as asking:
            asking.send(str(child).encode())
            status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
            with suppress(OSError):  # nobody may ask any more
                asking.send(str(status).encode())
        os._exit(0)


if __name__ == "__main__":
    for name in LIBRARIES:
        import_module(name)
    gc.freeze()  # what is loaded stays: a child need not look through it, which would copy its pages
    command = _serve(socket.socket(fileno=int(sys.argv[1])))
    if command is not None:
        os.environ.clear()
        os.environ.update(command["environment"])
        import_module("dask").config.refresh()
        import_module("numba").config.reload_config()
        os.chdir(command["folder"])
        sys.path[0] = command["folder"]
        sys.argv[1:] = command["arguments"]
        runpy.run_module(command["module"], run_name="__main__", alter_sys=True)
