"""Progress of a study on standard error: a bar on a terminal, occasional lines elsewhere."""

import time
from types import TracebackType
from typing import TYPE_CHECKING, Protocol

from damperlab.service.cli.output import duration, note, notes

if TYPE_CHECKING:
    from rich.progress import Progress as Bars

LINE_EVERY_SECONDS = 5.0
"""Time between lines of progress if there is no terminal [s], so that logs stay short."""

BAR_WIDTH, NAME_WIDTH = 12, 16
"""Widths of the bar and the name, so that the progress fits on a line of 80 characters."""


def preparation(phase: str, done: int | None, total: int | None) -> str | None:
    """Describe the phase of a study before its first block. Return None for other phases."""
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
        """Show the present progress. None means that a number is unknown."""


class StudyProgress:
    """Shows the progress of one study: points done, points failed, the rate and the time left.

    Parameters
    ----------
    name : str
        Name of the study.
    points : int
        Number of points of the study.
    """

    def __init__(self, name: str, points: int) -> None:
        self._name = name
        self._points = points
        self._last_line = time.monotonic()
        self._bars: Bars | None = None
        if notes().is_terminal:
            from rich.progress import BarColumn, Progress, SpinnerColumn, TextColumn

            self._bars = Progress(
                SpinnerColumn(),
                TextColumn("{task.description}", markup=False),
                BarColumn(bar_width=BAR_WIDTH),
                TextColumn(
                    "{task.completed:,.0f}/{task.total:,.0f} points, {task.fields[figures]}", markup=False
                ),
                console=notes(),
            )
            self._task = self._bars.add_task(name[:NAME_WIDTH], total=points, figures="starting workers")

    def __enter__(self) -> "StudyProgress":
        """Begin to draw the bar."""
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
        """Show the present progress of the study. None means that a number is unknown.

        Parameters
        ----------
        done, failed : int
            Number of computed points, and number of failed points.
        rate : float, optional
            Points per second.
        seconds_left : float, optional
            Expected time to the end [s].
        preparation : str, optional
            Activity before the first block, from `preparation`.
        """
        phrases = [f"{failed:,} failed"]
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
            note(f"{self._name}: {done:,} of {self._points:,} points, {figures}")
