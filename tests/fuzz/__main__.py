"""Ask a running service whatever its OpenAPI document allows, and what it does not: ``python -m tests.fuzz --cases 500``.

schemathesis, which ``requirements-bench.lock`` holds, runs all of its checks over all operations, DELETE among them. Studies
that it deletes are submitted again, so that there is always something to ask.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import httpx
from tests.service.conftest import CURVE, SUITE, Running, ended, start_service, wait_for

STUDIES = (CURVE, CURVE | {"name": "another", "damping_ratio": 0.004}, SUITE)
FRICTION = {
    "name": "friction",
    "particle": False,
    "axes": {"friction_ratio": [0.05, 0.2, 0.4], "frequency_ratio": [0.95, 1, 1.05]},
}
HERE = Path(__file__).parent


def submit(client: httpx.Client) -> list[str]:
    """Submit every study that is not there."""
    return [client.post("/api/v1/studies", json=each).json()["id"] for each in (*STUDIES, FRICTION)]


@contextmanager
def something_to_ask(url: str) -> Iterator[list[str]]:
    """Keep studies at hand while the block runs."""
    over = threading.Event()

    def again() -> None:
        with httpx.Client(base_url=url, timeout=60) as client:
            while not over.wait(2):
                try:
                    submit(client)
                except (httpx.HTTPError, KeyError, json.JSONDecodeError):
                    continue  # refused by a limit: next time

    with httpx.Client(base_url=url, timeout=300) as client:
        ids = submit(client)
        for each in ids:
            wait_for(client, each, ended)
        # kernels warm: one point, one comparison
        client.post("/api/v1/simulate", json={"frequency_ratio": 1, "clearance_ratio": 10, "cycles": 3})
        client.post("/api/v1/earthquake-comparisons", json={"record": "northridge"})
    keeper = threading.Thread(target=again)
    keeper.start()
    try:
        yield ids
    finally:
        over.set()
        keeper.join()


def run(running: Running, folder: str, program: str, cases: int, more: list[str]) -> int:
    """Run schemathesis over one service; its exit status."""
    with something_to_ask(running.url) as ids:
        environment = os.environ | {
            "FUZZ_STUDIES": ",".join([*ids, "curve"]),
            "SCHEMATHESIS_HOOKS": "hooks",
            "PYTHONHASHSEED": "0",
            "PYTHONPATH": str(HERE),
        }
        command = [
            program, "--config-file", str(HERE / "schemathesis.toml"), "run", f"{running.url}/openapi.json",
            "--max-examples", str(cases), "--continue-on-failure", "--suppress-health-check", "all",
            "--request-timeout", "300", *more,
        ]  # fmt: skip
        return subprocess.run(command, env=environment, cwd=folder, check=False).returncode


def main() -> None:
    """Start a service, ask it, stop it; exit 1 where anything was wrong."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "--cases", type=int, default=20, help="cases for each of the operations, in each phase"
    )
    parser.add_argument("--schemathesis", default=str(Path(sys.executable).with_name("schemathesis")))
    asked, more = parser.parse_known_args()
    with tempfile.TemporaryDirectory() as folder:
        running = start_service(
            Path(folder) / "data", Path(folder) / "log", DAMPERLAB_WORK_SECONDS="10", DAMPERLAB_ACCESS="auto"
        )
        try:
            status = run(running, folder, asked.schemathesis, asked.cases, more)
        finally:
            stopped = running.stop()
        log = (Path(folder) / "log").read_text()
    if "Traceback" in log or stopped != 0:
        print(log[-5000:])
        status = status or 1
    sys.exit(status)


if __name__ == "__main__":
    main()
