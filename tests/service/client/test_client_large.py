"""A million points through the client: only what is looked at travels."""

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from damperlab import Client
from damperlab.studies.definition import parse_study
from damperlab.studies.plan import plan_with_chunk
from damperlab.studies.store.cube.cube import stored_variables, write_region
from damperlab.studies.store.record import BlockOutcome
from damperlab.studies.store.store import Store

SIDE, STEP = 1000, 100


@pytest.fixture(scope="module")
def large(service: Any) -> Iterator[str]:
    """A cancelled study of 1000 x 1000 points of which the first ten blocks are done, a block's index as its values."""
    store = Store.open(service.log.parent / "data")
    axes = {"friction_ratio": (0.1, 0.9), "frequency_ratio": (0.5, 1.5)}
    study = parse_study(
        {
            "name": "a million",
            "particle": False,
            "metrics": ["amplitude_ratio"],
            "axes": {name: {"start": a, "stop": b, "num": SIDE} for name, (a, b) in axes.items()},
        }
    )
    plan = plan_with_chunk(study, (1, 1, 1, 1, STEP, STEP), lambda _, at: np.ones(len(at["mass_ratio"])))
    record, _ = store.submit(study, plan, {})
    assert store.claim(record.id, "the test", 600.0)
    store.set_state(record.id, "cancelled")
    for index in range(SIDE // STEP):
        block = plan.block(index)
        values = {v.name: np.full(block.shape, index, v.dtype) for v in stored_variables(study)}
        values["status"][...] = 0
        found = write_region(store.cube_path(record.id), block, values, "first")
        outcome = BlockOutcome(index, block.points, 0, 1.0, 1.0, generation="first", checksum=found)
        store.mark(record.id, outcome)
    yield record.id
    store.delete(record.id)
    store.close()


def test_slice_of_a_large_cube_fetches_its_own_blocks(service: Any, helpers: Any, large: str) -> None:
    with Client(service.url) as client:
        cube = client.study(large).cube()
        assert cube["amplitude_ratio"].size == SIDE**2
        before = len(service.log.read_text())
        part = cube["amplitude_ratio"].isel(friction_ratio=5, frequency_ratio=slice(150, 350)).values.ravel()

    def fetched() -> int:
        return service.log.read_text()[before:].count("/zarr/amplitude_ratio/c")

    # the log has a request a moment after its answer has gone
    helpers.wait_until(lambda: fetched() >= 3)
    # 50 points of block 1, 100 of block 2, 50 of block 3
    np.testing.assert_array_equal(part, np.repeat([1.0, 2.0, 3.0], [50, 100, 50]))
    assert fetched() == 3


def test_map_of_a_million_points(service: Any, large: str) -> None:
    with Client(service.url) as client:
        answer = client.study(large).resonance_map()
    assert answer.sizes == {"frequency_ratio": SIDE, "friction_ratio": SIDE}
    assert answer.attrs["complete"] == 0.1
    row = answer["amplitude_ratio"].sel(friction_ratio=0.1)
    np.testing.assert_array_equal(row, np.repeat(np.arange(10.0), STEP))
    assert int(answer["amplitude_ratio"].isnull().sum()) == SIDE**2 - 10 * STEP**2
