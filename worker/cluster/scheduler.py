"""The scheduler of our own cluster, in a process that has no addresses or keys of database and store.

A client of a Dask scheduler can run any code in its process. So this process holds only names of blocks, and accepts only the
certificate of this run.
"""

import asyncio
import json
import logging
import os
import subprocess
import sys
import threading
from contextlib import suppress
from typing import Any

import dask
from distributed import Scheduler, Security
from distributed.deploy.spec import ProcessInterface

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
"""The environment of the process: no address of a database, no key of a store."""
_TLS = ("tls_ca_file", "tls_scheduler_cert", "tls_scheduler_key")


class SchedulerProcess(ProcessInterface):  # type: ignore[misc]
    """A scheduler in a separate process, as Dask's clusters start one; it ends with this process.

    Parameters
    ----------
    security : Security
        Certificates of this cluster; without them nothing is encrypted.
    config : dict
        Dask's settings in that process.
    host : str
        Name or address at which it listens; by default only this machine can reach it.
    """

    def __init__(self, security: Security, config: dict[str, Any], host: str = "127.0.0.1") -> None:
        super().__init__()
        self.security = security
        self._config = config
        self._host = host
        self._process: subprocess.Popen[bytes] | None = None

    @property
    def lost(self) -> bool:
        """Whether the process has ended without being closed here."""
        return self._process is not None and self._process.poll() is not None

    def is_lost_within(self, seconds: float) -> bool:
        """Whether the process has ended, or ends within a time; its connections close before the process ends."""
        if self._process is None:
            return False
        with suppress(subprocess.TimeoutExpired):
            self._process.wait(seconds)
        return self.lost

    async def start(self) -> None:
        """Start the process and read its address.

        Raises
        ------
        RuntimeError
            The process ended before it listened.
        """
        environment = {name: value for name, value in os.environ.items() if name in _KEPT}
        environment["PYTHONPATH"] = os.pathsep.join(path for path in sys.path if path)
        self._process = _started(environment)
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        told = {name: getattr(self.security, name) for name in _TLS}
        said = {"tls": told, "config": self._config, "host": self._host}
        # a command line and an environment are readable by others, so no secret is in them
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
    """Start the process with a separate environment."""
    return subprocess.Popen(
        [sys.executable, "-m", "damperlab.worker.cluster.scheduler"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        env=environment,
        # the coordinator handles Ctrl-C in a terminal, and ends this process when it is done
        start_new_session=True,
    )


async def _serve(host: str, tls: dict[str, str | None]) -> None:
    encrypted = tls["tls_ca_file"] is not None
    security = Security(require_encryption=True, **tls) if encrypted else Security()
    protocol = "tls" if encrypted else "tcp"
    async with Scheduler(
        host=host,
        port=0,
        protocol=protocol,
        dashboard=False,
        dashboard_address="127.0.0.1:0",
        security=security,
    ) as scheduler:
        print(scheduler.address, flush=True)
        await scheduler.finished()


def _end_with_parent() -> None:
    sys.stdin.buffer.read()
    os._exit(0)


def main() -> None:
    """Read settings from standard input, write the address to standard output, and serve until the input is closed."""
    logging.getLogger("distributed").setLevel(logging.CRITICAL)
    told = json.loads(sys.stdin.buffer.readline())
    threading.Thread(target=_end_with_parent, daemon=True).start()
    with dask.config.set(told["config"]):
        asyncio.run(_serve(told["host"], told["tls"]))


if __name__ == "__main__":
    main()
