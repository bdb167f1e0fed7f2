"""A real service: the command `damperlab serve` in a process of its own, on a free port of the loopback interface."""

import os
import re
import signal
import ssl
import time
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import httpx
import psutil
import pytest
from tests import ports
from tests.ready import Started
from tests.service import served

from damperlab import Client
from damperlab.service.edge.connection import LEAVE_SECONDS
from damperlab.studies.store.store import Store

START_SECONDS = 300.0
WORK_SECONDS = 3000.0
PATIENCE_SECONDS = 300.0
"""How long one answer may take: on a loaded machine a kernel may have to be compiled for it."""

TRUSTED = ssl.create_default_context()
"""Read once: a client reads every certificate of the system otherwise."""
CURVE: dict[str, Any] = {
    "name": "curve",
    "particle": False,
    "damping_ratio": 0.0038,
    "axes": {"friction_ratio": 0, "frequency_ratio": {"start": 0.5, "stop": 1.5, "num": 11}},
}
"""Closed form: milliseconds."""


def long_study(name: str, damping_ratio: float = 0.0038, frequencies: int = 600) -> dict[str, Any]:
    """Friction alone over a grid: some seven seconds of kernels in dozens of blocks; the digest differs by damping."""
    return {
        "name": name,
        "particle": False,
        "damping_ratio": damping_ratio,
        "axes": {
            "friction_ratio": {"start": 0.05, "stop": 0.75, "num": 200},
            "frequency_ratio": {"start": 0.9, "stop": 1.1, "num": frequencies},
        },
    }


def lasting_study(name: str) -> dict[str, Any]:
    """A hybrid damper over a grid: minutes of kernels, so that it ends only where it is cancelled.

    A point takes long. There are so few points that the service answers questions about them in its own process.
    """
    return {
        "name": name,
        "axes": {
            "clearance_ratio": 10,
            "friction_ratio": {"start": 0.05, "stop": 0.75, "num": 100},
            "frequency_ratio": {"start": 0.9, "stop": 1.1, "num": 480},
        },
        "steady": {"max_cycles": 2000},
    }


@dataclass
class Running:
    """A service in a process."""

    process: Started
    url: str
    log: Path

    def client(self) -> httpx.Client:
        """Ask it over HTTP."""
        return httpx.Client(base_url=self.url, timeout=PATIENCE_SECONDS, verify=TRUSTED)

    def stop(self, how: signal.Signals = signal.SIGTERM) -> int:
        """Signal the process and wait for its end."""
        if self.process.poll() is None:
            self.process.send_signal(how)
        return self.process.wait(START_SECONDS)


def start_service(data_dir: Path, log: Path, **environment: str) -> Running:
    """Start `damperlab serve` and wait until it listens."""
    defaults = {"DAMPERLAB_DATA_DIR": str(data_dir), "DAMPERLAB_PORT": "0", "DAMPERLAB_WORKERS": "1"}
    defaults["DAMPERLAB_WARM"] = "false"  # a background that compiles would take the cores from the tests
    variables = {**os.environ, **defaults, **environment}
    with log.open("wb") as out:
        process = served.start(variables, out)
    give_up = time.monotonic() + START_SECONDS
    while time.monotonic() < give_up:
        found = re.search(r"running on (https?://\S+)", log.read_text())
        if found:
            return Running(process, found.group(1), log)
        if process.poll() is not None:
            break
        time.sleep(0.1)
    process.kill()
    process.wait()
    raise AssertionError(f"the service did not start:\n{log.read_text()}")


@contextmanager
def serving(folder: Path, **environment: str) -> Iterator[Running]:
    """Have a service on the data directory folder/data, which ends well."""
    running = start_service(folder / "data", folder / "log", **environment)
    try:
        yield running
    finally:
        status = running.stop()
    assert status == 0, running.log.read_text()


@pytest.fixture(scope="session")
def service(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Running]:
    """One service with one worker for all tests that leave it as they found it."""
    with serving(tmp_path_factory.mktemp("service"), DAMPERLAB_STUDIES_AT_ONCE="2") as running:
        yield running


@pytest.fixture(scope="session")
def store(service: Running) -> Iterator[Store]:
    """What the service keeps."""
    with closing(Store.open(service.log.parent / "data")) as store:
        yield store


@pytest.fixture
def remote(service: Running) -> Iterator[Client]:
    with Client(service.url) as client:
        yield client


@pytest.fixture
def client(service: Running) -> Iterator[httpx.Client]:
    with service.client() as client:
        yield client


@pytest.fixture
def own_service(tmp_path: Path) -> Iterator[Callable[..., Running]]:
    """Start services that a test may stop, on the data directory tmp_path/data unless told otherwise."""
    started: list[Running] = []

    def start(data_dir: Path | None = None, **environment: str) -> Running:
        log = tmp_path / f"log-{len(started)}"
        started.append(start_service(data_dir or tmp_path / "data", log, **environment))
        return started[-1]

    yield start
    for running in started:
        running.stop(signal.SIGKILL)


def wait_for(client: httpx.Client, study_id: str, good: Callable[[dict[str, Any]], bool]) -> dict[str, Any]:
    """Ask for a study's record until it is as wanted."""
    return _asked_until(client, f"/api/v1/studies/{study_id}", good)


def wait_for_design(
    client: httpx.Client, design_id: str, good: Callable[[dict[str, Any]], bool]
) -> dict[str, Any]:
    """Ask for a design until it is as wanted."""
    return _asked_until(client, f"/api/v1/designs/{design_id}", good)


def _asked_until(client: httpx.Client, path: str, good: Callable[[dict[str, Any]], bool]) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for _ in _looks():
        found = client.get(path).raise_for_status().json()
        if good(found):
            return found
    raise AssertionError(found)


def wait_until(true: Callable[[], bool]) -> None:
    """Ask again and again until the answer is yes."""
    assert any(true() for _ in _looks())


def _looks() -> Iterator[None]:
    """Look again and again, seldom once much time has passed: each look takes the cores from what is waited for."""
    began = time.monotonic()
    while (waited := time.monotonic() - began) < WORK_SECONDS:
        yield
        time.sleep(min(0.3, 0.05 + 0.02 * waited))


def computing(running: Running) -> list[psutil.Process]:
    """Give the processes of a service that compute for requests; one that ends at this moment is none of them."""
    found = []
    for each in psutil.Process(running.process.pid).children(recursive=True):
        with suppress(psutil.NoSuchProcess):
            if "anyio.to_process" in each.cmdline():
                found.append(each)
    for pid, began in re.findall(rf"{served.COMPUTES}(\d+) (\d+)", running.log.read_text()):
        with suppress(psutil.NoSuchProcess):
            if served.began(int(pid)) == began:
                found.append(psutil.Process(int(pid)))
    return found


def held(running: Running) -> psutil.Process:
    """Stop the one process that computes for requests, as if it computed for ever; no limit of computing time ends it."""
    (process,) = computing(running)
    process.suspend()
    return process


def ends_once_given_up(process: psutil.Process, ask: Callable[[float], object]) -> bool:
    """Whether a held process ends once nobody waits for it any more.

    Parameters
    ----------
    process : Process
        As `held` gives it.
    ask : callable
        Asks for what the process shall compute, and gives it up after so many seconds. On a busy machine the process may not
        have been asked by then, and nothing has to end: it is asked again, for longer.
    """
    for seconds in (0.5, 2.0, 8.0):
        ask(seconds)
        began = time.monotonic()
        while time.monotonic() < began + LEAVE_SECONDS + seconds:
            if not psutil.pid_exists(process.pid):
                return True
            time.sleep(0.05)
    return False


def ended(record: dict[str, Any]) -> bool:
    return record["state"] in ("done", "cancelled", "failed")


@pytest.fixture
def free_port() -> int:
    """A port on which nobody listens."""
    return ports.free_port()


def computed(service: Running, study: dict[str, Any]) -> dict[str, Any]:
    """Have a service compute a study, and give its record."""
    with service.client() as client:
        answer = client.post("/api/v1/studies", json=study)
        assert answer.is_success, answer.text
        record = wait_for(client, answer.json()["id"], ended)
    assert (record["state"], record["points_failed"]) == ("done", 0), record
    return record


@pytest.fixture(scope="session")
def curve(service: Running) -> dict[str, Any]:
    """The record of a finished study, the structure alone over eleven frequencies."""
    return computed(service, CURVE)


SUITE: dict[str, Any] = {
    "name": "two earthquakes",
    "records": ["northridge", "northridge-360"],
    "axes": {"scale": [1, 3], "clearance_m": [0.001, 0.002, 0.004], "friction_force_n": [0.05, 0.2]},
    "starts": 2,
}
"""Twelve dampers and scales under two short records."""


@pytest.fixture(scope="session")
def suite(service: Running) -> dict[str, Any]:
    """The record of a finished suite."""
    return computed(service, SUITE)


SPECIFICATION: dict[str, Any] = {
    "name": "small <floor>",
    "structure": {"mass_kg": 40.0, "natural_frequency_hz": 8.0, "damping_ratio": 0.05},
    "excitation": {"base_amplitude_m": 0.001, "frequency_hz": {"start": 7.5, "stop": 8.5}},
    "choose": {"friction_force_n": {"start": 0.0, "stop": 60.0}},
    "clearance_m": 0.005,
    "particle_mass_kg": 4.0,
    "restitution": 0.5,
    "limits": {"displacement_m": 0.005},
    "budget_points": 200,
}
"""Half a second of kernels in some five rounds of studies, which leave other amplitudes out."""


@pytest.fixture(scope="session")
def design(service: Running) -> dict[str, Any]:
    """A design that the service has made, by its specification."""
    with service.client() as client:
        answer = client.post("/api/v1/designs", json=SPECIFICATION)
        assert answer.status_code in (200, 201), answer.text
        asked = answer.json()
        assert answer.headers["Location"] == f"/api/v1/designs/{asked['id']}"
        found = wait_for_design(client, asked["id"], ended)
    assert found["state"] == "done", found["message"]
    return found
