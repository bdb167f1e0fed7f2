"""Progress of a running study, with the computing speed and the expected remaining time."""

import math
import time
from collections import deque
from dataclasses import dataclass

WINDOW_SECONDS = 60.0
"""Period over which the computing speed is averaged [s]. Early blocks take longer than late blocks."""


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
    start : Progress
        Progress at the start of this run.
    work_left : float
        Expected kernel time of the remaining blocks [s].
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
            Number of points of the block, and number of failed points.
        work : float
            Expected kernel time of the block [s], which was part of `work_left`.
        """
        self._points += points
        self._failed += failed
        self._blocks += 1
        self._work_left = max(0.0, self._work_left - work)
        self._sample()

    def progress(self) -> Progress:
        """Return the present counts, the speed and the remaining time."""
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
