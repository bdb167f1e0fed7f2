"""Follow a study until it has ended, despite lost connections and restarts of the service, and show its progress."""

import json
import math
import time
from collections.abc import Iterator, Mapping
from contextlib import AbstractContextManager
from html import escape
from types import TracebackType
from typing import TYPE_CHECKING, Any, Protocol

import httpx

from damperlab.service.client.faults import NotFound, Unavailable, Unreachable
from damperlab.service.client.figure import in_notebook
from damperlab.service.client.transport import Transport

if TYPE_CHECKING:
    from damperlab.service.cli.progress import Shown

ENDS = ("done", "cancelled", "failed")
LOOK_SECONDS = 1.0
"""Shortest time between two requests for the record of the study [s]."""
SILENCE_SECONDS = 20.0
"""Longest silence of the stream of events [s]. The service sends a comment every 15 s. A longer silence means
that the service has ended, or that a proxy holds the events back.
"""


def follow(transport: Transport, study_id: str, until: float | None = None) -> Iterator[Mapping[str, Any]]:
    """Yield the record of a study at every change, and finally when it has ended.

    Events of the service announce changes. If the events stop, or a proxy holds the events back, the record itself is
    requested.

    Parameters
    ----------
    transport : Transport
        The connection to the service.
    study_id : str
        The study.
    until : float, optional
        Stop at this time, on the clock `time.monotonic`, even if the study has not ended.

    Yields
    ------
    mapping
        The record as returned by ``GET /studies/{id}``, or the shorter record that an event contains.
    """
    while True:
        record = transport.ask("GET", f"/studies/{study_id}")
        yield record
        began = time.monotonic()
        left = math.inf if until is None else until - began
        if record["state"] in ENDS or left <= 0:
            return
        try:
            for event in _events(transport, study_id, min(SILENCE_SECONDS, left)):
                yield event
                if event["state"] in ENDS or (until is not None and time.monotonic() > until):
                    break
        except NotFound:
            raise
        except (Unavailable, Unreachable):
            pass  # the loop requests the record again
        # without a pause, a stream that ends immediately would cause a busy loop
        time.sleep(max(0.0, min(LOOK_SECONDS, left) - (time.monotonic() - began)))


def _events(transport: Transport, study_id: str, silence_seconds: float) -> Iterator[Mapping[str, Any]]:
    timeout = httpx.Timeout(silence_seconds, connect=10.0)
    headers = {"Accept": "text/event-stream"}
    with transport.stream(f"/studies/{study_id}/events", headers=headers, timeout=timeout) as response:
        for line in response.iter_lines():
            if line.startswith("data:"):
                event = json.loads(line.removeprefix("data:"))
                # a deleted study has no state; requesting its record raises the error
                if "state" not in event:
                    return
                yield event


def preparation(record: Mapping[str, Any]) -> str | None:
    """Describe the activity of a study before its first block is computed.

    Return None in later phases, or if the service does not report the phase.
    """
    if record.get("phase") == "starting":
        return "starting workers"
    if record.get("phase") == "compiling":
        return f"compiling kernels, {record['phase_done']} of {record['phase_total']} done"
    if record.get("phase") == "waiting":
        return "waiting for workers"
    return None


class DesignShown(Protocol):
    """A display of the progress of a design."""

    def begin(self, points: int, stage: str, best: str) -> None:
        """Show the number of known points, the activity, and the best damper so far; `best` may be empty."""


def shown_design(name: str, budget: int) -> AbstractContextManager[DesignShown]:
    """Choose the display of a design's progress: a bar in a notebook, otherwise the display of the command line."""
    if in_notebook():
        return _NotebookBar(name, budget)
    from damperlab.service.cli.design_progress import DesignProgress

    return DesignProgress(budget)


def shown(name: str, points: int) -> "AbstractContextManager[Shown]":
    """Choose the display of a study's progress: a bar in a notebook, otherwise the display of the command line."""
    if in_notebook():
        return _NotebookBar(name, points)
    from damperlab.service.cli.progress import StudyProgress

    return StudyProgress(name, points)


class _NotebookBar:
    """A progress bar in HTML. In a notebook, a progress bar of the library `rich` would need a further package."""

    def __init__(self, name: str, points: int) -> None:
        self._name, self._points = name, points
        self._handle: Any = None
        self._text = ""

    def __enter__(self) -> "_NotebookBar":
        self.update(0, 0, None, None)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        return None

    def update(
        self,
        done: int,
        failed: int,
        rate: float | None,
        seconds_left: float | None,
        preparation: str | None = None,
    ) -> None:
        """Draw the bar again."""
        phrases = [f"{done:,} of {self._points:,} points"]
        phrases += [f"{failed} failed"] if failed else []
        phrases += [preparation] if preparation else []
        phrases += [f"{seconds_left:.0f} s left"] if seconds_left is not None and done < self._points else []
        self._draw(done, f"{self._name}: {', '.join(phrases)}")

    def begin(self, points: int, stage: str, best: str) -> None:
        """Draw the bar of a design again."""
        phrases = [f"{points:,} of at most {self._points:,} points", *filter(None, [stage])]
        self._draw(points, f"{self._name}: {', '.join(phrases)}{f'. Best so far: {best}' if best else ''}")

    def _draw(self, done: int, text: str) -> None:
        from IPython.display import display

        if text == self._text:
            return
        self._text = text
        bar = f'<progress max="{self._points}" value="{done}"></progress>'
        drawn = {"text/html": f"{bar} {escape(text)}", "text/plain": text}
        if self._handle is None:
            show: Any = display
            self._handle = show(drawn, raw=True, display_id=True)
        else:
            self._handle.update(drawn, raw=True)
