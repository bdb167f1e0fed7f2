"""Complete cubes shown with many blocks to a chunk."""

import json
from math import prod

import numpy as np
import pytest
import zarr
from zarr.core.buffer import default_buffer_prototype
from zarr.storage import MemoryStore

from damperlab.studies.store.cube.chunks import BlockDamaged
from damperlab.studies.store.cube.cube import write_region
from damperlab.studies.store.cube.description import describe_cube, plain_metadata
from damperlab.studies.store.export.grouped import POINTS, group_of, grouped_chunks, grouped_metadata
from damperlab.studies.store.record import BlockOutcome


@pytest.mark.parametrize(
    ("shape", "chunk"),
    [
        ((1, 4, 4, 50, 50, 250), (1, 1, 1, 1, 4, 250)),
        ((1, 1, 1, 5, 3, 4), (1, 1, 1, 2, 2, 3)),
        ((1, 1, 1, 1, 1, 10**6), (1, 1, 1, 1, 1, 999)),
        ((2, 2, 2, 300, 300, 300), (2, 2, 2, 30, 30, 30)),
    ],
)
def test_groups_are_whole_blocks_within_a_bound(shape, chunk):
    grouped = grouped_chunks(shape, chunk)
    assert all(step % own == 0 for step, own in zip(grouped, chunk, strict=True))
    assert prod(grouped) <= max(POINTS, prod(chunk))
    # along the first dimension that is not covered another block would be too much, or there is none
    counts = [-(-extent // own) for extent, own in zip(shape, chunk, strict=True)]
    axis = max((a for a in range(6) if grouped[a] < counts[a] * chunk[a]), default=None)
    assert axis is None or prod(grouped) // grouped[axis] * (grouped[axis] + chunk[axis]) > POINTS


def test_zarr_reads_the_groups_as_the_cube_is(store, make_study, make_plan_of, values_of, monkeypatch):
    monkeypatch.setattr(
        "damperlab.studies.store.export.grouped.POINTS", 24
    )  # some groups in this small cube, cut off at its ends
    study = make_study(metrics=["amplitude_ratio", "period"])
    plan = make_plan_of(study)
    record, _ = store.submit(study, plan, {"host": "one", "user": "somebody", "numba": "0"})
    for index in range(plan.count):
        block = plan.block(index)
        write_region(store.cube_path(record.id), block, values_of(study, block), "g")
        store.mark(record.id, BlockOutcome(index, block.points, 0, 1, 1, generation="g"))
    shelf, marks = store.snapshot(record.id)
    described = describe_cube(shelf.get("zarr.json"))
    metadata = grouped_metadata(plain_metadata(shelf.get("zarr.json")))
    assert json.loads(json.loads(metadata)["attributes"]["provenance"]) == {"numba": "0"}
    step = json.loads(metadata)["consolidated_metadata"]["metadata"]["period"]["chunk_grid"]["configuration"]
    counts = [-(-extent // at) for extent, at in zip(record.shape, step["chunk_shape"], strict=True)]
    assert 1 < prod(counts) < plan.count
    buffer = default_buffer_prototype().buffer.from_bytes
    held = {"zarr.json": buffer(metadata)}
    seen: list[int] = []
    for place in np.ndindex(*counts):
        for name in described.arrays:
            key = f"{name}/{'.'.join(map(str, place))}"
            group = group_of(key, described)
            assert group is not None
            held[key] = buffer(group.content(shelf, marks))
        seen += group.blocks()
    assert sorted(seen) == list(range(plan.count))
    shown = zarr.open_group(MemoryStore(held), mode="r", use_consolidated=True)
    for name, expected in store.cube(record.id).data_vars.items():
        np.testing.assert_array_equal(np.asarray(shown[str(name)][:]), expected.values)  # type: ignore[index]
    before = group.tag(marks)
    assert group.tag({**marks, group.blocks()[0]: "other"}) != before
    shelf.remove("blocks/0~g")
    with pytest.raises(BlockDamaged):
        group_of(f"{group.array.name}/0.0.0.0.0.0", described).content(shelf, marks)  # type: ignore[union-attr]


@pytest.mark.parametrize(
    "key", ["period/0.0.0.0.0", "period/0.0.0.0.0.99", "period/c.0.0.0.0.0.0", "x/0", "zarr.json"]
)
def test_other_keys_are_no_groups(store, make_study, make_plan_of, key):
    record, _ = store.submit(make_study(), make_plan_of(make_study()), {})
    assert group_of(key, describe_cube(store.snapshot(record.id)[0].get("zarr.json"))) is None
