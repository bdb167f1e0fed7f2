"""Progress of a study, its speed, and its expected end."""

import math
import time
from collections import deque
from dataclasses import dataclass

WINDOW_SECONDS = 60.0
"""Time over which the speed is measured. Earlier blocks do not count, because the longest blocks come first."""


@dataclass(frozen=True)
class Progress:
    """A study at one moment.

    Parameters
    ----------
    points_total, points_done, points_failed : int
        Design points; failed ones count as done too.
    blocks_total, blocks_done : int
        Blocks of the plan.
    points_per_second : float
        Recent speed of this run; 0 before its first block.
    seconds_left : float or None
        Expected wall time to the end [s]; None while the speed is unknown, 0 at the end.
    phase : str
        As in `Record`.
    phase_done, phase_total : int, optional
        Number of compiled kernels, and their total, while the phase is compiling.
    workers : tuple of (str, int)
        Number of the cluster's workers in each standing for this study.
    blocks_in_flight, retries : int
        Blocks at workers, and blocks that this run repeated.
    waits_for : str
        Resource that is missing while the phase is waiting; empty if it is a worker.
    gives_up_in : float
        Remaining wait for this resource [s].
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
    """Counts finished blocks and turns them into progress.

    The remaining time follows from the remaining work instead of the points, because blocks differ in cost by orders of
    magnitude and the longest come first.

    Parameters
    ----------
    start : Progress
        The study at the start of this run.
    work_left : float
        Expected kernel seconds of the remaining blocks; only its ratio to the blocks' own work matters.
    """

    def __init__(self, start: Progress, work_left: float) -> None:
        self._start = start
        self._points = start.points_done
        self._failed = start.points_failed
        self._blocks = start.blocks_done
        self._work_left = work_left
        self._samples: deque[tuple[float, int, float]] = deque()
        self._sample()

    def add(self, points: int, failed: int, work: float) -> None:
        """Count one finished block.

        Parameters
        ----------
        points, failed : int
            Its points, and how many of them failed.
        work : float
            Its expected kernel seconds, as counted in `work_left`.
        """
        self._points += points
        self._failed += failed
        self._blocks += 1
        self._work_left = max(0.0, self._work_left - work)
        self._sample()

    def progress(self) -> Progress:
        """Give the present counts and speed."""
        then, points, work = self._samples[0]
        elapsed = time.monotonic() - then
        speed = (self._points - points) / elapsed if elapsed > 0.0 else 0.0
        done = work - self._work_left
        left: float | None = self._work_left / done * elapsed if done > 0.0 else None
        if self._blocks == self._start.blocks_total:
            left = 0.0
        return Progress(
            self._start.points_total,
            self._points,
            self._failed,
            self._start.blocks_total,
            self._blocks,
            speed,
            left,
        )

    def _sample(self) -> None:
        now = time.monotonic()
        self._samples.append((now, self._points, self._work_left))
        while len(self._samples) > 2 and self._samples[1][0] < now - WINDOW_SECONDS:
            self._samples.popleft()
