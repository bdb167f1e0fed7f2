"""Studies, plans and block values for the tests of the store."""

from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from damperlab.studies.definition import Study, parse_study
from damperlab.studies.plan import Block, Plan, plan_with_chunk
from damperlab.studies.store.cube.cube import stored_variables, write_region
from damperlab.studies.store.record import BlockOutcome
from damperlab.studies.store.store import Store

CHUNK = (1, 1, 1, 2, 2, 3)


def _study(name: str = "sample", **changes: Any) -> Study:
    axes = {
        "clearance_ratio": [1.0, 2.0, 3.0, 5.0, 8.0],
        "friction_ratio": [0.0, 0.2, 0.4],
        "restitution": 0.47,
        "mass_ratio": [0.1],
        "frequency_ratio": [0.8, 0.9, 1.0, 1.1],
    }
    return parse_study({"name": name, "damping_ratio": 0.0038, "axes": axes, **changes})


def _plan(study: Study, chunk: tuple[int, ...] = CHUNK) -> Plan:
    return plan_with_chunk(study, chunk, lambda _, coordinates: np.full(len(coordinates["mass_ratio"]), 1e-3))


def _values(study: Study, block: Block) -> dict[str, np.ndarray]:
    """Values that name their block: every variable of a block holds the block's index; converged throughout."""
    values = {v.name: np.full(block.shape, block.index, v.dtype) for v in stored_variables(study)}
    return values | {"status": np.zeros(block.shape, np.int8)}


def _outcome(block: Block, failed: int = 0, message: str | None = None) -> BlockOutcome:
    return BlockOutcome(block.index, block.points, failed, 0.5, 0.4, message)


@pytest.fixture
def make_study() -> Callable[..., Study]:
    return _study


@pytest.fixture
def make_plan_of() -> Callable[..., Plan]:
    return _plan


@pytest.fixture
def values_of() -> Callable[[Study, Block], dict[str, np.ndarray]]:
    return _values


@pytest.fixture
def outcome_of() -> Callable[..., BlockOutcome]:
    return _outcome


@pytest.fixture
def store(tmp_path: Path) -> Iterator[Store]:
    opened = Store.open(tmp_path / "data")
    yield opened
    opened.close()


@pytest.fixture
def entered(store: Store) -> Callable[..., tuple[Study, Plan, str]]:
    """Submit a study; the study, its plan and its id."""

    def enter(chunk: tuple[int, ...] = CHUNK, **changes: Any) -> tuple[Study, Plan, str]:
        study = _study(**changes)
        plan = _plan(study, chunk)
        return study, plan, store.submit(study, plan, {})[0].id

    return enter


@pytest.fixture
def put_into() -> Callable[..., None]:
    """Write blocks of a study into any store and mark them as done."""

    def write(store: Store, study: Study, plan: Plan, *indices: int, generation: str = "") -> None:
        study_id = study.digest[:12]
        for block in map(plan.block, indices):
            found = write_region(store.cube_path(study_id), block, _values(study, block), generation)
            store.mark(
                study_id, BlockOutcome(block.index, block.points, 0, 0.5, 0.4, None, generation, found)
            )

    return write


@pytest.fixture
def put(store: Store, put_into: Callable[..., None]) -> Callable[..., None]:
    """Write blocks of a study into the store and mark them as done."""
    return partial(put_into, store)


@pytest.fixture
def copy(tmp_path: Path) -> Iterator[Store]:
    """Open an empty store beside the first."""
    opened = Store.open(tmp_path / "copy")
    yield opened
    opened.close()
