"""Progress of a study on standard error: bars on a terminal, a line now and then elsewhere."""

import time
from types import TracebackType

from rich.progress import (
    BarColumn,
    Progress,
    SpinnerColumn,
    TextColumn,
)

from damperlab.service.cli.output import NOTES, duration, note

LINE_EVERY_SECONDS = 5.0
"""Between two lines where there is no terminal: a log stays short, and a reader sees that work goes on."""

BAR_WIDTH, NAME_WIDTH = 12, 16
"""So that all of it stays on one line of 80 characters."""


class StudyProgress:
    """Shows points done, points failed, the rate and the time left of one study.

    Parameters
    ----------
    name : str
        What to call the study.
    points : int
        Points of the whole study.
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

    def update(self, done: int, failed: int, rate: float | None, seconds_left: float | None) -> None:
        """Take the figures of the study as they are now; None is not known."""
        phrases = [f"{failed} failed"]
        if rate:
            phrases.append(f"{rate:.3g} points/s")
        elif done:
            phrases.append("waiting for the next block")
        else:
            # on a new machine that takes a minute or two, in which nothing else would move
            phrases.append("compiling, or in the first block")
        if seconds_left is not None:
            phrases.append(f"{duration(seconds_left)} left")
        figures = ", ".join(phrases)
        now = time.monotonic()
        if self._bars is not None:
            self._bars.update(self._task, completed=done, figures=figures)
        elif now - self._last_line >= LINE_EVERY_SECONDS:
            self._last_line = now
            note(f"{self._name}: {done} of {self._points} points, {figures}")
