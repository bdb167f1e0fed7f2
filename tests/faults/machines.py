"""What stands in a host of a network campaign: its processes, kept up and killed together, and its cable."""

import os
import pwd
import shutil
import tempfile
import threading
from dataclasses import dataclass
from pathlib import Path

import psutil
from tests.faults.hosts import Host
from tests.faults.processes import Database, Process

DATABASE_PORT = 5432


class PostgreSQL(Process):
    """A PostgreSQL server that other hosts reach."""

    def __init__(self, folder: Path, host: Host) -> None:
        made = Database(folder)
        made.close()
        server = made.program
        with (folder / "pg_hba.conf").open("a") as file:
            file.write("host all all 10.77.0.0/24 trust\n")
        user = pwd.getpwuid(folder.stat().st_uid)
        socket = tempfile.mkdtemp(prefix="damperlab-pg-")
        os.chown(socket, user.pw_uid, user.pw_gid)
        self._socket = Path(socket)
        owner = ("setpriv", f"--reuid={user.pw_uid}", f"--regid={user.pw_gid}", "--clear-groups")
        place = ("-D", str(folder), "-h", host.address, "-p", str(DATABASE_PORT), "-k", socket)
        super().__init__(folder.with_suffix(".log"), *host.inside(*owner, str(server), *place))
        self.address = f"postgresql://postgres@{host.address}:{DATABASE_PORT}/postgres"

    def kill(self) -> None:
        """End the server and every process that serves a connection."""
        if self._process is not None and self._process.poll() is None:
            parent = psutil.Process(self._process.pid)
            family = parent.children(recursive=True)
            super().kill()
            for process in family:
                process.kill()
            psutil.wait_procs(family, timeout=20)

    def close(self) -> None:
        """End it, and remove its socket."""
        self.kill()
        shutil.rmtree(self._socket, ignore_errors=True)


@dataclass
class Machine:
    """A host and what runs on it."""

    host: Host
    parts: dict[str, Process]
    plugged: bool = True

    def keep_up(self) -> None:
        """Start what does not run."""
        for part in self.parts.values():
            part.keep_up()

    def kill(self) -> None:
        """End all that runs there."""
        for part in self.parts.values():
            part.kill()
        self.host.kill()

    def cut(self, seconds: float) -> None:
        """Pull its cable for a while."""
        if self.plugged:
            self.plugged = False
            self.host.cable(False)
            threading.Timer(seconds, self._plug).start()

    def _plug(self) -> None:
        self.host.cable(True)
        self.plugged = True
