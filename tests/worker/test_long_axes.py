"""A long axis is expanded once, and a block reads its slice: neither time nor memory grows with the blocks."""

import tracemalloc

import numpy as np

from damperlab.studies.definition import parse_study
from damperlab.studies.plan import make_plan
from damperlab.worker.dispatch.cost_model import seconds_per_point
from damperlab.worker.kernel_arguments import block_points

MEBIBYTE = 2**20


def test_blocks_read_slices_of_an_axis_of_a_million_values() -> None:
    axes = {"friction_ratio": 0, "frequency_ratio": {"start": 0.5, "stop": 1.5, "num": 1_000_000}}
    study = parse_study({"damping_ratio": 0.05, "particle": False, "axes": axes})
    axis = study.coordinates["frequency_ratio"]
    plan = make_plan(study, seconds_per_point)
    assert plan.count > 1
    tracemalloc.start()
    for index in range(plan.count):
        block = plan.block(index)
        points = block_points(study, block)
        np.testing.assert_array_equal(points["frequency_ratio"], axis[block.slices[-1]])
    largest = max(plan.block(index).points for index in range(plan.count))
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    # six arrays of a block, twice while one follows another, and what comparing them takes: none of the axis's size
    assert peak < 16 * 8 * largest + MEBIBYTE
    assert study.coordinates["frequency_ratio"] is axis
    assert study.digest == parse_study(study.document()).digest
