"""Commands in processes of their own that need not load everything first: most of what a short command takes.

A process that has loaded libraries and damperlab waits for commands. For each it forks a child, which is what it would be as
a process started anew: its own arguments, environment, folder, streams and exit status. What such a command starts of its
own, a scheduler and workers, is forked from the same process (`spawning`). What a command loads, and that it starts at all, is
tested with processes that are started anew.
"""

import atexit
import gc
import json
import os
import runpy
import selectors
import signal
import socket
import subprocess
import sys
import threading
import weakref
from collections.abc import Sequence
from contextlib import suppress
from functools import cache, cached_property
from importlib import import_module
from pathlib import Path
from typing import IO, Any

ROOT = Path(__file__).parents[1]
LIBRARIES = (
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
DAMPERLAB = (
    "damperlab.service.app",
    "damperlab.service.cli.main",
    "damperlab.service.design_report",
    "damperlab.service.questions.needed",
    "damperlab.worker.worker_process.tasks",
)
"""What they load of damperlab, where the variables that it is loaded by are those of the tests."""
LOADED_BY = ("DAMPERLAB_CACHE_DIR", "DAMPERLAB_TARGET", "HOME", "NUMBA_", "PYTHON", "XDG_", "TESTS_")
"""How variables begin that are read as damperlab or a library is loaded, and those of the tests."""
NO_MATTER = {"NUMBA_NUM_THREADS", "PYTHONHASHSEED"}
"""Those of them that Dask sets for workers: no kernel has threads, and nothing depends on the order of sets."""
_SIZE = 1 << 20
_first = dict(os.environ)
"""As this process began: a test may have changed what it starts its own processes with."""


class Ready:
    """A process that waits.

    Parameters
    ----------
    connection : socket
        To it.
    """

    def __init__(self, connection: socket.socket) -> None:
        self.connection = connection

    @cached_property
    def loaded(self) -> "Ready":
        """One that has loaded damperlab too, started by this one."""
        here, there = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        with there:
            process = self.fork("tests.ready", ["damperlab"], _first, given=there, folder=ROOT)
        atexit.register(process.told.close)
        atexit.register(here.close)
        return Ready(here)

    @classmethod
    def anew(cls) -> "Ready":
        """One with the libraries alone, started; it ends with this process."""
        here, there = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        with there:
            process = subprocess.Popen(
                [sys.executable, "-m", "tests.ready"],
                cwd=ROOT,
                stdin=there,
                env={**_first, "OPENBLAS_NUM_THREADS": "1"},
            )
        atexit.register(process.wait)
        atexit.register(here.close)
        return cls(here)

    def start(
        self,
        module: str,
        arguments: list[str],
        environment: dict[str, str],
        out: int | IO[Any] | None = None,
        err: int | IO[Any] | None = None,
    ) -> "Started":
        """Start a module as ``python -m`` does, without input; streams that are not given are those of this process."""
        best = self.loaded if module.startswith("damperlab") and alike(environment) else self
        return best.fork(module, arguments, environment, out=out, err=err)

    def fork(
        self,
        module: str,
        arguments: list[str],
        environment: dict[str, str],
        *,
        given: int | IO[Any] | socket.socket | None = None,
        out: int | IO[Any] | None = None,
        err: int | IO[Any] | None = None,
        passed: Sequence[int] = (),
        folder: Path | None = None,
        session: bool = False,
    ) -> "Started":
        """Start a module in a child of that process.

        Parameters
        ----------
        module : str
            Its name.
        arguments : list of str
            What stands in `sys.argv`.
        environment : dict
            All of its variables.
        given, out, err : int or file, optional
            Its streams: no input, and those of this process, where they are left out.
        passed : sequence of int
            Descriptors that it shall have too; their numbers stand behind its arguments.
        folder : Path, optional
            Where it runs; by default where this process does.
        session : bool
            Whether it begins a session, so that no signal to this process's group reaches it.
        """
        command = {
            "module": module,
            "arguments": arguments,
            "environment": environment,
            "folder": str(folder or Path.cwd()),
            "umask": _umask(),
            "session": session,
        }
        here, there = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        with Path(os.devnull).open("rb") as nothing, there:
            streams = [
                default if stream is None else stream if isinstance(stream, int) else stream.fileno()
                for stream, default in ((nothing if given is None else given, 0), (out, 1), (err, 2))
            ]
            everything = [*streams, there.fileno(), *passed]
            socket.send_fds(self.connection, [json.dumps(command).encode()], everything)
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

    stdin: IO[bytes] | None = None
    stdout: IO[bytes] | None = None

    def __init__(self, args: list[str], told: socket.socket) -> None:
        self.args = args
        self.pid = int(told.recv(_SIZE))
        self.returncode: int | None = None
        self.told = told
        weakref.finalize(self, told.close)  # nobody need ask how it ended

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
            self.told.settimeout(timeout)
            try:
                self.returncode = int(self.told.recv(_SIZE))
            except (TimeoutError, BlockingIOError):
                raise subprocess.TimeoutExpired(self.args, timeout or 0.0) from None
            self.told.close()
        return self.returncode

    def send_signal(self, number: int) -> None:
        """Send it a signal, where it runs."""
        if self.poll() is None:
            with suppress(ProcessLookupError):  # it has ended meanwhile
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
    return Ready.anew()


def _umask() -> int:
    """What this process keeps from others in files that it makes; asking the system for it would set it."""
    return int(Path("/proc/self/status").read_text().partition("Umask:")[2].split()[0], 8)


def loaded_by(environment: dict[str, str]) -> dict[str, str]:
    """Those of an environment's variables that are read as damperlab or a library is loaded."""
    return {
        name: value
        for name, value in environment.items()
        if name.startswith(LOADED_BY) and name not in NO_MATTER
    }


def alike(environment: dict[str, str]) -> bool:
    """Whether damperlab is loaded in an environment as it was in that of this process when that began."""
    return loaded_by(environment) == loaded_by(_first)


def _serve(first: socket.socket) -> dict[str, Any] | None:
    """Fork a child for each command, in which this returns the command; None when nobody asks any more.

    Between the two stands a process that waits for the child and tells how it ended, so that this one is free again. A child
    may ask as well, over a connection of its own.
    """
    asking = selectors.DefaultSelector()
    asking.register(first, selectors.EVENT_READ)
    while first.fileno() >= 0:
        for key, _ in asking.select():
            connection: Any = key.fileobj
            told, descriptors = b"", []
            with suppress(ConnectionResetError):  # whoever asked was killed
                told, descriptors, _, _ = socket.recv_fds(connection, _SIZE, 8)
            if not told:
                asking.unregister(connection)
                connection.close()
                continue
            signal.signal(signal.SIGCHLD, signal.SIG_IGN)  # nobody asks how those that wait have ended
            here, there = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
            if os.fork() != 0:
                for each in descriptors:
                    os.close(each)
                there.close()
                asking.register(here, selectors.EVENT_READ)
                continue
            signal.signal(signal.SIGCHLD, signal.SIG_DFL)
            for other in list(asking.get_map().values()):
                other.fileobj.close()  # type: ignore[union-attr]
            asking.close()
            here.close()
            return _born(json.loads(told), descriptors, there)
    return None


def _born(command: dict[str, Any], descriptors: list[int], ready: socket.socket) -> dict[str, Any]:
    """Give the command in a child with its streams; this process tells how that ends, and ends."""
    *streams, asked = descriptors[:4]
    passed = descriptors[4:]
    child = os.fork()
    if child == 0:
        os.close(asked)
        for place, stream in enumerate(streams):
            os.dup2(stream, place)
            os.close(stream)
        os.umask(command["umask"])
        if command["session"]:
            os.setsid()
        command["arguments"] += map(str, passed)
        return {**command, "ready": ready}
    ready.close()
    for place in (0, 1, 2, *streams, *passed):
        os.close(place)
    with socket.socket(fileno=asked) as asking:
        asking.send(str(child).encode())
        status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        with suppress(OSError):  # nobody may ask any more
            asking.send(str(status).encode())
    os._exit(0)


def _wait(names: list[str]) -> dict[str, Any] | None:
    """Load what commands need, and give one to each child."""
    for name in (*LIBRARIES, *names):
        import_module(name)
    if names:
        import_module("damperlab.worker.provenance").provenance()  # what computes here, found once
    gc.freeze()  # what is loaded stays: a child need not look through it, which would copy its pages
    connection = socket.socket(fileno=os.dup(0))
    with Path(os.devnull).open("rb") as nothing:
        os.dup2(nothing.fileno(), 0)
    return _serve(connection)


def main() -> None:
    """Wait for commands; run each in a child."""
    command = _wait([*DAMPERLAB, "tests.spawning"] if "damperlab" in sys.argv else [])
    if command is not None:
        os.environ.clear()
        os.environ.update(command["environment"])
        import_module("dask").config.refresh()
        import_module("numba").config.reload_config()
        os.chdir(command["folder"])
        sys.path[0] = command["folder"]
        sys.argv[1:] = command["arguments"]
        if "tests.spawning" in sys.modules:
            sys.modules["tests.spawning"].fork_from(lambda: Ready(command["ready"]))
        sys.modules.pop(command["module"], None)  # as `python -m` runs it: never loaded before
        _run(command["module"])


def _run(module: str) -> None:
    """Run a module to its end, and leave without taking the interpreter apart.

    That touches, and so copies, every page that this process shares with the one it was forked from: three quarters of the
    processor time of a short command.
    """
    try:
        runpy.run_module(module, run_name="__main__", alter_sys=True)
        status: object = 0
    except SystemExit as end:
        status = end.code
    if status is not None and not isinstance(status, int):
        sys.stderr.write(f"{status}\n")
        status = 1
    threading._shutdown()  # type: ignore[attr-defined]
    atexit._run_exitfuncs()
    for stream in (sys.stdout, sys.stderr):
        with suppress(OSError, ValueError):  # whoever read it has gone, or it is closed
            stream.flush()
    os._exit(status or 0)


if __name__ == "__main__":
    main()
