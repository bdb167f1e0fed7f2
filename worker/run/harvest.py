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
        Where the study is.
    lease : Lease
        The claim on it.
    plan : Plan
        Its blocks.
    expected : array of float
        Their expected kernel seconds at the beginning; progress is the share of completed seconds.
    account : Account
        Counts each block that was marked as done.
    """

    def __init__(
        self, store: Store, lease: Lease, plan: Plan, expected: NDArray[np.float64], account: Account
    ) -> None:
        self.spent_seconds = 0.0
        """Kernel seconds of the blocks that this run has completed."""
        self.marked = 0
        """Number of blocks that this run has marked as done."""
        self.failures: list[str] = []
        """Failed blocks, with reasons."""
        self._store = store
        self._lease = lease
        self._plan = plan
        self._expected = expected
        self._account = account
        self._cube_path = store.cube_path(lease.study_id)

    def keep(self, ended: Iterable[BlockOutcome | Failure]) -> None:
        """Mark blocks as done when they end.

        Raises
        ------
        Interrupted
            A failed block cannot be written.
        """
        outcomes: list[BlockOutcome] = []
        try:
            for end in ended:
                if self._lease.lost.is_set():
                    return
                outcomes.append(self._outcome(end))
        finally:
            # this is done even if the cluster is lost half-way, so that blocks on the disk are not computed again
            self._mark(outcomes)

    def _outcome(self, end: BlockOutcome | Failure) -> BlockOutcome:
        """Give the outcome to mark; the values of a failed block are written first."""
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
        # one commit marks all blocks that have ended meanwhile; the more arrive, the less each costs
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
