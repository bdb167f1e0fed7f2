"""Progress of a study on standard error: bars on a terminal, occasional lines elsewhere."""

import time
from types import TracebackType
from typing import Protocol

from rich.progress import (
    BarColumn,
    Progress,
    SpinnerColumn,
    TextColumn,
)

from damperlab.service.cli.output import NOTES, duration, note

LINE_EVERY_SECONDS = 5.0
"""Interval between lines without a terminal, so that a log stays short but shows progress."""

BAR_WIDTH, NAME_WIDTH = 12, 16
"""Widths of bar and name with which everything fits on a line of 80 characters."""


def preparation(phase: str, done: int | None, total: int | None) -> str | None:
    """Describe a phase before the first block; None for other phases."""
    if phase == "starting":
        return "starting workers"
    if phase == "compiling":
        return f"compiling kernels, {done} of {total} done"
    if phase == "waiting":
        return "waiting for workers"
    return None


class Shown(Protocol):
    """A display for the progress of a study."""

    def update(
        self,
        done: int,
        failed: int,
        rate: float | None,
        seconds_left: float | None,
        preparation: str | None = None,
    ) -> None:
        """Take the present numbers; None means unknown."""


class StudyProgress:
    """Shows points done, points failed, the rate and the time left of one study.

    Parameters
    ----------
    name : str
        Name of the study.
    points : int
        Points of the study.
    """

    def __init__(self, name: str, points: int) -> None:
        self._name = name
        self._points = points
        self._last_line = time.monotonic()
        self._bars: Progress | None = None
        if NOTES.is_terminal:
            self._bars = Progress(
                SpinnerColumn(),
                TextColumn("{task.description}", markup=False),
                BarColumn(bar_width=BAR_WIDTH),
                TextColumn(
                    "{task.completed:.0f}/{task.total:.0f} points, {task.fields[figures]}", markup=False
                ),
                console=NOTES,
            )
            self._task = self._bars.add_task(name[:NAME_WIDTH], total=points, figures="starting workers")

    def __enter__(self) -> "StudyProgress":
        """Begin to draw."""
        if self._bars is not None:
            self._bars.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Leave the last state on the terminal."""
        if self._bars is not None:
            self._bars.stop()

    def update(
        self,
        done: int,
        failed: int,
        rate: float | None,
        seconds_left: float | None,
        preparation: str | None = None,
    ) -> None:
        """Take the present numbers of the study; None means unknown.

        Parameters
        ----------
        done, failed : int
            Points.
        rate : float, optional
            Points per second.
        seconds_left : float, optional
            Expected time to the end [s].
        preparation : str, optional
            Activity before the first block (`preparation`).
        """
        phrases = [f"{failed} failed"]
        if preparation is not None:
            phrases = [preparation]
        elif rate:
            phrases.append(f"{rate:.3g} points/s")
        elif done:
            phrases.append("waiting for the next block")
        else:
            phrases.append("in the first block")
        if seconds_left is not None:
            phrases.append(f"{duration(seconds_left)} left")
        figures = ", ".join(phrases)
        now = time.monotonic()
        if self._bars is not None:
            self._bars.update(self._task, completed=done, figures=figures)
        elif now - self._last_line >= LINE_EVERY_SECONDS:
            self._last_line = now
            note(f"{self._name}: {done} of {self._points} points, {figures}")
