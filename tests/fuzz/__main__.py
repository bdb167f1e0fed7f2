"""Ask a running service whatever its OpenAPI document allows, and what it does not: ``python -m tests.fuzz --cases 500``.

schemathesis, which ``requirements-bench.lock`` holds, runs all of its checks over all operations, DELETE among them. What it
deletes is put back, so that there is always something to ask: studies that are done, one that runs, a suite, uploaded records,
promised answers.
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
from tests.service.conftest import CURVE, SUITE, Running, ended, long_study, start_service, wait_for

FRICTION = {
    "name": "friction",
    "particle": False,
    "axes": {"friction_ratio": [0.05, 0.2, 0.4], "frequency_ratio": [0.95, 1, 1.05]},
}
STUDIES = (CURVE, CURVE | {"name": "another", "damping_ratio": 0.004}, FRICTION, SUITE)
HARMONIC = 3
"""So many of them are no suites."""
RECORDS = tuple({"kanai_tajimi": {"seed": seed, "duration_s": 20, "peak_g": 0.2}} for seed in (1, 2))
POINT = {"frequency_ratio": 1, "clearance_ratio": 10, "cycles": 3}
HERE = Path(__file__).parent


def submit(client: httpx.Client) -> list[str]:
    """Submit every study that is not there."""
    return [client.post("/api/v1/studies", json=each).json()["id"] for each in STUDIES]


def put_back(client: httpx.Client) -> dict[str, list[str]]:
    """Make anew what is not there; what may be named in a request, by the parameter that names it."""
    studies = submit(client)
    running = client.post("/api/v1/studies", json=long_study("running")).json()["id"]
    client.post(f"/api/v1/studies/{running}/resume")
    kept = [client.post("/api/v1/records", json=each).json() for each in RECORDS]
    # on a busy machine one may have taken longer than it may: it is there the next time
    records = [each["id"] for each in kept if "id" in each]
    at_once = {"Prefer": "respond-async, wait=0"}
    promised = [client.post("/api/v1/simulate", json=POINT, headers=at_once) for _ in range(2)]
    answers = [each.headers["location"].rpartition("/")[2] for each in promised if each.status_code == 202]
    return {
        "study_id": [*studies, running],
        "record_id": ["northridge", "el-centro", *records],
        "answer_id": answers,
    }


@contextmanager
def something_to_ask(url: str, there: Path) -> Iterator[None]:
    """Keep something at hand while the block runs; its names are in the file `there`."""
    over = threading.Event()

    def note(client: httpx.Client) -> None:
        new = there.with_suffix(".new")
        new.write_text(json.dumps(put_back(client)))
        new.replace(there)

    def again() -> None:
        with httpx.Client(base_url=url, timeout=60) as client:
            while not over.wait(2):
                try:
                    note(client)
                except (httpx.HTTPError, KeyError, json.JSONDecodeError):
                    continue  # refused by a limit: next time

    with httpx.Client(base_url=url, timeout=300) as client:
        for each in submit(client):
            wait_for(client, each, ended)
        # kernels warm: one point, one comparison
        client.post("/api/v1/simulate", json=POINT)
        client.post("/api/v1/earthquake-comparisons", json={"record": "northridge"})
        note(client)
    keeper = threading.Thread(target=again)
    keeper.start()
    try:
        yield
    finally:
        over.set()
        keeper.join()


def run(running: Running, folder: str, cases: int) -> int:
    """Run schemathesis over one service; its exit status."""
    there = Path(folder) / "there.json"
    with something_to_ask(running.url, there):
        environment = os.environ | {
            "FUZZ_THERE": str(there),
            "FUZZ_HARMONIC": str(HARMONIC),
            "SCHEMATHESIS_HOOKS": "hooks",
            "PYTHONHASHSEED": "0",
            "PYTHONPATH": str(HERE),
        }
        program = Path(sys.executable).with_name("schemathesis")
        command = [
            str(program), "--config-file", str(HERE / "schemathesis.toml"), "run", f"{running.url}/openapi.json",
            "--max-examples", str(cases), "--continue-on-failure", "--suppress-health-check", "all",
            "--request-timeout", "300",
        ]  # fmt: skip
        return subprocess.run(command, env=environment, cwd=folder, check=False).returncode


def main() -> None:
    """Start a service, ask it, stop it; exit 1 where anything was wrong."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "--cases", type=int, default=20, help="cases for each of the operations, in each phase"
    )
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        running = start_service(
            Path(folder) / "data", Path(folder) / "log", DAMPERLAB_WORK_SECONDS="10", DAMPERLAB_ACCESS="auto"
        )
        try:
            status = run(running, folder, asked.cases)
        finally:
            stopped = running.stop()
        log = (Path(folder) / "log").read_text()
    if "Traceback" in log or stopped != 0:
        print(log[-5000:])
        status = status or 1
    sys.exit(status)


if __name__ == "__main__":
    main()
