"""How far a study is, how fast it goes, and when it will be done."""

import math
import time
from collections import deque
from dataclasses import dataclass

WINDOW_SECONDS = 60.0
"""Speed is that of the last minute: the longest blocks come first."""


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
        Of this run, lately; 0 before its first block.
    seconds_left : float or None
        Expected, or None before there is a speed to go by; 0 at the end.
    phase : str
        As in `Record`: starting or compiling before the blocks.
    phase_done, phase_total : int, optional
        Kernels compiled, of how many, while the phase is compiling.
    workers : tuple of (str, int)
        How many workers of the cluster have which standing for this study.
    blocks_in_flight, retries : int
        Blocks at workers, and those of this run that were begun again.
    waits_for : str
        What was lost and is waited for, while the phase is waiting; empty where that is a worker.
    gives_up_in : float
        How long it is still waited for [s].
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

    The time left follows from the work left, not from the points left: blocks differ in cost by orders of
    magnitude and the longest come first.

    Parameters
    ----------
    start : Progress
        The study as this run finds it.
    work_left : float
        Expected kernel seconds of the blocks that are left; only its ratio to the blocks' own work matters.
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
            Its expected kernel seconds, as they were counted in `work_left`.
        """
        self._points += points
        self._failed += failed
        self._blocks += 1
        self._work_left = max(0.0, self._work_left - work)
        self._sample()

    def progress(self) -> Progress:
        """Counts and speed as they are now."""
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
