"""A Dask scheduler in a separate process that does not get the addresses and keys of the database and the store.

Any client of a Dask scheduler can run code in the scheduler's process. Therefore this process contains no secrets
except its certificate, and accepts only connections with the certificate of this run.
"""

import asyncio
import json
import logging
import os
import subprocess
import sys
import threading
from contextlib import suppress

import dask
from distributed import Scheduler, Security
from distributed.deploy.spec import ProcessInterface

MONITORING = {
    # At Dask's own intervals, from 20 ms to 0.5 s, an idle service with two workers keeps an eighth of a core busy.
    "distributed.admin.tick.interval": "1s",
    "distributed.admin.system-monitor.interval": "10s",
    "distributed.worker.memory.monitor-interval": "500ms",
    # only the dashboard, which is off, would use the profiler
    "distributed.worker.profile.enabled": False,
}
"""Dask's settings for how schedulers, nannies and workers monitor themselves."""
_CONFIG = {
    **MONITORING,
    # a block fails when its worker dies once; the runner decides whether to try the block again
    "distributed.scheduler.allowed-failures": 0,
}
"""Dask's settings in the process of the scheduler."""

_KEPT = (
    "PATH",
    "HOME",
    "LANG",
    "LC_ALL",
    "TMPDIR",
    "TZ",
    "SYSTEMROOT",
    "LD_LIBRARY_PATH",
    "DAMPERLAB_CACHE_DIR",
)
"""Environment variables passed to the process; none contains a database's address or a store's key."""
_TLS = ("tls_ca_file", "tls_scheduler_cert", "tls_scheduler_key")


class SchedulerProcess(ProcessInterface):  # type: ignore[misc]
    """A Dask scheduler in a child process that ends with its parent. `SpecCluster` starts and closes it.

    Parameters
    ----------
    security : Security
        Certificates of the cluster.
    host : str
        Name or address at which the scheduler listens.
    """

    def __init__(self, security: Security, host: str) -> None:
        super().__init__()
        self.security = security
        self._host = host
        self._process: subprocess.Popen[bytes] | None = None

    @property
    def lost(self) -> bool:
        """Whether the process has ended although `close` was not called."""
        return self._process is not None and self._process.poll() is not None

    def is_lost_within(self, seconds: float) -> bool:
        """Return whether the process has ended, or ends within the given time.

        The connections of a dying process close before the process ends, so a caller that has lost the connection
        should wait for a short time.
        """
        if self._process is None:
            return False
        with suppress(subprocess.TimeoutExpired):
            self._process.wait(seconds)
        return self.lost

    async def start(self) -> None:
        """Start the process and read the address of the scheduler.

        Raises
        ------
        RuntimeError
            If the process ended before it printed its address.
        """
        environment = {name: value for name, value in os.environ.items() if name in _KEPT}
        environment["PYTHONPATH"] = os.pathsep.join(path for path in sys.path if path)
        self._process = _started(environment)
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        told = {name: getattr(self.security, name) for name in _TLS}
        said = {"tls": told, "host": self._host}
        # other users can read a process's command line and environment, so secrets are sent through standard input
        self._process.stdin.write(json.dumps(said).encode() + b"\n")
        self._process.stdin.flush()
        line = await asyncio.to_thread(self._process.stdout.readline)
        if not line:
            raise RuntimeError(f"the scheduler's process ended with status {self._process.wait()}")
        self.address = line.decode().strip()
        await super().start()

    async def close(self) -> None:
        """End the process."""
        if self._process is not None:
            self._process.kill()
            await asyncio.to_thread(self._process.wait)
            for pipe in (self._process.stdin, self._process.stdout):
                assert pipe is not None
                pipe.close()
            self._process = None
        await super().close()


def _started(environment: dict[str, str]) -> "subprocess.Popen[bytes]":
    return subprocess.Popen(
        [sys.executable, "-m", "damperlab.worker.cluster.scheduler"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        env=environment,
        # Ctrl-C in a terminal must not reach the scheduler; the coordinator handles it and then ends the scheduler
        start_new_session=True,
    )


async def _serve(host: str, tls: dict[str, str]) -> None:
    async with Scheduler(
        host=host,
        port=0,
        protocol="tls",
        dashboard=False,
        dashboard_address="127.0.0.1:0",
        security=Security(require_encryption=True, **tls),
    ) as scheduler:
        print(scheduler.address, flush=True)
        await scheduler.finished()


def _end_with_parent() -> None:
    sys.stdin.buffer.read()
    os._exit(0)


def main() -> None:
    """Read settings from standard input, print the address of a new scheduler, and run until the input is closed."""
    logging.getLogger("distributed").setLevel(logging.CRITICAL)
    told = json.loads(sys.stdin.buffer.readline())
    threading.Thread(target=_end_with_parent, daemon=True).start()
    with dask.config.set(_CONFIG):
        asyncio.run(_serve(told["host"], told["tls"]))


if __name__ == "__main__":
    main()
