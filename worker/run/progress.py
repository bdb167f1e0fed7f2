"""Measures the computing speed of a running study, estimates the remaining time, and reports both."""

import logging
import math
import time
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from damperlab.studies.store.faults import StoreFault
from damperlab.studies.store.record import BlockOutcome, Record

if TYPE_CHECKING:
    from damperlab.worker.dispatch.window import Window
    from damperlab.worker.run.lease import Lease

_log = logging.getLogger(__name__)

WINDOW_SECONDS = 60.0
"""Period over which the computing speed is averaged [s]. Early blocks take longer than late blocks."""
EVEN = 0.25
"""Share of the expected kernel time that is spread evenly over the blocks for the remaining time.

The blocks that are expected to take longest are computed first, and take less than expected. So without this share the
remaining time is too low in the first third of a study: by half in studies of 90 blocks, with it by a quarter.
"""
REPORT_SECONDS = 0.5
"""Shortest time between two reports of progress [s]."""


@dataclass(frozen=True)
class Progress:
    """Progress of a study at one moment.

    Parameters
    ----------
    points_total, points_done, points_failed : int
        Numbers of all, completed and failed design points. Completed points include failed points.
    blocks_total, blocks_done : int
        Numbers of all and completed blocks.
    points_per_second : float
        Recent computing speed of this run; 0 before the first block has ended.
    seconds_left : float or None
        Expected wall time to the end of the study [s]. None while the speed is unknown, 0 at the end.
    phase : str
        Phase of the study, see `Record`.
    phase_done, phase_total : int, optional
        Numbers of compiled and of all kernels while the phase is "compiling"; None in other phases.
    workers : tuple of (str, int)
        Pairs of a standing, such as "usable", and the number of workers with this standing.
    blocks_in_flight, retries : int
        Number of blocks sent to workers, and number of repeated attempts in this run.
    waits_for : str
        Missing resource while the phase is "waiting"; empty if workers are missing.
    gives_up_in : float
        Time until the wait for the missing resource ends [s].
    """

    points_total: int
    points_done: int
    points_failed: int
    blocks_total: int
    blocks_done: int
    points_per_second: float
    seconds_left: float | None
    phase: str = "running"
    phase_done: int | None = None
    phase_total: int | None = None
    workers: tuple[tuple[str, int], ...] = ()
    blocks_in_flight: int = 0
    retries: int = 0
    waits_for: str = ""
    gives_up_in: float = math.inf


class Meter:
    """Counts finished blocks, and estimates the speed and the remaining time.

    The estimate uses expected kernel times, because the computing times of points differ by orders of magnitude.

    Parameters
    ----------
    record : Record
        The study at the start of the measurement.
    work_left : float
        Expected kernel time of the remaining blocks [s].
    """

    def __init__(self, record: Record, work_left: float) -> None:
        self._record = record
        self._points = record.points_done
        self._failed = record.points_failed
        self._blocks = record.blocks_done
        self._work_left = work_left
        self._mean = work_left / max(1, record.blocks_total - record.blocks_done)
        self._samples: deque[tuple[float, int, float]] = deque()
        self._sample()

    def add(self, outcome: BlockOutcome, work: float) -> None:
        """Count one finished block, whose expected kernel time `work` [s] was part of `work_left`."""
        self._points += outcome.points
        self._failed += outcome.failed
        self._blocks += 1
        self._work_left = max(0.0, self._work_left - work - EVEN * (self._mean - work))
        self._sample()

    def progress(self) -> Progress:
        """Return the present counts, the speed and the remaining time."""
        then, points, work = self._samples[0]
        elapsed = time.monotonic() - then
        speed = (self._points - points) / elapsed if elapsed > 0.0 else 0.0
        done = work - self._work_left
        left: float | None = self._work_left / done * elapsed if done > 0.0 else None
        if self._blocks == self._record.blocks_total:
            left = 0.0
        return Progress(
            self._record.points_total,
            self._points,
            self._failed,
            self._record.blocks_total,
            self._blocks,
            speed,
            left,
        )

    def _sample(self) -> None:
        now = time.monotonic()
        self._samples.append((now, self._points, self._work_left))
        while len(self._samples) > 2 and self._samples[1][0] < now - WINDOW_SECONDS:
            self._samples.popleft()


class Reporter:
    """Reports the events of a run to the catalogue, to the log and to a callback function.

    Parameters
    ----------
    lease : Lease
        This run's claim on the study.
    on_progress : callable
        Called with the present `Progress` at each report.
    """

    def __init__(self, lease: "Lease", on_progress: Callable[[Progress], None]) -> None:
        self.left_out = ""
        """Excluded workers and the reasons for excluding them; empty if no worker is excluded."""
        self._lease = lease
        self._on_progress = on_progress
        self._phase: tuple[str | None, int | None, int | None] = None, None, None
        self._entered: tuple[str | None, int | None, int | None, str | None] = None, None, None, None
        self._meter: Meter | None = None
        self._window: Window | None = None
        self._earlier_retries = 0
        self._reported = 0.0
        self._waits_for, self._gives_up_at = "", math.inf

    def measure(self, record: Record, work_left: float) -> None:
        """Measure the speed anew. The remaining blocks are expected to take `work_left` kernel seconds."""
        self._meter = Meter(record, work_left)

    def watch(self, window: "Window | None") -> None:
        """Include the state of the cluster's workers in later reports.

        `window` is None if this process computes the blocks.
        """
        if self._window is not None:
            self._earlier_retries += self._window.workers.retries
        self._window = window

    def enter(
        self, phase: str | None, done: int | None = None, total: int | None = None, message: str | None = None
    ) -> None:
        """Write the phase of the study to the catalogue, and report the progress."""
        if (phase, done, total, message) != self._entered:
            self._entered = phase, done, total, message
            self._phase = phase, done, total
            self._lease.store.set_phase(
                self._lease.study_id, phase, done, total, owner=self._lease.owner, message=message
            )
        self.report(at_once=True)

    def wait(self, what: str, gives_up_at: float) -> None:
        """Report that the study waits for a resource, until the time `gives_up_at` of the monotonic clock [s].

        `what` is a sentence that describes the resource. Nothing is written to the catalogue, because the catalogue may
        be the missing resource.
        """
        self._phase = "waiting", None, None
        self._waits_for, self._gives_up_at = what, gives_up_at
        self.report(at_once=True)

    def begin_blocks(self, record: Record, work_left: float) -> None:
        """Report that the preparation has ended and that blocks are computed from now on."""
        self.enter(None, message=self.left_out)
        self.measure(record, work_left)

    def report_workers(self) -> None:
        """Write events about workers to the log and the catalogue. If workers are missing, report that the study waits.

        Nothing happens if this process computes the blocks.
        """
        if self._window is None:
            return
        workers, stranded = self._window.workers, self._window.stranded
        self._waits_for, self._gives_up_at = "", self._window.gives_up_at
        study_id = self._lease.study_id
        incidents, workers.incidents = workers.incidents, []
        news, workers.news = workers.news, []
        for sentence in (*incidents, *news):
            _log.warning("study %s: %s", study_id, sentence)
        for sentence in news:
            self._lease.store.note(study_id, sentence)
        out = workers.reasons()
        if stranded is not None:
            self.enter("waiting", message=stranded)
        elif self._phase[0] == "waiting" or (out != self.left_out and self._phase[0] is None):
            self.enter(None, message=out)
        self.left_out = out

    def close(self) -> None:
        """Report the remaining events about workers. Errors of the store are ignored, so that the run can end."""
        with suppress(StoreFault):
            self.report_workers()

    def count(self, outcome: BlockOutcome, work: float) -> None:
        """Add a completed block to the progress. Its expected kernel time is `work` [s]."""
        assert self._meter is not None
        self._meter.add(outcome, work)
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
        phase, done, total = self._phase
        known: dict[str, Any] = {"retries": self._earlier_retries}
        if phase is not None:
            known |= {"phase": phase, "phase_done": done, "phase_total": total}
        if phase in ("starting", "waiting"):
            # it is unknown when the study will continue, so the time left is unknown too
            known["seconds_left"] = None
        if phase == "waiting":
            known |= {"waits_for": self._waits_for, "gives_up_in": max(0.0, self._gives_up_at - now)}
        if self._window is not None:
            workers = self._window.workers
            known |= {"workers": workers.standings(), "blocks_in_flight": workers.in_flight}
            known["retries"] += workers.retries
        self._on_progress(replace(self._meter.progress(), **known))
