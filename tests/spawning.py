"""What damperlab starts of its own, forked from a process that has loaded it: schedulers, workers, searches for designs.

Started anew each of them loads every library first. It stays a process of its own, with the environment, the streams and the
end that it would have.
"""

import os
import socket
import subprocess
import sys
from collections.abc import Callable
from functools import partial
from multiprocessing import connection, context, forkserver, popen_forkserver, resource_tracker, spawn
from multiprocessing.process import BaseProcess
from typing import Any

from tests.ready import Ready, Started, alike

from damperlab.worker.cluster import scheduler

_start_anew = scheduler._started
_Spawned = context.SpawnProcess


def fork_from(ready: Callable[[], Ready]) -> None:
    """Have what this process starts forked from there, where its variables are those that damperlab was loaded by."""
    scheduler._started = partial(_scheduler, ready)
    forkserver._forkserver.ensure_running = partial(_fork_server, ready)  # type: ignore[method-assign]
    context._concrete_contexts["spawn"] = _Context()  # type: ignore[attr-defined]
    spawn.get_preparation_data = partial(_prepared, spawn.get_preparation_data)
    spawn.prepare = partial(_prepare, spawn.prepare)


class _Process(_Spawned):
    @staticmethod
    def _Popen(process: BaseProcess) -> Any:
        if alike(dict(os.environ)):
            return popen_forkserver.Popen(process)
        return _Spawned._Popen(process)  # type: ignore[attr-defined]


class _Context(context.SpawnContext):
    Process = _Process


def _scheduler(
    ready: Callable[[], Ready], environment: dict[str, str]
) -> "subprocess.Popen[bytes] | Started":
    if not alike(dict(os.environ)):
        return _start_anew(environment)
    given, write = os.pipe()
    read, out = os.pipe()
    started = ready().fork(
        "damperlab.worker.cluster.scheduler", [], environment, given=given, out=out, session=True
    )
    os.close(given)
    os.close(out)
    started.stdin = os.fdopen(write, "wb")
    started.stdout = os.fdopen(read, "rb")
    return started


def _fork_server(ready: Callable[[], Ready]) -> None:
    """Have the process of `multiprocessing` that forks others, where this process has none yet."""
    server: Any = forkserver._forkserver
    with server._lock:
        resource_tracker.ensure_running()
        if server._forkserver_alive_fd is not None:
            return
        read, alive = os.pipe()
        with socket.socket(socket.AF_UNIX) as listener:
            address = connection.arbitrary_address("AF_UNIX")  # type: ignore[attr-defined]
            listener.bind(address)
            listener.listen()
            passed = [listener.fileno(), read]
            # kept, so that its connection is not found unclosed
            server.forked = ready().fork("tests.spawning", [], dict(os.environ), passed=passed)
        os.close(read)
        server._forkserver_address = address
        server._forkserver_alive_fd = alive


def _prepared(plain: Any, name: str) -> dict[str, Any]:
    """Have variables that were set since told too."""
    return {**plain(name), "environment": dict(os.environ)}


def _prepare(plain: Any, told: dict[str, Any]) -> None:
    os.environ.clear()
    os.environ.update(told.pop("environment"))
    plain(told)


if __name__ == "__main__":
    listener, alive = map(int, sys.argv[1:])
    forkserver.main(listener, alive, [])
