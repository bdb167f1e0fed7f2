"""A service of its own, with a store of its own, for as long as a page of the documentation needs one."""

import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import httpx

PATIENCE_SECONDS = 600.0


@contextmanager
def service() -> Iterator[str]:
    """Run `damperlab serve` on a free port of this machine, and give its address.

    Raises
    ------
    RuntimeError
        Where it does not answer in time.
    """
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    url = f"http://127.0.0.1:{port}"
    with tempfile.TemporaryDirectory() as folder:
        command = [
            str(Path(sys.executable).parent / "damperlab"),
            "serve",
            "--port",
            str(port),
            "--data-dir",
            folder,
        ]
        with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as process:
            try:
                _await(url, process)
                yield url
            finally:
                process.terminate()
                process.wait(300)


def _await(url: str, process: "subprocess.Popen[bytes]") -> None:
    give_up = time.monotonic() + PATIENCE_SECONDS
    while time.monotonic() < give_up and process.poll() is None:
        try:
            if httpx.get(f"{url}/health/ready", timeout=5.0).is_success:
                return
        except httpx.TransportError:
            pass
        time.sleep(0.2)
    raise RuntimeError("damperlab serve did not answer")
