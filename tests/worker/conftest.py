"""A store, and a cluster of one worker."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from distributed import Client

from damperlab.studies.store.store import Store
from damperlab.worker.cluster.cluster import connect


@pytest.fixture(scope="module")
def client() -> Iterator[Client]:
    with connect(workers=1) as client:
        yield client


@pytest.fixture
def store(tmp_path: Path) -> Iterator[Store]:
    store = Store.open(tmp_path / "data")
    yield store
    store.close()
