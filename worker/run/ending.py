"""The state in which a run leaves its study, and its message."""

from collections.abc import Sequence

from damperlab.studies.store.care.sweep import sweep
from damperlab.studies.store.store import Store
from damperlab.worker.run.lease import Lease


class Ending:
    """Ends a study.

    Parameters
    ----------
    store : Store
        Where it is.
    lease : Lease
        The claim on it; a runner that has lost its claim writes nothing more.
    """

    def __init__(self, store: Store, lease: Lease) -> None:
        self._store = store
        self._lease = lease

    def settle(self, stopped_as: str, stopped_by: str | None, failures: Sequence[str], left_out: str) -> None:
        """Set the state of the study from its blocks.

        Parameters
        ----------
        stopped_as : str
            State of an incomplete study.
        stopped_by : str, optional
            Reason why it is incomplete.
        failures : sequence of str
            Failed blocks, with reasons.
        left_out : str
            The excluded workers, and the reasons.
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
        # Only blocks that failed as a whole take no kernel time; numerical failures of points are results.
        given_up = record.points_failed == record.points_total and record.kernel_seconds == 0.0
        state = "failed" if given_up else "done"
        # a cancelled study stays cancelled, although its last block was running
        self._store.set_state(study_id, state, message, only_from=("running",), owner=self._lease.owner)

    def put_down(self, state: str, message: str | None) -> None:
        """End an incomplete study, unless another process has decided its state."""
        if not self._lease.lost.is_set():
            self._store.set_state(
                self._lease.study_id, state, message, only_from=("running",), owner=self._lease.owner
            )

    def left(self) -> str:
        """Say what remains, and how to continue."""
        record = self._store.find(self._lease.study_id)
        pending = record.blocks_total - record.blocks_done
        return f"{record.blocks_done} of {record.blocks_total} blocks are kept; a continued run computes the other {pending}"
