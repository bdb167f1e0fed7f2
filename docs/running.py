"""A service of its own, with a store of its own, for as long as a page of the documentation needs one."""

import os
import re
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
    """Run `damperlab serve` on a port that is free, and give its address.

    Raises
    ------
    RuntimeError
        Where it does not answer in time.
    """
    with tempfile.TemporaryDirectory() as folder, tempfile.NamedTemporaryFile() as log:
        program = str(Path(sys.executable).parent / "damperlab")
        command = [program, "serve", "--port", "0", "--data-dir", folder]
        # kernels that no page asks for would take the cores from those that pages do
        environment = os.environ | {"DAMPERLAB_WARM": "false"}
        with subprocess.Popen(command, env=environment, stdout=log, stderr=log) as process:
            try:
                yield _address(Path(log.name), process)
            finally:
                process.terminate()
                process.wait(300)


def _address(log: Path, process: "subprocess.Popen[bytes]") -> str:
    give_up = time.monotonic() + PATIENCE_SECONDS
    while time.monotonic() < give_up and process.poll() is None:
        found = re.search(r"running on (http\S+)", log.read_text())
        if found and httpx.get(f"{found[1]}/health/ready", timeout=PATIENCE_SECONDS).is_success:
            return found[1]
        time.sleep(0.2)
    raise RuntimeError(f"damperlab serve did not answer:\n{log.read_text()}")
