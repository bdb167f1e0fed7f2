"""A study whose scheduler, or whose catalogue's server, is killed while it runs, and comes back."""

import threading
from contextlib import ExitStack, closing
from pathlib import Path

import dask
import numpy as np
import psutil
import pytest
from tests.faults.processes import Database
from tests.worker.dask_processes import scheduler_process, worker_process
from tests.worker.run_here import linear_study, run_here, submit

from damperlab.studies.store.faults import StoreFault
from damperlab.studies.store.record import Record
from damperlab.studies.store.store import Store
from damperlab.worker.cluster.cluster import connect
from damperlab.worker.run.progress import Progress
from damperlab.worker.run.runner import run_study


def linear(store: Store, chunk: int = 4) -> Record:
    """Enter 4,000 points in closed form."""
    return submit(store, linear_study(np.linspace(0.5, 1.5, 4000).tolist(), 0.0038), chunk)


@pytest.mark.night
@pytest.mark.usefixtures("anew")
def test_scheduler_that_comes_back_is_gone_on_with(tmp_path: Path) -> None:
    store = Store.open(tmp_path)
    record = linear(store)
    with ExitStack() as stack:
        address, process = stack.enter_context(scheduler_process())
        # one worker, which comes back by itself
        stack.enter_context(worker_process(address))
        kept: list[int] = []
        waited: list[str | None] = []
        patience: list[float] = []

        def kill(progress: Progress) -> None:
            if progress.blocks_done and not kept:
                process.kill()
                process.wait()
                kept.append(progress.blocks_done)
            now = store.find(record.id)
            if kept and now.phase == "waiting" and not waited:
                waited.append(now.message)
                patience.append(progress.gives_up_in)
                assert (progress.waits_for, progress.seconds_left) == (now.message, None)
                stack.enter_context(scheduler_process("--port", address.rpartition(":")[2]))

        ended = run_study(
            store,
            record.id,
            lambda: connect(scheduler=address),
            kill,
            threading.Event(),
            return_seconds=300.0,
        )
    assert all(0.0 < seconds <= 300.0 for seconds in patience)
    assert waited == ["the connection to the Dask scheduler was lost"]
    assert (ended.state, ended.points_failed, ended.message) == ("done", 0, None)
    assert 0 < kept[0] < ended.blocks_done == ended.blocks_total
    store.close()


@pytest.mark.night
@pytest.mark.usefixtures("anew")
def test_embedded_scheduler_that_dies_is_replaced_and_leaves_no_process(tmp_path: Path) -> None:
    """As where the system kills it for want of memory."""
    store = Store.open(tmp_path)
    record = linear(store)
    here = psutil.Process()
    before = {process.pid for process in here.children()}
    killed: list[int] = []

    def kill(progress: Progress) -> None:
        if progress.blocks_done and not killed:
            own = [each for each in here.children() if each.pid not in before]
            killed.extend(each.pid for each in own if "resource_tracker" not in " ".join(each.cmdline()))
            (scheduler,) = (each for each in own if "damperlab.worker.cluster.scheduler" in each.cmdline())
            scheduler.kill()

    with dask.config.set({"distributed.comm.timeouts.connect": "5s"}):
        ended = run_study(
            store, record.id, lambda: connect(workers=1), kill, threading.Event(), return_seconds=300.0
        )
    assert (ended.state, ended.points_failed, ended.message) == ("done", 0, None)
    assert len(killed) == 2
    assert not any(psutil.pid_exists(pid) for pid in killed)
    store.close()


@pytest.mark.parametrize("patience", [300.0, pytest.param(0.0, marks=pytest.mark.night)])
def test_a_catalogue_that_comes_back_in_time_is_gone_on_with(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, patience: float
) -> None:
    monkeypatch.setattr("damperlab.worker.run.progress.REPORT_SECONDS", 0.0)
    with (
        closing(Database(tmp_path / "postgresql")) as server,
        closing(Store.open(tmp_path / "data", server.address)) as store,
    ):
        record = linear(store, 200)
        kept: list[int] = []
        waited: list[str] = []

        def kill(progress: Progress) -> None:
            if progress.blocks_done and not kept:
                kept.append(progress.blocks_done)
                server.kill()
            if progress.waits_for and not waited:
                waited.append(progress.waits_for)
                server.keep_up()

        if not patience:
            with pytest.raises(StoreFault):
                run_here(store, record.id, kill, return_seconds=patience)
            return
        run_here(store, record.id, kill, return_seconds=patience)
        ended = store.find(record.id)
        assert (ended.state, ended.points_failed, ended.message) == ("done", 0, None)
        assert 0 < kept[0] < ended.blocks_done == ended.blocks_total
        assert "cannot be read or written" in waited[0]
