"""Runs the searches for waiting designs in separate processes. Unfinished searches are resumed after a restart."""

import logging
import multiprocessing
import os
import threading
import time
from contextlib import closing, suppress
from dataclasses import dataclass
from multiprocessing.process import BaseProcess
from typing import TYPE_CHECKING

from damperlab.service.dispatch import Dispatcher
from damperlab.service.settings import Settings
from damperlab.studies.design.kept import Kept
from damperlab.studies.store.faults import StoreFault, StudyNotFound
from damperlab.studies.store.provenance import DESIGNS
from damperlab.studies.store.store import Store
from damperlab.worker.run.background import Background

if TYPE_CHECKING:
    from multiprocessing.connection import Connection

LOOK_SECONDS = 2.0
"""Interval between checks for waiting designs [s]. Other processes may have submitted designs or left them unfinished."""
AGAIN_SECONDS = 5.0
"""Time after which a search is started again if its process could not use the store or was killed [s]."""
MOST_DEATHS = 3
"""A design fails if its process dies this many times in a row."""
STOP_SECONDS = 10.0

_log = logging.getLogger("damperlab.designs")


def _search(settings: Settings, design_id: str, wake: "Connection[object, object]") -> None:
    from damperlab.service.design_run import (
        run_design,  # imported only here, because only the process of a design needs the solver
    )

    run_design(settings, design_id, wake)


@dataclass(frozen=True)
class _Run:
    thread: threading.Thread
    process: BaseProcess


class Designer:
    """Runs the searches for the designs in a data directory, the oldest design first.

    A design that has not ended is resumed. Completed studies of the design are stored, and are not computed again.

    Parameters
    ----------
    settings : Settings
        Settings of the service.
    store : Store
        Store of studies.
    dispatcher : Dispatcher
        Dispatcher that runs the studies of the designs.
    """

    def __init__(self, settings: Settings, store: Store, dispatcher: Dispatcher) -> None:
        self.shelf = settings.designs
        self._settings = settings
        self._store = store
        self._dispatcher = dispatcher
        self._lock = threading.Lock()
        self._runs: dict[str, _Run] = {}
        self._not_before: dict[str, float] = {}
        self._deaths: dict[str, int] = {}
        self.background = Background("designs", self._start_runs, LOOK_SECONDS)
        """Thread that checks for waiting designs."""
        # "spawn" starts a new interpreter; a fork would copy the locks of threads and the connections to the catalogue
        self._processes = multiprocessing.get_context("spawn")

    def start(self) -> None:
        """Start the thread that checks for waiting designs."""
        self.background.start()

    def wake(self) -> None:
        """Check for waiting designs now, for example after a design was submitted."""
        self.background.wake()

    def cancel(self, kept: Kept) -> Kept:
        """Cancel a waiting or running design, and keep its completed studies.

        Parameters
        ----------
        kept : Kept
            The design.

        Returns
        -------
        Kept
            The design in its new state. The state is unchanged if the design had already ended.
        """
        if self.shelf.end(kept.id, "cancelled"):
            with self._lock:
                run = self._runs.get(kept.id)
            if run is not None:
                run.process.terminate()
                run.thread.join(STOP_SECONDS)
            self._cancel_studies(self.shelf.get(kept.id))
        return self.shelf.get(kept.id)

    def resume(self, kept: Kept) -> Kept:
        """Resume a design that was cancelled or has failed. Completed studies are not computed again."""
        if kept.state in ("cancelled", "failed"):
            self.shelf.resume(kept.id)
            self._deaths.pop(kept.id, None)
            self._not_before.pop(kept.id, None)
            self.wake()
        return self.shelf.get(kept.id)

    def close(self) -> None:
        """Stop all searches. Unfinished designs are resumed at the next start."""
        self.background.close()
        with self._lock:
            runs = list(self._runs.values())
        for run in runs:
            run.process.terminate()
        # all processes share one time limit, because the time for the shutdown is limited
        give_up = time.monotonic() + STOP_SECONDS
        for run in runs:
            run.thread.join(max(0.0, give_up - time.monotonic()))
        for run in runs:
            run.process.kill()
            run.thread.join(STOP_SECONDS)

    def _start_runs(self) -> None:
        self.shelf.bury()
        for kept in self.shelf.waiting():
            with self._lock:
                if self.background.closing or len(self._runs) >= self._settings.designs_at_once:
                    return
                if kept.id in self._runs or self._not_before.get(kept.id, 0.0) > time.monotonic():
                    continue
                ready = threading.Event()
                thread = threading.Thread(
                    target=self._run, args=(kept.id, ready), name=f"design-{kept.id}", daemon=True
                )
                thread.start()
            ready.wait()

    def _run(self, design_id: str, ready: threading.Event) -> None:
        try:
            process = self._searched(design_id, ready)
            self._note_end(design_id, process.exitcode)
        except BaseException as error:
            self._not_before[design_id] = time.monotonic() + AGAIN_SECONDS
            trace = None if isinstance(error, StoreFault | OSError) else error
            _log.warning("design %s is tried again: %s", design_id, error, exc_info=trace)
        finally:
            ready.set()
            with self._lock:
                run = self._runs.pop(design_id, None)
            if run is not None and run.process.is_alive():
                run.process.kill()
            self.wake()

    def _searched(self, design_id: str, ready: threading.Event) -> BaseProcess:
        """Run a search in a new process, wait for its end, and return the process."""
        hears, tells = self._processes.Pipe(duplex=False)
        arguments = (self._settings, design_id, tells)
        process = self._processes.Process(target=_search, args=arguments, daemon=True)
        with closing(hears):
            with closing(tells), self._lock:
                process.start()
                self._runs[design_id] = _Run(threading.current_thread(), process)
            ready.set()
            with suppress(EOFError, OSError):
                while True:
                    hears.recv()
                    self._dispatcher.wake()
            process.join()
        return process

    def _note_end(self, design_id: str, status: int | None) -> None:
        """Decide whether to restart a search whose process has ended, or to let the design fail."""
        if self.background.closing or self.shelf.ended(design_id):
            self._deaths.pop(design_id, None)
            return
        self._not_before[design_id] = time.monotonic() + AGAIN_SECONDS
        if status in (0, os.EX_TEMPFAIL):
            return
        deaths = self._deaths[design_id] = self._deaths.get(design_id, 0) + 1
        _log.warning("the process of design %s ended with status %s", design_id, status)
        if deaths >= MOST_DEATHS:
            del self._deaths[design_id]
            told = (
                f"The process of the search died {deaths} times in a row, the last time with status {status}; the "
                "search may need more memory."
            )
            self.shelf.end(design_id, "failed", told)

    def _cancel_studies(self, kept: Kept) -> None:
        """Cancel the studies of the last round that were submitted only for this design."""
        for study_id in () if kept.round is None else kept.round.studies:
            with suppress(StudyNotFound):
                record = self._store.find(study_id)
                if record.provenance.get(DESIGNS) == kept.digest:
                    self._dispatcher.cancel(record)
