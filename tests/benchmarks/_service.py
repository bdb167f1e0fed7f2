"""A service in a process of its own, and what it spends."""

import os
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import httpx
from tests.ports import free_port


@contextmanager
def serving(folder: Path, scheduler: str | None, workers: int = 1) -> Iterator[tuple[str, int]]:
    """Start a service; its address and process."""
    port = free_port()
    environment = {**os.environ, "DAMPERLAB_DATA_DIR": str(folder), "DAMPERLAB_WARM": "false"}
    command = [str(Path(sys.executable).with_name("damperlab")), "serve", "--port", str(port)]
    command += ["--scheduler", scheduler] if scheduler else ["--workers", str(workers)]
    with (folder / "log").open("ab") as log:
        server = subprocess.Popen(command, env=environment, stdout=log, stderr=log)
    try:
        url = f"http://127.0.0.1:{port}"
        give_up = time.monotonic() + 120
        while True:
            try:
                httpx.get(f"{url}/health/live", timeout=30).raise_for_status()
                break
            except httpx.HTTPError:
                if time.monotonic() > give_up or server.poll() is not None:
                    raise
                time.sleep(0.2)
        yield url, server.pid
    finally:
        server.terminate()
        server.wait(120)


def cpu_seconds(pid: int) -> float:
    """Give the CPU time of one process, user and system, without its children."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
