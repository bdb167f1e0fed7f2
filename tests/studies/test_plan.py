"""Blocks cover the grid once, are sized by cost, and come longest first."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from damperlab.studies.definition import Study, parse_study
from damperlab.studies.plan import (
    BALANCED_BLOCKS,
    MAX_BLOCK_POINTS,
    MAX_BLOCKS,
    SHORTEST_BLOCK_SECONDS,
    Cost,
    chunk_of,
    make_plan,
    plan_with_chunk,
)


def grid(clearance: int = 1, friction: int = 1, frequency: int = 1) -> Study:
    def axis(start: float, stop: float, num: int) -> Any:
        return start if num == 1 else {"start": start, "stop": stop, "num": num}

    return parse_study(
        {
            "axes": {
                "clearance_ratio": axis(1, 25, clearance),
                "friction_ratio": axis(0, 0.8, friction),
                "frequency_ratio": axis(0.5, 1.5, frequency),
            }
        }
    )


def flat(seconds: float) -> Cost:
    return lambda study, at: np.full(at["mass_ratio"].shape, seconds)


def peaked(study: Study, at: dict[str, NDArray[np.float64]]) -> NDArray[np.float64]:
    return 1e-3 / (0.01 + np.abs(at["frequency_ratio"] - 1.0))


shapes = st.tuples(*[st.integers(1, 7)] * 6)


@given(shapes, st.integers(1, 400))
@settings(deadline=None)
def test_chunks_hold_no_more_than_asked_and_cut_evenly(shape: tuple[int, ...], size: int) -> None:
    chunk = chunk_of(shape, size)
    assert 1 <= math.prod(chunk) <= size
    for length, part in zip(shape, chunk, strict=True):
        pieces = -(-length // part)
        assert part == -(-length // pieces)


@given(shapes, shapes)
@settings(deadline=None, max_examples=40)
def test_blocks_cover_every_point_exactly_once(shape: tuple[int, ...], part: tuple[int, ...]) -> None:
    names = ("restitution", "mass_ratio", "clearance_ratio", "friction_ratio", "frequency_ratio")
    axes = {name: [0.1 * (i + 1) for i in range(n)] for name, n in zip(names, shape[1:], strict=True)}
    damping = [0.1 * i for i in range(shape[0])]
    study = parse_study({"damping_ratio": damping, "axes": axes})
    chunk = tuple(min(a, b) for a, b in zip(shape, part, strict=True))
    plan = plan_with_chunk(study, chunk, flat(1.0))
    seen = np.zeros(shape, dtype=int)
    for index in range(plan.count):
        block = plan.block(index)
        assert block.index == index
        assert seen[block.slices].shape == block.shape
        assert block.points == math.prod(block.shape) > 0
        seen[block.slices] += 1
    assert (seen == 1).all()
    assert plan.seconds == pytest.approx(plan.points)


def test_long_studies_get_blocks_of_about_two_seconds_with_whole_frequency_rows() -> None:
    plan = make_plan(grid(100, 100, 50), flat(1e-3))
    assert plan.chunk[-1] == 50
    assert 1.0 <= plan.block_seconds[0] <= 2.0
    assert plan.seconds == pytest.approx(500.0)


def test_short_studies_get_few_blocks_and_medium_ones_keep_workers_balanced() -> None:
    assert make_plan(grid(10, 10), flat(1e-5)).count == 1
    assert make_plan(grid(49, 33), flat(4.2 / 1617)).count >= BALANCED_BLOCKS
    assert make_plan(grid(49, 33), flat(20 / 1617)).count >= BALANCED_BLOCKS


def test_blocks_and_their_time_grow_with_the_square_root_of_the_time_of_a_study() -> None:
    least = BALANCED_BLOCKS * SHORTEST_BLOCK_SECONDS
    counts = [make_plan(grid(64, 64), flat(times * least / 64**2)).count for times in (1, 4, 16, 64)]
    assert counts == [BALANCED_BLOCKS, 2 * BALANCED_BLOCKS, 4 * BALANCED_BLOCKS, 8 * BALANCED_BLOCKS]


def test_slow_regions_keep_blocks_short() -> None:
    plan = make_plan(grid(300, 10, 101), peaked)
    assert plan.block_seconds.max() < 20.0


@pytest.mark.parametrize(
    ("shape", "seconds"), [((1000, 1000, 1000), 1e-7), ((1000, 1000, 1000), 10.0), ((999_983, 1, 1), 10.0)]
)
def test_many_points_are_planned_with_one_number_per_block(
    shape: tuple[int, int, int], seconds: float
) -> None:
    plan = make_plan(grid(*shape), flat(seconds))
    assert plan.points == math.prod(shape)
    assert plan.count <= MAX_BLOCKS
    assert math.prod(plan.chunk) <= MAX_BLOCK_POINTS
    assert len(plan.order()) == plan.count
    last = plan.block(plan.count - 1)
    assert tuple(a + n for a, n in zip(last.start, last.shape, strict=True)) == plan.shape


def test_order_is_longest_first_with_ties_by_number() -> None:
    plan = plan_with_chunk(grid(4, 1, 101), (1, 1, 1, 1, 1, 10), peaked)
    order = plan.order()
    seconds = plan.block_seconds[order]
    assert sorted(order) == list(range(plan.count))
    assert (np.diff(seconds) <= 0).all()
    equal = np.diff(seconds) == 0
    assert equal.any()
    assert (np.diff(order)[equal] > 0).all()
    some = plan.order([43, 7, 20])
    assert some.tolist() == [i for i in order if i in (7, 20, 43)]
    assert plan.order([]).tolist() == []


def test_blocks_cost_what_their_points_do_and_edge_blocks_less() -> None:
    plan = plan_with_chunk(grid(1, 1, 7), (1, 1, 1, 1, 1, 3), lambda study, at: at["frequency_ratio"])
    r = np.linspace(0.5, 1.5, 7)
    np.testing.assert_allclose(plan.block_seconds, [r[:3].sum(), r[3:6].sum(), r[6]], rtol=4e-16)
    np.testing.assert_array_equal(plan.seconds_of(np.array([2, 0])), plan.block_seconds[[2, 0]])


def test_cost_of_a_block_is_not_that_of_its_middle_alone() -> None:
    """Half of the points of one row cost ten times the others; its middle is one of the dear ones."""
    plan = plan_with_chunk(
        grid(1, 1, 100),
        (1, 1, 1, 1, 1, 100),
        lambda study, at: np.where(np.abs(at["frequency_ratio"] - 1.0) < 0.25, 1.0, 0.1),
    )
    # one sample of sixteen either way
    assert plan.seconds == pytest.approx(55.0, abs=0.9 * 100 / 16)


def test_plan_depends_on_the_study_alone_and_is_rebuilt_from_its_chunk() -> None:
    study = grid(49, 33, 5)
    plan = make_plan(study, peaked)
    assert make_plan(parse_study(study.document()), peaked).chunk == plan.chunk
    again = plan_with_chunk(study, plan.chunk, peaked)
    assert [again.block(i) for i in range(again.count)] == [plan.block(i) for i in range(plan.count)]
    with pytest.raises(ValueError, match="does not cut"):
        plan_with_chunk(study, (1, 1, 1, 50, 1, 1), peaked)
    for outside in (-1, plan.count):
        with pytest.raises(IndexError):
            plan.block(outside)


def test_the_cost_of_many_blocks_is_known_by_fewer_points_of_each() -> None:
    looked_at = []

    def cost(study: Any, at: Any) -> Any:
        looked_at.append(at["mass_ratio"].size)
        return np.full(at["mass_ratio"].shape, 1e-4) * (1.0 + at["frequency_ratio"])

    plan = make_plan(grid(20_000, 1, 20_000), cost)
    looked_at.clear()
    seconds = plan.seconds
    assert sum(looked_at) <= max(1 << 16, 4 * plan.count)
    r = plan.study.coordinates["frequency_ratio"]
    assert seconds == pytest.approx(20_000 * 1e-4 * (1.0 + r).sum(), rel=1e-3)
