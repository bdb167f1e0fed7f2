"""Reports of a running study: its phase, its progress, and its workers."""

import logging
import math
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace

from damperlab.studies.store.faults import StoreFault
from damperlab.studies.store.record import BlockOutcome, Record
from damperlab.studies.store.store import Store
from damperlab.worker.dispatch.workers import Workers
from damperlab.worker.run.lease import Lease
from damperlab.worker.run.progress import Meter, Progress

_log = logging.getLogger(__name__)

REPORT_SECONDS = 0.5
"""Shortest time between two reports of progress."""


class Account:
    """Reports to the catalogue, the log and listeners.

    Parameters
    ----------
    store : Store
        The store of the study.
    lease : Lease
        The claim on it.
    on_progress : callable
        Takes the progress.
    """

    def __init__(self, store: Store, lease: Lease, on_progress: Callable[[Progress], None]) -> None:
        self.left_out = ""
        """The excluded workers, and the reasons."""
        self._store = store
        self._lease = lease
        self._on_progress = on_progress
        self._phase: tuple[str | None, int | None, int | None] = None, None, None
        self._entered: tuple[str | None, int | None, int | None, str | None] = None, None, None, None
        self._meter: Meter | None = None
        self._workers: Workers | None = None
        self._reported = 0.0
        self._waits_for, self._gives_up_at = "", math.inf

    def measure(self, record: Record, work_left: float) -> None:
        """Start to measure the pace; earlier time no longer counts.

        Parameters
        ----------
        record : Record
            The study in its present state.
        work_left : float
            Expected kernel seconds of the remaining blocks.
        """
        self._meter = Meter(_progress(record), work_left)

    def watch(self, workers: Workers) -> None:
        """Report the state of these workers from now on."""
        self._workers = workers

    def enter(
        self, phase: str | None, done: int | None = None, total: int | None = None, message: str | None = None
    ) -> None:
        """Publish the phase of the study."""
        if (phase, done, total, message) != self._entered:
            self._entered = phase, done, total, message
            self._phase = phase, done, total
            self._store.set_phase(
                self._lease.study_id, phase, done, total, owner=self._lease.owner, message=message
            )
        self.report(at_once=True)

    def wait(self, what: str, gives_up_at: float) -> None:
        """Report that the study waits. This is not written to the catalogue, which may be what it waits for.

        Parameters
        ----------
        what : str
            The missing resource, in a sentence.
        gives_up_at : float
            End of the wait, by the monotonic clock [s].
        """
        self._phase = "waiting", None, None
        self._waits_for, self._gives_up_at = what, gives_up_at
        self.report(at_once=True)

    def compiling(self, done: int, total: int) -> None:
        """Publish how many kernels are compiled."""
        self.enter("compiling", done, total)

    def begin_blocks(self, record: Record, work_left: float) -> None:
        """Change from preparation to blocks; a missing resource is available again."""
        self.enter(None, message=self.left_out)
        self.measure(record, work_left)

    def tell_of_workers(self, stranded: str | None, gives_up_at: float = math.inf) -> None:
        """Record events about workers, and the reason for waiting.

        Parameters
        ----------
        stranded : str, optional
            Reason why nothing is computed, if workers are missing.
        gives_up_at : float
            End of the wait for workers, by the monotonic clock [s].
        """
        self._waits_for, self._gives_up_at = "", gives_up_at
        assert self._workers is not None
        study_id = self._lease.study_id
        incidents, self._workers.incidents = self._workers.incidents, []
        for sentence in incidents:
            _log.warning("study %s: %s", study_id, sentence)
        for sentence in self._workers.take_news():
            _log.warning("study %s: %s", study_id, sentence)
            self._store.note(study_id, sentence)
        out = self._workers.reasons()
        if stranded is not None:
            self.enter("waiting", message=stranded)
        elif self._phase[0] == "waiting" or (out != self.left_out and self._phase[0] is None):
            self.enter(None, message=out)
        self.left_out = out

    def close(self, stranded: str | None) -> None:
        """Report the remaining events about workers; a failure to write them must not hide the end of the run."""
        with suppress(StoreFault):
            self.tell_of_workers(stranded)

    def count(self, outcome: BlockOutcome, work: float) -> None:
        """Count a completed block, by its expected kernel seconds."""
        assert self._meter is not None
        self._meter.add(outcome.points, outcome.failed, work)
        _log.debug(
            "study %s: block %d is done: %d points, %.3g s",
            self._lease.study_id,
            outcome.index,
            outcome.points,
            outcome.seconds,
        )

    def report(self, at_once: bool = False) -> None:
        """Report progress if the last report is long enough ago."""
        now = time.monotonic()
        if self._meter is None or not (at_once or now - self._reported >= REPORT_SECONDS):
            return
        self._reported = now
        progress = self._meter.progress()
        phase, done, total = self._phase
        if phase is not None:
            progress = replace(progress, phase=phase, phase_done=done, phase_total=total)
        if phase in ("starting", "waiting"):
            # the remaining work does not tell when the study continues
            progress = replace(progress, seconds_left=None)
        if phase == "waiting":
            left = max(0.0, self._gives_up_at - now)
            progress = replace(progress, waits_for=self._waits_for, gives_up_in=left)
        if self._workers is not None:
            workers = self._workers
            progress = replace(
                progress,
                workers=workers.standings(),
                blocks_in_flight=workers.in_flight,
                retries=workers.retries,
            )
        self._on_progress(progress)


def _progress(record: Record) -> Progress:
    return Progress(
        record.points_total,
        record.points_done,
        record.points_failed,
        record.blocks_total,
        record.blocks_done,
        points_per_second=0.0,
        seconds_left=None,
    )
