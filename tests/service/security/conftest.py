"""A service that asks for keys, and the keys of two people and an admin."""

import os
from collections.abc import Iterator
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import httpx
import pytest
from tests.service.conftest import TRUSTED, serving

from damperlab.studies.store.catalogue.access_keys import AccessKeys
from damperlab.studies.store.store import Store

PATIENCE_SECONDS = 300.0
QUICK = {"frequency_ratio": 1.0, "clearance_ratio": 5, "friction_ratio": 0, "cycles": 3, "history": 0}
ENDLESS = QUICK | {"clearance_ratio": 1e-6, "restitution": 0.9999, "mass_ratio": 0.5, "cycles": 100_000}
"""Some 5·10⁹ impacts: many minutes on any machine."""


def make_key(data_dir: Path, owner: str, scope: str, lasts_seconds: float | None = None) -> dict[str, Any]:
    """Make a key as `damperlab admin keys create` does."""
    before = os.umask(0o077)
    try:
        with closing(Store.open(data_dir)) as store:
            key, secret = AccessKeys(store.catalogue).create(owner, (scope,), lasts_seconds)
    finally:
        os.umask(before)
    return {**key.document(), "key": secret}


def every_route(routes: Any) -> Iterator[Any]:
    """Give routes, and those of routers that were included."""
    for route in routes:
        inner = getattr(getattr(route, "original_router", None), "routes", None)
        yield from [route] if inner is None else every_route(inner)


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
        return httpx.Client(base_url=self.url, headers=headers, timeout=PATIENCE_SECONDS, verify=TRUSTED)


WORK_SECONDS = 1
"""What a request to `apart` may take."""


@pytest.fixture(scope="session")
def apart(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    """One service that has every question computed apart, for tests of the processes that compute."""
    folder = tmp_path_factory.mktemp("apart")
    asked = {"DAMPERLAB_QUESTION_POINTS_APART": "0", "DAMPERLAB_WORK_SECONDS": str(WORK_SECONDS)}
    with serving(folder, **asked) as running:
        yield running


@pytest.fixture(scope="session")
def guarded(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Guarded]:
    """One service with keys for all tests that leave it as they found it."""
    folder = tmp_path_factory.mktemp("guarded")
    data = folder / "data"
    keys = {
        "reader": make_key(data, "reader", "read"),
        "ann": make_key(data, "ann", "submit"),
        "bob": make_key(data, "bob", "submit"),
        "admin": make_key(data, "operator", "admin"),
    }
    asked = {"DAMPERLAB_ACCESS": "keys", "DAMPERLAB_TRUSTED_PROXIES": "", "DAMPERLAB_HOSTS": ""}
    with serving(folder, **asked) as running:
        yield Guarded(running, data, keys)
