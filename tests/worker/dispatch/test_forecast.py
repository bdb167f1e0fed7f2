"""What blocks are expected to take: learnt from those that have ended, and it decides their order alone."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from tests.benchmarks import model
from tests.worker.run_here import planned, run_here, submit

from damperlab.service.estimates import estimate_document
from damperlab.studies.definition import Study, parse_study
from damperlab.studies.plan import Plan, plan_with_chunk
from damperlab.studies.store.catalogue.tables import done_blocks
from damperlab.studies.store.reuse.measured import measured_blocks, measured_family
from damperlab.studies.store.store import Store
from damperlab.worker.dispatch.backlog import HANDING_SECONDS, RESERVE, Backlog
from damperlab.worker.dispatch.forecast import Forecast, known_of
from damperlab.worker.dispatch.piece import Piece

ROWS = (1, 1, 1, 1, 1, 8)


def friction_study(rows: int, **more: Any) -> Study:
    axes = {
        "friction_ratio": {"start": 0.1, "stop": 0.7, "num": rows},
        "frequency_ratio": {"start": 0.7, "stop": 1.3, "num": 8},
    }
    return parse_study({"damping_ratio": 0.05, "axes": axes, "particle": False, **more})


def flat(study: Any, at: dict[str, NDArray[Any]]) -> NDArray[np.float64]:
    return np.full(len(at["frequency_ratio"]), 0.5)


def plan_of(rows: int) -> Plan:
    return plan_with_chunk(friction_study(rows), ROWS, flat)


def test_forecast_of_nothing_is_the_cost_model() -> None:
    plan = plan_of(20)
    forecast = Forecast(plan)
    np.testing.assert_array_equal(forecast.seconds, plan.block_seconds)
    assert not forecast.informed
    # a block that took no time, as one whose points were known, tells nothing
    assert not forecast.learn(3, 0.0)
    assert not forecast.informed


@given(st.floats(1e-6, 1e6), st.sets(st.integers(0, 19), min_size=1))
@settings(deadline=None)
def test_where_all_blocks_are_off_by_one_factor_so_is_the_forecast_of_the_others(
    factor: float, ended: set[int]
) -> None:
    plan = plan_of(20)
    forecast = Forecast(plan)
    for index in sorted(ended):
        forecast.learn(index, factor * plan.block_seconds[index])
    # a mean of equal logarithms, of at most 14 in absolute value, and its exponential
    np.testing.assert_allclose(forecast.seconds, factor * plan.block_seconds, rtol=1e-13)


def test_blocks_beside_those_that_took_long_are_expected_to_take_longer_than_those_far_from_them() -> None:
    plan = plan_of(40)
    truth = np.where(np.arange(40) < 20, 10.0, 1.0) * plan.block_seconds
    forecast = Forecast(plan)
    for index in range(0, 40, 4):
        forecast.learn(index, truth[index])
    # between two that are known each is nearer to one of its own half
    assert forecast.seconds[:17].min() > forecast.seconds[21:].max()
    # means of what is known cannot leave its range
    assert (forecast.seconds >= truth.min() * (1 - 1e-12)).all()
    assert (forecast.seconds <= truth.max() * (1 + 1e-12)).all()
    assert (forecast.cautious >= forecast.seconds).all()


@given(st.lists(st.floats(1e-3, 1e3), min_size=30, max_size=30), st.sets(st.integers(0, 29)))
@settings(deadline=None)
def test_every_block_is_given_once_whatever_is_learnt(truth: list[float], done: set[int]) -> None:
    pending = sorted(set(range(30)) - done)
    backlog = Backlog(pending, Forecast(plan_of(30)), whole=lambda index: True)
    taken: list[int] = []
    while (piece := backlog.take()) is not None:
        assert piece.part is None
        taken.append(piece.index)
        assert backlog.left == len(pending) - len(taken)
        if len(taken) > 3:
            backlog.learn(Piece(taken[-3]), truth[taken[-3]])
    assert sorted(taken) == pending


def test_equal_blocks_begin_spread_over_the_grid_and_the_dear_ones_first() -> None:
    backlog = Backlog(range(64), Forecast(plan_of(64)))
    first = [backlog.take() for _ in range(8)]
    # eight in a row would all lie in one of these four parts, which costs the others a forecast
    assert len({piece.index // 16 for piece in first if piece is not None}) == 4
    half = plan_with_chunk(
        friction_study(64), ROWS, lambda study, at: np.where(at["friction_ratio"] > 0.4, 2.0, 1.0)
    )
    backlog = Backlog(range(64), Forecast(half))
    assert all(piece is not None and piece.index >= 32 for piece in (backlog.take() for _ in range(16)))


def test_short_blocks_go_behind_long_ones_until_the_reserve_is_left() -> None:
    plan = plan_with_chunk(
        friction_study(64), ROWS, lambda study, at: np.where(at["friction_ratio"] > 0.4, 200.0, 0.001)
    )
    forecast = Forecast(plan)
    threads, long, short = 8, set(range(32, 64)), set(range(32))
    assert plan.block_seconds[:32].max() < HANDING_SECONDS * threads < plan.block_seconds[63]
    forecast.learn(63, float(plan.block_seconds[63]))
    backlog = Backlog(range(63), forecast, whole=lambda index: True)
    # one that waits behind nothing is the longest
    first = backlog.take(threads, behind_seconds=0.0)
    assert first is not None
    assert first.index in long
    behind = [backlog.take(threads, behind_seconds=10.0) for _ in range(32)]
    indices = [piece.index for piece in behind if piece is not None]
    spent = 32 - int(RESERVE * threads)
    assert set(indices[:spent]) <= short
    assert set(indices[spent:]) <= long
    # every block is given once
    while (piece := backlog.take(threads)) is not None:
        indices.append(piece.index)
    assert sorted([first.index, *indices]) == list(range(63))


def computed(store: Store, study: Study) -> str:
    return run_here(store, submit(store, study, ROWS).id).id


def test_studies_of_a_family_tell_what_blocks_take_and_others_do_not(store: Store) -> None:
    coarse = computed(store, friction_study(5))
    computed(store, friction_study(5, steady={"max_cycles": 50}))  # other settings: no family
    finer = friction_study(16)
    plan, record = planned(finer, ROWS), submit(store, finer, ROWS)
    (measured,) = measured_blocks(store, record.id)
    assert measured.record.id == coarse
    assert measured.indices.tolist() == list(range(5))
    assert measured.kernel_seconds.sum() == pytest.approx(store.find(coarse).kernel_seconds, rel=1e-12)
    known = known_of(measured_blocks(store, record.id))
    assert known is not None
    ratios = known[1]
    forecast = Forecast(plan, known)
    assert forecast.informed
    corrections = forecast.seconds / plan.block_seconds
    assert ratios.min() * (1 - 1e-12) <= corrections.min() <= corrections.max()
    assert corrections.max() <= ratios.max() * (1 + 1e-12)
    # known before it is submitted
    blind, told = estimate_document(finer, plan), estimate_document(finer, plan, store)
    assert told["seconds"] - told["compiling_seconds"] == pytest.approx(forecast.seconds.sum(), rel=1e-12)
    assert blind["seconds"] - blind["compiling_seconds"] == pytest.approx(plan.seconds, rel=1e-12)
    for each in (blind, told):
        assert each["seconds_low"] < each["seconds"] < each["seconds_high"]
    # who knows more is surer
    assert told["seconds_high"] / told["seconds_low"] < blind["seconds_high"] / blind["seconds_low"]
    assert measured_family(store, "") == []
    with store.catalogue.writing() as connection:
        # what cannot be is left out
        connection.execute(done_blocks.update().values(kernel_seconds=float("inf")))
    assert measured_blocks(store, record.id) == []
    assert known_of(measured_blocks(store, record.id)) is None


@pytest.mark.parametrize("workers", [2, 8, 32])
def test_workers_are_nearly_as_busy_as_they_can_be(workers: int) -> None:
    """With what real points took, 18 blocks and more a worker: within two points of the best that whole blocks allow."""
    share = model.busy(4, workers)
    for kind in ("first", "family"):
        assert share["best_whole"] - 0.02 <= share[kind] <= share["best_cut"]
    assert share["best_whole"] <= share["best_cut"]
    estimate = model.estimates(4)
    assert estimate["family"] == pytest.approx(estimate["true"], rel=0.1)


def test_few_blocks_keep_more_workers_busy_than_there_are_blocks_for() -> None:
    share = model.busy(2, 128)
    assert share["first"] > share["best_whole"] + 0.02
    assert share["first"] <= share["best_cut"]
