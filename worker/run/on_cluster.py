"""Blocks computed on a cluster, even if it is lost half-way and comes back."""

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
from damperlab.worker.provenance import code_hash
from damperlab.worker.run.account import Account
from damperlab.worker.run.lease import Lease
from damperlab.worker.run.recipe import Recipe
from damperlab.worker.scenes import scenes

AGAIN_SECONDS = 1.0
"""Time between attempts to reach a lost scheduler."""


class OnCluster:
    """Sends the missing blocks of a study to a cluster.

    Parameters
    ----------
    store : Store
        Where the study is.
    lease : Lease
        The claim on it.
    account : Account
        Receives all reports.
    plan : Plan
        The blocks.
    expected : ndarray of float
        Expected time of each block [s].
    stopping : callable
        Whether to start no more blocks.
    there_before : bool
        Whether a cluster has computed for this run before; if it is unreachable now, it may come back.
    """

    def __init__(
        self,
        store: Store,
        lease: Lease,
        account: Account,
        plan: Plan,
        expected: NDArray[np.float64],
        stopping: Callable[[], bool],
        *,
        there_before: bool = False,
    ) -> None:
        self._store = store
        self._lease = lease
        self._account = account
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
        """Compute every pending block, or as many as the limits allow.

        Parameters
        ----------
        client_factory : callable
            As for `damperlab.worker.run.runner.run_study`.
        pump : callable
            Processes the results of a window until it is empty, or the study stops.
        wait_seconds : float
            Longest wait while no worker can compute [s].
        return_seconds : float
            Longest wait for a lost scheduler [s]; the time is counted anew after a loss if blocks were completed since
            the previous one.

        Raises
        ------
        Outage
            A wait takes longer than `wait_seconds` or `return_seconds`.
        ClusterUnusable
            There was no cluster from the start.
        """
        lost: SchedulerLost | None = None
        pending, gives_up_at = self._pending(), 0.0
        while pending.size and not self._stopping():
            first = lost is None
            try:
                if first:
                    self._account.enter("starting")
                with client_factory() as client:
                    self._account.enter("starting")
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
            self._account.wait(str(lost), gives_up_at)
            self._account.enter("waiting", message=str(lost))
            time.sleep(min(AGAIN_SECONDS, return_seconds))

    def _pending(self) -> NDArray[np.int64]:
        return self._store.pending(self._lease.study_id)

    def _compute_at(
        self, client: Client, pending: NDArray[np.int64], pump: Callable[[Window], None], wait_seconds: float
    ) -> None:
        record = self._store.find(self._lease.study_id)
        recipe = Recipe(self._store, self._lease, self._plan, record)
        window = Window(
            client,
            recipe.call,
            Backlog(self._plan.order(pending), self._expected),
            wait_seconds=wait_seconds,
            priority=record.priority,
        )
        self._account.watch(window.workers)
        try:
            if self._assemble(window, client, recipe, pending):
                self._account.begin_blocks(record, float(self._expected[pending].sum()))
                pump(window)
        finally:
            self._account.close(window.stranded)
            window.close()

    def _assemble(self, window: Window, client: Client, recipe: Recipe, pending: NDArray[np.int64]) -> bool:
        """Find workers that agree, and prepare them; False if the study was stopped meanwhile."""
        study_id = self._lease.study_id
        digest = self._store.find(study_id).digest
        first = partial(window.assemble, self._store.cube_path(study_id), digest, code_hash())
        facts = first(recipe.begun, None, "", lambda: self._look_on(window))
        if facts is None:
            return False
        recipe.agree({"the workers": facts})
        usable = [worker.address for worker in window.workers.usable]
        with asking_the_cluster(client):
            compile_at_workers(
                client, scenes(self._plan.study), self._account.compiling, self._stopping, usable
            )
        canary, truth = recipe.canary(pending)
        return first(facts["identity"], canary, truth, lambda: self._look_on(window)) is not None

    def _look_on(self, window: Window) -> bool:
        """Publish the reason for waiting; False if the study must stop."""
        self._account.tell_of_workers(window.stranded, window.gives_up_at)
        return not self._stopping()
