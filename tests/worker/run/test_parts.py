"""Blocks that are cut towards the end of a study: the same points, the same bits, one block each in the store."""

import math
import threading
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from tests.worker.run_here import of_one_piece, planned, submit

from damperlab.studies.definition import Study, parse_study
from damperlab.studies.plan import Block, plan_with_chunk
from damperlab.studies.store.record import BlockOutcome
from damperlab.studies.store.store import Store
from damperlab.worker.cluster.cluster import connect
from damperlab.worker.dispatch.backlog import Backlog
from damperlab.worker.dispatch.forecast import Forecast
from damperlab.worker.dispatch.piece import Piece, cut
from damperlab.worker.provenance import code_hash, computing
from damperlab.worker.run.gathering import Gathering
from damperlab.worker.run.progress import Progress
from damperlab.worker.run.runner import run_study
from damperlab.worker.worker_process.part import run_part


def study_of(rows: int, frequencies: int, **more: Any) -> Study:
    axes = {
        "friction_ratio": {"start": 0.1, "stop": 0.7, "num": rows},
        "frequency_ratio": {"start": 0.7, "stop": 1.3, "num": frequencies},
    }
    return parse_study({"damping_ratio": 0.05, "axes": axes, "particle": False, **more})


def second_each(study: Any, at: dict[str, NDArray[Any]]) -> NDArray[np.float64]:
    return np.ones(len(at["frequency_ratio"]))


shapes = st.lists(st.integers(1, 7), min_size=2, max_size=4).map(tuple)


@given(shapes, st.integers(1, 60), st.booleans(), st.integers(1, 9))
def test_parts_hold_each_point_once(
    shape: tuple[int, ...], number: int, whole_rows: bool, again: int
) -> None:
    block = Block(5, tuple(range(10, 10 + len(shape))), shape)
    parts = cut(Piece(5), block, number, whole_rows)
    # and parts of parts
    parts = [finer for part in parts for finer in cut(part, block, again, whole_rows)]
    count = np.zeros([first + length for first, length in zip(block.start, shape, strict=True)], int)
    for part in parts:
        assert part.part is not None
        assert part.index == part.part.index == 5
        assert not whole_rows or part.part.shape[-1] == shape[-1]
        count[part.part.slices] += 1
    assert (count[block.slices] == 1).all()
    assert count.sum() == block.points
    # sums of at most 2401 quotients, each off by at most half an ulp of 1
    assert math.isclose(sum(part.share for part in parts), 1.0, abs_tol=2401 * 2.0**-53)


def pieces(backlog: Backlog, threads: int) -> list[Piece]:
    taken = []
    while (piece := backlog.take(threads)) is not None:
        taken.append(piece)
    return taken


def test_pieces_get_shorter_towards_the_end_and_hold_all_blocks() -> None:
    plan = plan_with_chunk(study_of(40, 32), (1, 1, 1, 1, 1, 32), second_each)
    taken = pieces(Backlog(range(40), Forecast(plan)), 4)
    counts = np.zeros(plan.shape, int)
    for piece in taken:
        counts[(piece.part or plan.block(piece.index)).slices] += 1
    assert (counts == 1).all()
    assert taken[0].part is None
    assert taken[-1].share < 0.2
    # who may not be cut is not
    whole = pieces(Backlog(range(40), Forecast(plan), lambda index: True), 4)
    assert [piece.part for piece in whole] == [None] * 40
    # nor what is short beside the time that a scheduler takes to serve every thread
    assert all(piece.part is None for piece in pieces(Backlog(range(40), Forecast(plan)), 10_000))


@pytest.mark.parametrize("start", ["rest", {"kind": "continuation", "direction": "down"}])
def test_block_from_parts_is_the_block_in_one(store: Store, start: Any) -> None:
    study = study_of(6, 10, start=start)
    record = submit(store, study, (1, 1, 1, 1, 3, 10))
    plan, study_id, cube_path = planned(study, record.chunk), record.id, store.cube_path(record.id)
    gathering = Gathering(plan, cube_path)
    for index in range(plan.count):
        parts = cut(Piece(index), plan.block(index), 7, study.whole_rows)
        assert len(parts) >= 3
        came = []
        for piece in np.random.default_rng(index).permutation(np.array(parts, object)):
            identity = computing()["identity"]
            outcome = gathering.take(run_part(cube_path, record.digest, piece.part, code_hash(), identity))
            came.append(outcome)
        assert came[:-1] == [None] * (len(parts) - 1)
        assert isinstance(came[-1], BlockOutcome)
        assert store.mark(study_id, came[-1])
    assert store.find(study_id).points_done == 60
    assert of_one_piece(store, study_id, study)


@pytest.mark.night
def test_one_block_keeps_several_workers_busy(store: Store, monkeypatch: pytest.MonkeyPatch) -> None:
    """A study of a single block is computed by both workers of a cluster, with the bits of one."""
    monkeypatch.setattr("damperlab.worker.run.account.REPORT_SECONDS", 0.0)
    # several parts of it are each expected to take as long as a part must
    study = study_of(160, 200)
    flying: list[int] = []

    def watch(progress: Progress) -> None:
        flying.append(progress.blocks_in_flight)

    record, seconds = submit(store, study, study.shape), planned(study, study.shape).seconds
    assert (record.blocks_total, seconds > 0.8) == (1, True)
    ended = run_study(store, record.id, lambda: connect(workers=2), watch, threading.Event())
    assert (ended.state, ended.points_failed, ended.blocks_done) == ("done", 0, 1)
    assert max(flying) >= 2
    assert ended.kernel_seconds > 0.0
    assert of_one_piece(store, record.id, study)
