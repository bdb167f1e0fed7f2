"""Computes blocks on a cluster. If the cluster is lost during the run, the run waits for the cluster."""

import time
from typing import TYPE_CHECKING

import numpy as np
from distributed import Client
from numpy.typing import NDArray

from damperlab.worker.dispatch.preparation import compile_at_workers
from damperlab.worker.dispatch.window import Window
from damperlab.worker.outcomes import ClusterUnusable, SchedulerLost, asking_the_cluster
from damperlab.worker.run.calls import Calls
from damperlab.worker.scenes import scenes

if TYPE_CHECKING:
    from damperlab.worker.run.runner import Run

AGAIN_SECONDS = 1.0
"""Time between attempts to reach a lost scheduler [s]."""


def compute_on_cluster(run: "Run") -> None:
    """Compute the pending blocks of a run on a cluster until none is left or the run stops.

    If the scheduler is lost, the function waits up to `return_seconds` until it comes back. If the scheduler
    is lost again, the wait starts anew only if more blocks were completed meanwhile.

    Raises
    ------
    Outage
        If no worker could compute for `wait_seconds`, or the scheduler did not return in time.
    ClusterUnusable
        If no cluster can be reached, and the run has not used a cluster before.
    """
    returns, run.had_cluster = run.had_cluster, True
    lost: SchedulerLost | None = None
    pending, gives_up_at = run.pending(), 0.0
    while pending.size and not run.stopping:
        first = lost is None
        try:
            if first:
                run.reporter.enter("starting")
            with run.client_factory() as client:
                run.reporter.enter("starting")
                _compute_at(run, client, pending)
            return
        except SchedulerLost as error:
            lost = error
        except ClusterUnusable:
            if lost is None and not returns:
                raise
            lost = lost or SchedulerLost()
        left = run.pending()
        if first or left.size < pending.size:
            gives_up_at = time.monotonic() + run.limits.return_seconds
        pending = left
        if time.monotonic() >= gives_up_at:
            raise lost
        run.reporter.wait(str(lost), gives_up_at)
        run.reporter.enter("waiting", message=str(lost))
        time.sleep(min(AGAIN_SECONDS, run.limits.return_seconds))


def _compute_at(run: "Run", client: Client, pending: NDArray[np.int64]) -> None:
    record = run.lease.store.find(run.lease.study_id)
    calls = Calls(run, record)
    window = Window(
        client,
        calls.of_block,
        run.plan.order(pending),
        run.expected,
        wait_seconds=run.limits.wait_seconds,
        priority=record.priority,
    )
    run.reporter.watch(window)
    try:
        if _assemble(run, window, client, calls, pending):
            run.reporter.begin_blocks(record, float(run.expected[pending].sum()))
            run.pump(window)
    finally:
        run.reporter.close()
        window.close()


def _assemble(run: "Run", window: Window, client: Client, calls: Calls, pending: NDArray[np.int64]) -> bool:
    """Select workers with the same solver, and compile their kernels. Return False if the study was stopped."""

    def look_on() -> bool:
        run.reporter.report_workers()
        return not run.stopping

    facts = window.assemble(calls.of_examination(None), calls.begun, "", look_on)
    if facts is None:
        return False
    calls.agree({"the workers": facts})
    usable = [worker.address for worker in window.workers.usable]
    with asking_the_cluster(client):
        for done, total in compile_at_workers(client, scenes(run.plan.study), usable):
            run.reporter.enter("compiling", done, total)
            if run.stopping:
                break
    canary, truth = calls.canary(pending)
    return window.assemble(calls.of_examination(canary), facts["identity"], truth, look_on) is not None
