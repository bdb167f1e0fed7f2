"""Marks the ended blocks of a run as done, writes fill values for failed blocks, and sets the final state."""

import uuid
from collections.abc import Iterable
from typing import TYPE_CHECKING

from damperlab.studies.store.care.sweep import sweep
from damperlab.studies.store.cube.block_file import write_region
from damperlab.studies.store.record import BlockOutcome
from damperlab.worker.outcomes import Failure, unusable_data
from damperlab.worker.worker_process.tasks import failed_values

if TYPE_CHECKING:
    from damperlab.worker.run.runner import Run


class Results:
    """Records completed blocks, and the end of the run. Nothing is written after the claim is lost.

    Parameters
    ----------
    run : Run
        The run, whose plan must be set before `keep` is called.
    """

    def __init__(self, run: "Run") -> None:
        self.spent_seconds = 0.0
        """Kernel time of the blocks that this run has completed [s]."""
        self.marked = 0
        """Number of blocks that this run has marked as done."""
        self._failures: list[str] = []
        self._run = run
        self._lease = run.lease
        self._store = run.lease.store

    def keep(self, ended: Iterable[BlockOutcome | Failure]) -> None:
        """Mark ended blocks as done; raise `Interrupted` if the values of a failed block cannot be written."""
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
        plan = self._run.plan
        block = plan.block(end.index)
        generation, told = uuid.uuid4().hex[:12], {"message": end.message}
        try:
            outcome = write_region(
                self._run.cube_path, block, failed_values(plan.study, block), generation, told
            )
        except OSError as error:
            raise unusable_data(error, "written") from error
        self._failures.append(f"block {end.index}: {end.message}")
        return outcome

    def _mark(self, outcomes: list[BlockOutcome]) -> None:
        if not outcomes or self._lease.lost.is_set():
            return
        # one transaction for all blocks is faster than one transaction for each block
        if not self._store.mark(self._lease.study_id, *outcomes, owner=self._lease.owner):
            self._lease.lost.set()
            return
        self.marked += len(outcomes)
        for outcome in outcomes:
            self._run.reporter.count(outcome, float(self._run.plan.block_seconds[outcome.index]))

    def end(self, stopped_as: str, stopped_by: str | None) -> None:
        """Set the final state of the study: done or failed if all blocks have ended.

        If blocks are still pending, the state becomes `stopped_as`, with the message `stopped_by`. If `stopped_by` is
        None, a message that says why the run was waiting is removed.
        """
        if self._lease.lost.is_set():
            return
        study_id = self._lease.study_id
        record = self._store.find(study_id)
        sweep(self._store, study_id)
        if record.blocks_done < record.blocks_total:
            if stopped_by is None and record.phase == "waiting":
                stopped_by = ""
            self.end_as(stopped_as, stopped_by)
            return
        left_out, failures = self._run.reporter.left_out, self._failures
        message = f"computed, but these workers were left out: {left_out}" if left_out else None
        if failures:
            message = f"{len(failures)} of {record.blocks_total} blocks failed; the first: {failures[0]}"
        elif message is None and record.message and not record.points_failed:
            message = ""  # the message of an earlier, interrupted run no longer applies
        # points that failed numerically are results and took kernel time; a block that failed as a whole took none
        given_up = record.points_failed == record.points_total and record.kernel_seconds == 0.0
        state = "failed" if given_up else "done"
        # a study that was cancelled during its last block stays cancelled
        self.end_as(state, message)

    def end_as(self, state: str, message: str | None) -> None:
        """Set the state of the study at the end of the run. A state that another process has set is kept."""
        if not self._lease.lost.is_set():
            self._store.set_state(
                self._lease.study_id, state, message, only_from=("running",), owner=self._lease.owner
            )

    def left(self) -> str:
        """Return a message that counts the stored and the remaining blocks."""
        record = self._store.find(self._lease.study_id)
        pending = record.blocks_total - record.blocks_done
        return f"{record.blocks_done} of {record.blocks_total} blocks are kept; a continued run computes the other {pending}"
