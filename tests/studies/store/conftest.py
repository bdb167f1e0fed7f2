"""A store, and an empty one beside it."""

import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest
from tests.studies.store.racing import Watched

from damperlab.studies.store.store import Store


@pytest.fixture
def store(tmp_path: Path) -> Iterator[Store]:
    opened = Store.open(tmp_path / "data")
    yield opened
    opened.close()


@pytest.fixture
def copied(made: Path, tmp_path: Path) -> Iterator[Store]:
    """Open a copy of the store `made` of the module, which a test may damage."""
    opened = Store.open(shutil.copytree(made, tmp_path / "data"))
    yield opened
    opened.close()


@pytest.fixture
def copy(tmp_path: Path) -> Iterator[Store]:
    """Open an empty store beside the first."""
    opened = Store.open(tmp_path / "copy")
    yield opened
    opened.close()


@pytest.fixture
def watched(store: Store) -> Store:
    shelf = Watched(store.shelf.address)
    shelf.catalogue = store.catalogue
    store.shelf = shelf
    return store
