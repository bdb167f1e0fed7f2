"""Progress of a design on standard error: points, what goes on and the best damper so far; lines where there is no terminal."""

import time
from collections.abc import Iterable
from contextlib import AbstractContextManager, nullcontext
from types import TracebackType

from rich.console import RenderableType
from rich.progress import BarColumn, Progress, SpinnerColumn, TextColumn
from rich.text import Text

from damperlab.service.cli.output import NOTES, duration, note
from damperlab.service.cli.progress import BAR_WIDTH, LINE_EVERY_SECONDS

RATED_SECONDS = 2.0
"""For which points are counted before a rate is told."""


class DesignProgress:
    """Shows points of at most so many, what is computed, the best damper so far, and how long it takes at most.

    Parameters
    ----------
    budget : int
        Most points.
    """

    def __init__(self, budget: int) -> None:
        self._budget = budget
        self._stage, self._best = "", ""
        self._first: tuple[float, int] | None = None
        self._last_line = 0.0
        self._last_stage = ""
        self._bars = _Bars() if NOTES.is_terminal else None
        if self._bars is not None:
            self._task = self._bars.add_task("", total=budget, figures="")

    def __enter__(self) -> "DesignProgress":
        """Begin to draw."""
        if self._bars is not None:
            self._bars.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Clear the terminal for what follows."""
        if self._bars is not None:
            self._bars.stop()

    def begin(self, points: int, stage: str, best: str) -> None:
        """Take what is known when a round begins.

        Parameters
        ----------
        points : int
            Known so far.
        stage : str
            What is computed next.
        best : str
            The best damper so far; empty where there is none yet.
        """
        self._stage, self._best = stage, best
        self.update(points)

    def update(self, points: int, preparation: str | None = None) -> None:
        """Take the points that are known now, and what goes on before the first of a study is."""
        now = time.monotonic()
        self._first = self._first or (now, points)
        figures = ", ".join([f"{points:,} of at most {self._budget:,} points", *self._rate(now, points)])
        stage = f"{self._stage} ({preparation})" if preparation else self._stage
        if self._bars is not None:
            self._bars.lines = [stage, f"Best so far: {self._best}" if self._best else ""]
            self._bars.update(self._task, completed=points, figures=figures)
        elif self._stage != self._last_stage or now - self._last_line >= LINE_EVERY_SECONDS:
            self._last_stage, self._last_line = self._stage, now
            best = f" Best so far: {self._best}." if self._best else ""
            note(f"{figures}. Now: {stage}.{best}")

    def _rate(self, now: float, points: int) -> Iterable[str]:
        """Say how long the rest of the budget takes; a search may end before."""
        assert self._first is not None
        began, before = self._first
        if now - began >= RATED_SECONDS and points > before:
            left = (self._budget - points) * (now - began) / (points - before)
            yield f"{duration(left)} left at most"

    def of_study(self, points: int) -> AbstractContextManager["OfStudy"]:
        """Give what takes the progress of a study that begins with so many points known."""
        return nullcontext(OfStudy(self, points))


class OfStudy:
    """The progress of one study of a design; see `damperlab.service.cli.progress.StudyProgress.update`."""

    def __init__(self, design: DesignProgress, points: int) -> None:
        self._design, self._before = design, points

    def update(
        self,
        done: int,
        failed: int,
        rate: float | None,
        seconds_left: float | None,
        preparation: str | None = None,
    ) -> None:
        """Count the study's points among the design's."""
        self._design.update(self._before + done, preparation)


class _Bars(Progress):
    """A bar, and lines below it."""

    def __init__(self) -> None:
        self.lines: list[str] = []
        super().__init__(
            SpinnerColumn(),
            BarColumn(bar_width=BAR_WIDTH),
            TextColumn("{task.fields[figures]}", markup=False),
            console=NOTES,
            transient=True,
        )

    def get_renderables(self) -> Iterable[RenderableType]:
        """Give the bar and the lines."""
        yield from super().get_renderables()
        for line in filter(None, self.lines):
            yield Text(f"  {line[:1].upper()}{line[1:]}")
