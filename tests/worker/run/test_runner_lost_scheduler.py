"""A study on somebody else's scheduler, which dies while the study runs."""

import threading
from contextlib import ExitStack
from pathlib import Path

import dask
import psutil
import pytest
from tests.worker.dask_processes import member, scheduler_process

from damperlab.studies.definition import parse_study
from damperlab.studies.plan import plan_with_chunk
from damperlab.studies.store.record import Record
from damperlab.studies.store.store import Store
from damperlab.worker.cluster.cluster import connect
from damperlab.worker.dispatch.cost_model import seconds_per_point
from damperlab.worker.provenance import provenance
from damperlab.worker.run.progress import Progress
from damperlab.worker.run.runner import run_study

pytestmark = [pytest.mark.night, pytest.mark.usefixtures("anew")]


def submitted(store: Store, chunk: int = 4) -> Record:
    study = parse_study(
        {
            "name": "linear",
            "damping_ratio": 0.0038,
            "axes": {"friction_ratio": 0, "frequency_ratio": {"start": 0.5, "stop": 1.5, "num": 4000}},
            "particle": False,
        }
    )
    record, _ = store.submit(
        study, plan_with_chunk(study, (1, 1, 1, 1, 1, chunk), seconds_per_point), provenance()
    )
    return record


def test_scheduler_that_comes_back_is_gone_on_with(tmp_path: Path) -> None:
    store = Store.open(tmp_path)
    record = submitted(store)
    with ExitStack() as stack:
        address, process = stack.enter_context(scheduler_process())
        # one worker, which comes back by itself
        stack.enter_context(member(address))
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


def test_embedded_scheduler_that_dies_is_replaced_and_leaves_no_process(tmp_path: Path) -> None:
    """As where the system kills it for want of memory."""
    store = Store.open(tmp_path)
    record = submitted(store)
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
