"""Reports on a running study: its phase, its progress, and its workers."""

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
"""Shortest time between two reports of progress [s]."""


class Reporter:
    """Reports the events of a run to the catalogue, to the log and to a callback function.

    Parameters
    ----------
    store : Store
        Store that holds the study.
    lease : Lease
        This run's claim on the study.
    on_progress : callable
        Called with the present `Progress` at each report.
    """

    def __init__(self, store: Store, lease: Lease, on_progress: Callable[[Progress], None]) -> None:
        self.left_out = ""
        """Excluded workers and the reasons for excluding them; empty if no worker is excluded."""
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
        """Start a new measurement of the computing speed.

        Parameters
        ----------
        record : Record
            The study in its present state.
        work_left : float
            Expected kernel time of the remaining blocks [s].
        """
        self._meter = Meter(_progress(record), work_left)

    def watch(self, workers: Workers) -> None:
        """Include the state of the given workers in later reports."""
        self._workers = workers

    def enter(
        self, phase: str | None, done: int | None = None, total: int | None = None, message: str | None = None
    ) -> None:
        """Write the phase of the study to the catalogue, and report the progress."""
        if (phase, done, total, message) != self._entered:
            self._entered = phase, done, total, message
            self._phase = phase, done, total
            self._store.set_phase(
                self._lease.study_id, phase, done, total, owner=self._lease.owner, message=message
            )
        self.report(at_once=True)

    def wait(self, what: str, gives_up_at: float) -> None:
        """Report that the study waits for a resource.

        Nothing is written to the catalogue, because the catalogue may be the missing resource.

        Parameters
        ----------
        what : str
            Sentence that describes the missing resource.
        gives_up_at : float
            Time of the monotonic clock at which the wait ends [s].
        """
        self._phase = "waiting", None, None
        self._waits_for, self._gives_up_at = what, gives_up_at
        self.report(at_once=True)

    def compiling(self, done: int, total: int) -> None:
        """Report how many of the kernels have been compiled."""
        self.enter("compiling", done, total)

    def begin_blocks(self, record: Record, work_left: float) -> None:
        """Report that the preparation has ended and that blocks are computed from now on."""
        self.enter(None, message=self.left_out)
        self.measure(record, work_left)

    def tell_of_workers(self, stranded: str | None, gives_up_at: float = math.inf) -> None:
        """Write events about workers to the log and the catalogue. If workers are missing, report that the study waits.

        Parameters
        ----------
        stranded : str, optional
            Reason why no worker can compute; None if a worker can compute.
        gives_up_at : float
            Time of the monotonic clock at which the wait for workers ends [s].
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
        """Report the remaining events about workers. Errors of the store are ignored, so that the run can end."""
        with suppress(StoreFault):
            self.tell_of_workers(stranded)

    def count(self, outcome: BlockOutcome, work: float) -> None:
        """Add a completed block to the progress.

        Parameters
        ----------
        outcome : BlockOutcome
            Result of the block.
        work : float
            Expected kernel time of the block [s].
        """
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
        """Report the progress if `REPORT_SECONDS` have passed since the last report, or if `at_once` is true."""
        now = time.monotonic()
        if self._meter is None or not (at_once or now - self._reported >= REPORT_SECONDS):
            return
        self._reported = now
        progress = self._meter.progress()
        phase, done, total = self._phase
        if phase is not None:
            progress = replace(progress, phase=phase, phase_done=done, phase_total=total)
        if phase in ("starting", "waiting"):
            # it is unknown when the study will continue, so the time left is unknown too
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
