"""Sets the state and the message of a study at the end of a run."""

from collections.abc import Sequence

from damperlab.studies.store.care.sweep import sweep
from damperlab.studies.store.store import Store
from damperlab.worker.run.lease import Lease


class Ending:
    """Writes the final state of a study.

    Parameters
    ----------
    store : Store
        Store that holds the study.
    lease : Lease
        This run's claim on the study. If the claim is lost, nothing is written.
    """

    def __init__(self, store: Store, lease: Lease) -> None:
        self._store = store
        self._lease = lease

    def settle(self, stopped_as: str, stopped_by: str | None, failures: Sequence[str], left_out: str) -> None:
        """Set the final state of the study: done or failed if all blocks have ended, otherwise `stopped_as`.

        Parameters
        ----------
        stopped_as : str
            State to set if blocks are still pending.
        stopped_by : str, optional
            Message to set if blocks are still pending.
        failures : sequence of str
            Failed blocks, each with the reason.
        left_out : str
            Excluded workers and the reasons for excluding them; empty if no worker was excluded.
        """
        if self._lease.lost.is_set():
            return
        study_id = self._lease.study_id
        record = self._store.find(study_id)
        sweep(self._store, study_id)
        if record.blocks_done < record.blocks_total:
            self.put_down(stopped_as, stopped_by)
            return
        message = f"computed without workers that were left out: {left_out}" if left_out else None
        if failures:
            message = f"{len(failures)} of {record.blocks_total} blocks failed; the first: {failures[0]}"
        elif message is None and record.message and not record.points_failed:
            message = ""  # the message of an earlier, interrupted run no longer applies
        # numerical failures are results and took kernel time; blocks that failed as a whole took no kernel time
        given_up = record.points_failed == record.points_total and record.kernel_seconds == 0.0
        state = "failed" if given_up else "done"
        # a study that was cancelled during its last block stays cancelled
        self._store.set_state(study_id, state, message, only_from=("running",), owner=self._lease.owner)

    def put_down(self, state: str, message: str | None) -> None:
        """Set the state of an incomplete study. A state that another process has set is kept."""
        if not self._lease.lost.is_set():
            self._store.set_state(
                self._lease.study_id, state, message, only_from=("running",), owner=self._lease.owner
            )

    def left(self) -> str:
        """Return a message that counts the stored and the remaining blocks."""
        record = self._store.find(self._lease.study_id)
        pending = record.blocks_total - record.blocks_done
        return f"{record.blocks_done} of {record.blocks_total} blocks are kept; a continued run computes the other {pending}"
