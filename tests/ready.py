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
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[1]
LIBRARIES = (
    "dask.array",
    "h5netcdf",
    "matplotlib.backends.backend_agg",
    "numba.np.arraymath",
    "pydantic_settings",
    "rich.console",
    "sqlalchemy.dialects.postgresql",
    "sqlalchemy.dialects.sqlite",
    "typer",
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

    def run(
        self, module: str, arguments: list[str], environment: dict[str, str], seconds: float
    ) -> subprocess.CompletedProcess[str]:
        """Run a module as ``python -m`` does, without input, and collect what it prints.

        Raises
        ------
        TimeoutError
            It took longer than that; it is killed.
        """
        command = {
            "module": module,
            "arguments": arguments,
            "environment": environment,
            "folder": str(Path.cwd()),
        }
        with Path(os.devnull).open("rb") as nothing, _Stream() as out, _Stream() as err:
            streams = [nothing.fileno(), out.descriptor, err.descriptor]
            socket.send_fds(self._socket, [json.dumps(command).encode()], streams)
            child = int(self._socket.recv(_SIZE))
            self._socket.settimeout(seconds)
            try:
                status = int(self._socket.recv(_SIZE))
            except TimeoutError:
                os.kill(child, signal.SIGKILL)
                self._socket.settimeout(None)
                self._socket.recv(_SIZE)
                raise
            finally:
                self._socket.settimeout(None)
            return subprocess.CompletedProcess([module, *arguments], status, out.text(), err.text())


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
    """Fork a child for each command, in which this returns the command; None when nobody asks any more."""
    while True:
        told, streams, _, _ = socket.recv_fds(connection, _SIZE, 3)
        if not told:
            return None
        child = os.fork()
        if child == 0:
            for place, stream in enumerate(streams):
                os.dup2(stream, place)
                os.close(stream)
            connection.close()
            return dict(json.loads(told))
        for stream in streams:
            os.close(stream)
        connection.send(str(child).encode())
        connection.send(str(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])).encode())


if __name__ == "__main__":
    for name in LIBRARIES:
        import_module(name)
    gc.freeze()  # what is loaded stays: a child need not look through it, which would copy its pages
    command = _serve(socket.socket(fileno=int(sys.argv[1])))
    if command is not None:
        os.environ.clear()
        os.environ.update(command["environment"])
        os.chdir(command["folder"])
        sys.path[0] = command["folder"]
        sys.argv[1:] = command["arguments"]
        runpy.run_module(command["module"], run_name="__main__", alter_sys=True)
