"""A cube on the disk with every kind of point in it: converged, failed, and not computed."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from damperlab.studies.definition import parse_study
from damperlab.studies.plan import plan_with_chunk
from damperlab.studies.store.cube.block_file import write_region
from damperlab.studies.store.cube.description import stored_variables
from damperlab.studies.store.store import Store
from damperlab.studies.variables import ResponseClass, Status

AXES = {
    "clearance_ratio": [1.0, 2.0, 5.0, 10.0, 20.0],
    "friction_ratio": {"start": 0.0, "stop": 0.6, "num": 4},
    "restitution": [0.2, 0.5, 0.8],
    "mass_ratio": [0.1],
    # uneven steps, so that a mean over the band is no mean of the points
    "frequency_ratio": [0.7, 0.8, 0.95, 1.0, 1.2, 1.25],
}


@pytest.fixture(scope="session")
def filled(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Store, str]]:
    folder: Path = tmp_path_factory.mktemp("answers")
    store = Store.open(folder)
    study = parse_study({"name": "answers", "damping_ratio": 0.0038, "axes": AXES})
    plan = plan_with_chunk(study, (1, 1, 1, 2, 3, 4), lambda _, at: np.ones(len(at["mass_ratio"])))
    study_id = store.submit(study, plan, {})[0].id
    rng = np.random.default_rng(11)
    for index in range(plan.count):
        if index % 7 == 5:
            continue
        block = plan.block(index)
        values = {v.name: rng.uniform(0.5, 9.0, block.shape).astype(v.dtype) for v in stored_variables(study)}
        values["status"] = rng.choice([0, 0, 0, 0, 0, 0, 1, 2], block.shape).astype(np.int8)
        values["response_class"] = rng.choice(
            [ResponseClass.LOCKED, ResponseClass.SYMMETRIC, ResponseClass.MODULATED], block.shape
        ).astype(np.int8)
        failed = values["status"] > Status.MAX_CYCLES
        for name, array in values.items():
            if name != "status":
                array[failed] = np.nan if array.dtype.kind == "f" else -1
        store.mark(study_id, write_region(store.cube_path(study_id), block, values))
    yield store, study_id
    store.close()


@pytest.fixture
def cube(filled: tuple[Store, str]) -> xr.Dataset:
    store, study_id = filled
    return store.cube(study_id)


@pytest.fixture
def whole(cube: xr.Dataset) -> xr.Dataset:
    """The same in memory, for the plain computation that an answer is compared with."""
    return cube.copy(deep=True).load()


@pytest.fixture
def finished(cube: xr.Dataset) -> xr.Dataset:
    """The same cube, in which the points that were not computed have failed."""
    waiting = cube["status"] == Status.NOT_COMPUTED
    return cube.assign(status=cube["status"].where(~waiting, Status.TOO_MANY_EVENTS))
