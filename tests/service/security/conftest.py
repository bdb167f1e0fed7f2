"""A service that asks for keys, and the keys of two people and an admin."""

import json
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import httpx
import pytest

PATIENCE_SECONDS = 300.0
QUICK = {"frequency_ratio": 1.0, "clearance_ratio": 5, "friction_ratio": 0, "cycles": 3, "history": 0}
ENDLESS = QUICK | {"clearance_ratio": 1e-6, "restitution": 0.9999, "mass_ratio": 0.5, "cycles": 100_000}
"""Some 5·10⁹ impacts: many minutes on any machine."""


def command(*arguments: str) -> subprocess.CompletedProcess[str]:
    """Run the command line in a process of its own."""
    program = str(Path(sys.executable).with_name("damperlab"))
    return subprocess.run([program, *arguments], capture_output=True, text=True, timeout=PATIENCE_SECONDS)


def make_key(data_dir: Path, owner: str, scope: str, *more: str) -> dict[str, Any]:
    """Make a key as an operator does."""
    done = command(
        "keys", "create", "--owner", owner, "--scope", scope, "--data-dir", str(data_dir), "--json", *more
    )
    assert done.returncode == 0, done.stderr
    made: dict[str, Any] = json.loads(done.stdout)
    return made


@dataclass
class Guarded:
    """A service that asks for keys."""

    running: Any
    data_dir: Path
    keys: dict[str, dict[str, Any]]

    @property
    def url(self) -> str:
        url: str = self.running.url
        return url

    def client(self, who: str | None) -> httpx.Client:
        headers = {} if who is None else {"Authorization": f"Bearer {self.keys[who]['key']}"}
        return httpx.Client(base_url=self.url, headers=headers, timeout=PATIENCE_SECONDS)


@pytest.fixture(scope="session")
def guarded(tmp_path_factory: pytest.TempPathFactory, helpers: Any) -> Iterator[Guarded]:
    """One service with keys for all tests that leave it as they found it."""
    folder = tmp_path_factory.mktemp("guarded")
    data = folder / "data"
    keys = {
        "reader": make_key(data, "reader", "read"),
        "ann": make_key(data, "ann", "submit"),
        "bob": make_key(data, "bob", "submit"),
        "admin": make_key(data, "operator", "admin"),
    }
    running = helpers.start_service(
        data, folder / "log", DAMPERLAB_ACCESS="keys", DAMPERLAB_TRUSTED_PROXIES="", DAMPERLAB_HOSTS=""
    )
    try:
        yield Guarded(running, data, keys)
    finally:
        status = running.stop()
    assert status == 0, running.log.read_text()
