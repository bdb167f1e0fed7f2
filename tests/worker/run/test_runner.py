"""Whole studies on real worker processes and a real store: to the end, stopped, resumed, hit by failures."""

import multiprocessing
import os
import shutil
import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager, nullcontext
from typing import Any

import numpy as np
import psutil
import pytest
import xarray as xr
from distributed import Client
from tests.worker.run_here import (
    BLOCKS,
    friction_study,
    give_up,
    hold_for_good,
    ignore,
    never,
    of_one_piece,
    run_here,
    submit,
)

from damperlab.studies.definition import Study
from damperlab.studies.plan import Block
from damperlab.studies.store.faults import StudyBusy, StudyNotFound
from damperlab.studies.store.record import BlockOutcome, Record
from damperlab.studies.store.store import Store
from damperlab.studies.variables import Status
from damperlab.worker.block import solve_block
from damperlab.worker.cluster.cluster import connect
from damperlab.worker.run.progress import EVEN, Meter, Progress
from damperlab.worker.run.runner import run_study


@pytest.fixture(scope="module")
def client() -> Iterator[Client]:
    with connect(workers=2) as client:
        yield client


@pytest.fixture
def submitted(store: Store) -> Record:
    return submit(store)


@contextmanager
def meanwhile(client: Client, happens: Callable[[Block], None]) -> Iterator[None]:
    """Let something happen at the workers that are alive before each block is solved."""

    def alter() -> None:
        import damperlab.worker.worker_process.tasks

        def other(study: Study, block: Block, *known: Any) -> Any:
            happens(block)
            return solve_block(study, block, *known)

        damperlab.worker.worker_process.tasks.solve_block = other

    def heal() -> None:
        import damperlab.worker.worker_process.tasks

        damperlab.worker.worker_process.tasks.solve_block = solve_block

    client.run(alter)
    try:
        yield
    finally:
        client.run(heal)


def slowly(block: Block) -> None:
    """So that a test can act while it runs."""
    time.sleep(0.2)


def test_cube_holds_what_the_solver_says_and_progress_rises_from_nothing_to_the_whole(
    client: Client, store: Store, submitted: Record
) -> None:
    seen: list[Progress] = []
    record = run_study(store, submitted.id, lambda: nullcontext(client), seen.append, threading.Event())
    assert (record.state, record.points_done, record.points_failed) == ("done", submitted.points_total, 0)
    assert record.owner is None
    assert 0.0 < record.kernel_seconds <= record.seconds
    assert of_one_piece(store, record.id, friction_study())
    # nothing is pending: no cluster is asked for
    assert run_study(store, submitted.id, never, ignore, threading.Event()).state == "done"
    assert seen[0].points_done == 0
    assert seen[0].seconds_left is None
    done = [progress.points_done for progress in seen]
    assert done == sorted(done)
    assert (seen[-1].points_done, seen[-1].blocks_done) == (submitted.points_total, BLOCKS)
    assert seen[-1].seconds_left == 0.0
    assert seen[-1].points_per_second > 0.0


def test_blocks_that_were_expected_to_take_longest_count_less_for_the_time_left(submitted: Record) -> None:
    """They are computed first: expected to take all of the time, they leave a quarter for the others."""
    meter = Meter(submitted, 10.0)
    time.sleep(0.01)
    meter.add(BlockOutcome(0, 1, 0), 10.0)
    now = meter.progress()
    spent = now.points_done / now.points_per_second
    others = EVEN * 10.0 * (1 - 1 / BLOCKS)
    assert now.seconds_left == pytest.approx(spent * others / (10.0 - others))


def test_failing_blocks_become_failed_points_and_the_rest_goes_on(
    client: Client, store: Store, submitted: Record
) -> None:
    def fail(block: Block) -> None:
        if block.start[4] == 2:
            raise ZeroDivisionError("broken on purpose")

    with meanwhile(client, fail):
        record = run_study(store, submitted.id, lambda: nullcontext(client), ignore, threading.Event())
    assert (record.state, record.blocks_done, record.points_failed) == ("done", BLOCKS, 12)
    assert "3 of 12 blocks failed" in record.message
    assert "ZeroDivisionError: broken on purpose" in record.message
    cube = store.cube(submitted.id)
    failed = (cube["status"] == Status.BLOCK_FAILED).squeeze()
    assert failed.sel(friction_ratio=0.4).all()
    assert not failed.drop_sel(friction_ratio=0.4).any()
    np.testing.assert_array_equal(np.isnan(cube["amplitude_ratio"].squeeze()), failed)
    # Looked at again, it says the same.
    again = run_study(store, submitted.id, never, ignore, threading.Event())
    assert (again.state, again.message) == (record.state, record.message)


def test_killed_workers_cost_time_and_no_points(client: Client, store: Store, submitted: Record) -> None:
    def kill_one(progress: Progress) -> None:
        if not killed and progress.blocks_done:
            killed.append(next(iter(client.run(os.getpid).values())))
            os.kill(killed[0], signal.SIGKILL)

    killed: list[int] = []
    with meanwhile(client, slowly):
        record = run_study(store, submitted.id, lambda: nullcontext(client), kill_one, threading.Event())
    assert killed
    assert not psutil.pid_exists(killed[0])
    assert (record.state, record.points_failed, record.message) == ("done", 0, None)


@pytest.fixture
def slow_here(monkeypatch: pytest.MonkeyPatch) -> None:
    """Blocks that are computed in this process take long enough to act meanwhile; their progress is told at once."""

    def solve(*asked: Any) -> Any:
        time.sleep(0.1)
        return solve_block(*asked)

    monkeypatch.setattr("damperlab.worker.worker_process.tasks.solve_block", solve)
    monkeypatch.setattr("damperlab.worker.run.progress.REPORT_SECONDS", 0.0)
    monkeypatch.setattr("damperlab.worker.run.lease.RENEW_SECONDS", 0.05)


@pytest.mark.usefixtures("slow_here")
def test_stopped_study_keeps_its_blocks_and_resume_computes_only_the_rest(
    store: Store, submitted: Record
) -> None:
    stop = threading.Event()

    def stop_after_two(progress: Progress) -> None:
        if progress.blocks_done >= 2:
            stop.set()

    record = run_here(store, submitted.id, stop_after_two, stop)
    assert record.state == "cancelled"
    assert 2 <= record.blocks_done < BLOCKS
    before = store.cube(submitted.id).load()
    kept = before["status"] != Status.NOT_COMPUTED
    assert int(kept.sum()) == record.points_done

    record = run_here(store, submitted.id)
    assert (record.state, record.blocks_done) == ("done", BLOCKS)
    after = store.cube(submitted.id).load()
    # Run times never repeat to the last bit: what has the same one was not computed again.
    xr.testing.assert_equal(before["run_time"].where(kept), after["run_time"].where(kept))


def test_no_client_is_started_for_a_study_that_is_stopped_already(store: Store, submitted: Record) -> None:
    stop = threading.Event()
    stop.set()
    record = run_study(store, submitted.id, never, ignore, stop)
    assert (record.state, record.blocks_done) == ("cancelled", 0)


def test_study_of_which_every_block_fails_is_failed(store: Store, submitted: Record) -> None:
    for index in range(BLOCKS):
        give_up(store, submitted, friction_study(), index)
    record = run_study(store, submitted.id, never, ignore, threading.Event())
    assert (record.state, record.points_failed) == ("failed", submitted.points_total)


def test_lost_cube_interrupts_and_says_so(store: Store, submitted: Record) -> None:
    shutil.rmtree(store.cube_path(submitted.id))
    record = run_here(store, submitted.id)
    assert (record.state, record.blocks_done) == ("failed", 0)
    assert "the study's data cannot be read" in record.message


@pytest.mark.usefixtures("slow_here")
def test_cancel_by_another_process_is_noticed(store: Store, submitted: Record) -> None:
    def cancel(progress: Progress) -> None:
        if progress.blocks_done:
            other.set_state(submitted.id, "cancelled", only_from=("running",))

    with closing(Store.open(store.data_dir)) as other:
        record = run_here(store, submitted.id, cancel)
    assert record.state == "cancelled"
    assert 1 <= record.blocks_done < BLOCKS


@pytest.mark.usefixtures("slow_here")
def test_study_that_is_deleted_while_it_runs_is_left(store: Store, submitted: Record) -> None:
    def delete(progress: Progress) -> None:
        if progress.blocks_done and not deleted:
            store.set_state(submitted.id, "cancelled")
            store.delete(submitted.id)
            deleted.append(True)

    deleted: list[bool] = []
    with pytest.raises(StudyNotFound):
        run_here(store, submitted.id, delete)


def test_claim_of_a_killed_process_is_taken_over_at_once(store: Store, submitted: Record) -> None:
    start = multiprocessing.get_context("spawn")
    told = start.SimpleQueue()
    process = start.Process(target=hold_for_good, args=(store.data_dir, submitted.id, told))
    process.start()
    assert told.get() == "held"
    with pytest.raises(StudyBusy):
        run_study(store, submitted.id, never, ignore, threading.Event())
    process.kill()
    process.join()
    assert run_here(store, submitted.id).state == "done"


def test_error_of_the_caller_leaves_the_study_failed_and_free(store: Store, submitted: Record) -> None:
    def fail(progress: Progress) -> None:
        raise LookupError("of the caller")

    with pytest.raises(LookupError):
        run_here(store, submitted.id, fail)
    record = store.find(submitted.id)
    assert (record.state, record.message, record.owner) == ("failed", "of the caller", None)
