"""A service in a process of its own, and what it spends."""

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from tests.faults.processes import Process
from tests.ports import free_port


@contextmanager
def serving(folder: Path, scheduler: str | None, workers: int = 1) -> Iterator[tuple[str, int]]:
    """Start a service; its address and process."""
    port = free_port()
    command = [sys.executable, "-m", "damperlab", "serve", "--port", str(port)]
    command += ["--scheduler", scheduler] if scheduler else ["--workers", str(workers)]
    environment = {"DAMPERLAB_DATA_DIR": str(folder), "DAMPERLAB_WARM": "false"}
    server = Process(folder / "log", *command, **environment)
    server.keep_up()
    try:
        url = f"http://127.0.0.1:{port}"
        yield url, server.wait_for(url)
    finally:
        server.kill()


def cpu_seconds(pid: int) -> float:
    """Give the CPU time of one process, user and system, without its children."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
