"""Computes blocks on a cluster. If the cluster is lost during the run, the run waits for the cluster."""

import time
from collections.abc import Callable
from contextlib import AbstractContextManager
from functools import partial

import numpy as np
from distributed import Client
from numpy.typing import NDArray

from damperlab.studies.plan import Plan
from damperlab.studies.store.store import Store
from damperlab.worker.dispatch.backlog import Backlog
from damperlab.worker.dispatch.preparation import compile_at_workers
from damperlab.worker.dispatch.window import Window
from damperlab.worker.outcomes import ClusterUnusable, SchedulerLost, asking_the_cluster
from damperlab.worker.run.calls import Calls
from damperlab.worker.run.lease import Lease
from damperlab.worker.run.reporter import Reporter
from damperlab.worker.scenes import scenes

AGAIN_SECONDS = 1.0
"""Time between attempts to reach a lost scheduler [s]."""


class OnCluster:
    """Sends the missing blocks of a study to a cluster.

    Parameters
    ----------
    store : Store
        Store that holds the study.
    lease : Lease
        This run's claim on the study.
    reporter : Reporter
        Object that reports phase and progress.
    plan : Plan
        Division of the study into blocks.
    expected : ndarray of float
        Expected time of each block [s].
    stopping : callable
        Returns True if the run is stopping and no more blocks may start.
    there_before : bool
        Whether this run has used a cluster before. If true, the run waits for a cluster that cannot be reached.
    """

    def __init__(
        self,
        store: Store,
        lease: Lease,
        reporter: Reporter,
        plan: Plan,
        expected: NDArray[np.float64],
        stopping: Callable[[], bool],
        *,
        there_before: bool = False,
    ) -> None:
        self._store = store
        self._lease = lease
        self._reporter = reporter
        self._plan = plan
        self._expected = expected
        self._stopping = stopping
        self._there_before = there_before

    def compute(
        self,
        client_factory: Callable[[], AbstractContextManager[Client]],
        pump: Callable[[Window], None],
        wait_seconds: float,
        return_seconds: float,
    ) -> None:
        """Compute the pending blocks until none is left or the study stops.

        Parameters
        ----------
        client_factory : callable
            Returns a context manager that yields a client, see `damperlab.worker.run.runner.run_study`.
        pump : callable
            Processes the results of a `Window` until the window is empty or the study stops.
        wait_seconds : float
            Longest wait while no worker can compute [s].
        return_seconds : float
            Longest wait for a lost scheduler [s]. If the scheduler is lost again after further blocks were completed,
            the wait starts anew.

        Raises
        ------
        Outage
            If a wait takes longer than `wait_seconds` or `return_seconds`.
        ClusterUnusable
            If no cluster can be reached, and this run has not used a cluster before.
        """
        lost: SchedulerLost | None = None
        pending, gives_up_at = self._pending(), 0.0
        while pending.size and not self._stopping():
            first = lost is None
            try:
                if first:
                    self._reporter.enter("starting")
                with client_factory() as client:
                    self._reporter.enter("starting")
                    self._compute_at(client, pending, pump, wait_seconds)
                return
            except SchedulerLost as error:
                lost = error
            except ClusterUnusable:
                if lost is None and not self._there_before:
                    raise
                lost = lost or SchedulerLost()
            left = self._pending()
            if first or left.size < pending.size:
                gives_up_at = time.monotonic() + return_seconds
            pending = left
            if time.monotonic() >= gives_up_at:
                raise lost
            self._reporter.wait(str(lost), gives_up_at)
            self._reporter.enter("waiting", message=str(lost))
            time.sleep(min(AGAIN_SECONDS, return_seconds))

    def _pending(self) -> NDArray[np.int64]:
        return self._store.pending(self._lease.study_id)

    def _compute_at(
        self, client: Client, pending: NDArray[np.int64], pump: Callable[[Window], None], wait_seconds: float
    ) -> None:
        record = self._store.find(self._lease.study_id)
        calls = Calls(self._store, self._lease, self._plan, record)
        window = Window(
            client,
            calls.of_block,
            Backlog(self._plan.order(pending), self._expected),
            wait_seconds=wait_seconds,
            priority=record.priority,
        )
        self._reporter.watch(window.workers)
        try:
            if self._assemble(window, client, calls, pending):
                self._reporter.begin_blocks(record, float(self._expected[pending].sum()))
                pump(window)
        finally:
            self._reporter.close(window.stranded)
            window.close()

    def _assemble(self, window: Window, client: Client, calls: Calls, pending: NDArray[np.int64]) -> bool:
        """Select workers with the same solver, and compile their kernels. Return False if the study was stopped."""
        look_on = partial(self._look_on, window)
        facts = window.assemble(calls.of_examination(None), calls.begun, "", look_on)
        if facts is None:
            return False
        calls.agree({"the workers": facts})
        usable = [worker.address for worker in window.workers.usable]
        with asking_the_cluster(client):
            compile_at_workers(
                client, scenes(self._plan.study), self._reporter.compiling, self._stopping, usable
            )
        canary, truth = calls.canary(pending)
        examination = calls.of_examination(canary)
        return window.assemble(examination, facts["identity"], truth, look_on) is not None

    def _look_on(self, window: Window) -> bool:
        """Report events about workers, and return whether the study continues."""
        self._reporter.tell_of_workers(window.stranded, window.gives_up_at)
        return not self._stopping()
