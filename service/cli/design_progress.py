"""Progress of a design on standard error: a bar on a terminal, plain lines elsewhere."""

import re
import time
from collections.abc import Iterable
from contextlib import AbstractContextManager, nullcontext
from types import TracebackType

from rich.console import RenderableType
from rich.progress import BarColumn, Progress, SpinnerColumn, TextColumn
from rich.text import Text

from damperlab.service.cli.output import duration, note, notes
from damperlab.service.cli.progress import BAR_WIDTH, LINE_EVERY_SECONDS


class DesignProgress:
    """Shows the number of points so far, the elapsed time, the activity and the best damper so far.

    The bar shows no percentage, because a search usually ends long before the budget is spent.

    Parameters
    ----------
    budget : int
        Largest number of points.
    """

    def __init__(self, budget: int) -> None:
        self._budget = budget
        self._stage, self._best = "", ""
        self._began = time.monotonic()
        self._last_line = 0.0
        self._activity = ""
        self._bars = _Bars() if notes().is_terminal else None
        if self._bars is not None:
            self._task = self._bars.add_task("", total=None, figures="")

    def __enter__(self) -> "DesignProgress":
        """Begin to draw."""
        if self._bars is not None:
            self._bars.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Clear the terminal for further output."""
        if self._bars is not None:
            self._bars.stop()

    def begin(self, points: int, stage: str, best: str) -> None:
        """Show the state at the start of a round of studies.

        Parameters
        ----------
        points : int
            Number of points known so far.
        stage : str
            Present activity.
        best : str
            Description of the best damper so far; empty if no damper is known yet.
        """
        self._stage, self._best = stage, best
        self.update(points)

    def update(self, points: int, preparation: str | None = None) -> None:
        """Show the number of known points. `preparation` is the activity of a study before its first block."""
        now = time.monotonic()
        figures = f"{points:,} of at most {self._budget:,} points, {duration(now - self._began)}"
        stage = f"{self._stage} ({preparation})" if preparation else self._stage
        if self._bars is not None:
            self._bars.lines = [stage, f"Best so far: {self._best}" if self._best else ""]
            self._bars.update(self._task, completed=points, figures=figures)
        # a stage that differs only in its counts is no new activity
        elif (activity := re.sub(r"\d+", "", self._stage)) != self._activity or (
            now - self._last_line >= LINE_EVERY_SECONDS
        ):
            self._activity, self._last_line = activity, now
            best = f" Best so far: {self._best}." if self._best else ""
            note(f"{figures}. Now: {stage}.{best}")

    def of_study(self, points: int) -> AbstractContextManager["OfStudy"]:
        """Return the display of a study; `points` is the number of points known before the study."""
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
        """Show the points of the design so far, including the points of this study."""
        self._design.update(self._before + done, preparation)


class _Bars(Progress):
    """A progress bar with lines of text below the bar."""

    def __init__(self) -> None:
        self.lines: list[str] = []
        super().__init__(
            SpinnerColumn(),
            BarColumn(bar_width=BAR_WIDTH),
            TextColumn("{task.fields[figures]}", markup=False),
            console=notes(),
            transient=True,
        )

    def get_renderables(self) -> Iterable[RenderableType]:
        """Yield the bar, and then the lines of text."""
        yield from super().get_renderables()
        for line in filter(None, self.lines):
            yield Text(f"  {line[:1].upper()}{line[1:]}")
