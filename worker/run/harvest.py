"""Records the results of a run: completed blocks are marked as done, and failed blocks are stored as failed points."""

import uuid
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.plan import Plan
from damperlab.studies.store.cube.cube import write_region
from damperlab.studies.store.files.shelf import ShelfAway
from damperlab.studies.store.record import BlockOutcome
from damperlab.studies.store.store import Store
from damperlab.worker.outcomes import Failure, Interrupted, Outage, is_full
from damperlab.worker.run.account import Account
from damperlab.worker.run.lease import Lease
from damperlab.worker.worker_process.tasks import failed_values


class Harvest:
    """Records completed blocks.

    Parameters
    ----------
    store : Store
        Store that holds the study.
    lease : Lease
        This run's claim on the study.
    plan : Plan
        Division of the study into blocks.
    expected : array of float
        Expected kernel time of each block [s], from which the progress is computed.
    account : Account
        Object that counts each block that was marked as done.
    """

    def __init__(
        self, store: Store, lease: Lease, plan: Plan, expected: NDArray[np.float64], account: Account
    ) -> None:
        self.spent_seconds = 0.0
        """Kernel time of the blocks that this run has completed [s]."""
        self.marked = 0
        """Number of blocks that this run has marked as done."""
        self.failures: list[str] = []
        """Failed blocks, each with the reason."""
        self._store = store
        self._lease = lease
        self._plan = plan
        self._expected = expected
        self._account = account
        self._cube_path = store.cube_path(lease.study_id)

    def keep(self, ended: Iterable[BlockOutcome | Failure]) -> None:
        """Mark ended blocks as done. Nothing is marked after the claim is lost.

        Parameters
        ----------
        ended : iterable of BlockOutcome or Failure
            Results of the blocks.

        Raises
        ------
        Interrupted
            If the values of a failed block cannot be written.
        """
        outcomes: list[BlockOutcome] = []
        try:
            for end in ended:
                if self._lease.lost.is_set():
                    return
                outcomes.append(self._outcome(end))
        finally:
            # blocks already on the disk are marked even if the cluster is lost meanwhile, so that no run repeats them
            self._mark(outcomes)

    def _outcome(self, end: BlockOutcome | Failure) -> BlockOutcome:
        """Return the outcome of an ended block. The fill values of a failed block are written first."""
        if isinstance(end, BlockOutcome):
            self.spent_seconds += end.kernel_seconds
            return end
        try:
            return self._give_up(end)
        except OSError as error:
            kind = Outage if isinstance(error, ShelfAway) or is_full(error) else Interrupted
            raise kind(f"the study's data cannot be written ({error})") from error

    def _mark(self, outcomes: list[BlockOutcome]) -> None:
        if not outcomes or self._lease.lost.is_set():
            return
        # one transaction for all blocks is faster than one transaction for each block
        if not self._store.mark(self._lease.study_id, *outcomes, owner=self._lease.owner):
            self._lease.lost.set()
            return
        self.marked += len(outcomes)
        for outcome in outcomes:
            self._account.count(outcome, float(self._expected[outcome.index]))

    def _give_up(self, failure: Failure) -> BlockOutcome:
        block = self._plan.block(failure.index)
        values = failed_values(self._plan.study, block)
        told = {"message": failure.message}
        outcome = write_region(self._cube_path, block, values, uuid.uuid4().hex[:12], told)
        self.failures.append(f"block {failure.index}: {failure.message}")
        return outcome
