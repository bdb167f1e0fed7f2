"""Compiles missing kernels and computes blocks on a cluster. If the cluster is lost, the run waits for the cluster."""

import time
from collections.abc import Collection, Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np
from distributed import Client
from numpy.typing import NDArray

from damperlab.worker.dispatch.tasks import sealed
from damperlab.worker.dispatch.window import Window
from damperlab.worker.jit import CACHE_FOLDER
from damperlab.worker.outcomes import ClusterUnusable, SchedulerLost, asking_the_cluster
from damperlab.worker.provenance import identity
from damperlab.worker.run.calls import Calls
from damperlab.worker.scenes import Scene, scenes
from damperlab.worker.warm import missing, warm

if TYPE_CHECKING:
    from damperlab.worker.run.runner import Run

AGAIN_SECONDS = 1.0
"""Time between attempts to reach a lost scheduler [s]."""
LOOK_SECONDS = 0.2
"""Interval between checks of a compilation [s]. A request to stop is noticed after this time at the latest."""


def compute_on_cluster(run: "Run") -> None:
    """Compute the pending blocks of a run on a cluster until none is left or the run stops.

    If the scheduler is lost, the function waits up to `return_seconds` for the scheduler to come back. If the
    scheduler is lost again, the wait starts anew only if more blocks were completed meanwhile.

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
        run.plan.block_seconds,
        wait_seconds=run.limits.wait_seconds,
        priority=record.priority,
    )
    run.reporter.watch(window)
    try:
        if _assemble(run, window, client, calls, pending):
            run.reporter.begin_blocks(record, float(run.plan.block_seconds[pending].sum()))
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


def compile_at_workers(
    client: Client, wanted: Sequence[Scene], workers: Collection[str]
) -> Iterator[tuple[int, int]]:
    """Compile the missing kernels of the given scenes on each machine of a cluster.

    Compilation errors are ignored here, because the first block compiles the kernel again and reports the error. If the
    caller stops the iteration, running compilations continue at their workers.

    Yields
    ------
    done, total : int
        Number of ended compilations, and number of all compilations, yielded every `LOOK_SECONDS`. Nothing is
        yielded if no kernel is missing.
    """
    if not wanted:
        return
    places: dict[tuple[str, str], tuple[list[Scene], list[str]]] = {}
    asked = client.run(_lacking, list(wanted), workers=list(workers), on_error="ignore")
    for address, answer in asked.items():
        # the worker has left in the meantime
        if answer is None:
            continue
        host, folder, lacking = answer
        places.setdefault((host, folder), (lacking, []))[1].append(address)
    tasks = [
        # if the worker is lost, any other worker may compile the scene, because waiting would take longer
        client.submit(
            *sealed(warm, scene), pure=False, workers=[there[i % len(there)]], allow_other_workers=True
        )
        for lacking, there in places.values()
        for i, scene in enumerate(lacking)
    ]
    while tasks:
        done = sum(task.done() for task in tasks)  # includes failed and lost compilations
        yield done, len(tasks)
        if done == len(tasks):
            return
        time.sleep(LOOK_SECONDS)


def all_ready(client: Client, wanted: Sequence[Scene]) -> bool:
    """Return whether every worker of a cluster has all kernels of the given scenes."""
    if not wanted:
        return True
    answers = client.run(_lacking, list(wanted), on_error="ignore").values()
    return bool(answers) and not any(lacking for _, _, lacking in answers)


def _lacking(wanted: list[Scene]) -> tuple[str, str, list[Scene]]:
    """Return the name of this machine, the folder of its kernels, and the scenes whose kernels are missing."""
    return identity()["host"], str(CACHE_FOLDER), missing(wanted)
