"""Runs the search for a design in a separate process.

Each round of the search needs the results of some studies. This process computes small studies without a cluster, and
the service computes large studies.
"""

import logging
import math
import multiprocessing
import os
import resource
import signal
import sys
import time
from collections.abc import Iterable
from contextlib import AbstractContextManager, closing, suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection
from threading import Event
from typing import TYPE_CHECKING

from damperlab.service.design_budget import HERE_SECONDS
from damperlab.service.documents import plain
from damperlab.service.logs import start_logging
from damperlab.service.settings import Settings
from damperlab.studies.design.answer import known_document
from damperlab.studies.design.design import Ask, Found, designing
from damperlab.studies.design.kept import Kept, Round, now
from damperlab.studies.design.shelf import Shelf
from damperlab.studies.faults import StudyFaults
from damperlab.studies.plan import make_plan
from damperlab.studies.specification.reading import parse_specification
from damperlab.studies.store.faults import (
    QuotaReached,
    StoreFault,
    StudyBusy,
    StudyNotFound,
    TooManyUnfinished,
)
from damperlab.studies.store.life_cycle.entering import Submission
from damperlab.studies.store.provenance import DESIGNS, submitter
from damperlab.studies.store.record import Record
from damperlab.studies.store.store import Store
from damperlab.worker.dispatch.cost_model import seconds_per_point
from damperlab.worker.niceness import stand_back
from damperlab.worker.provenance import provenance
from damperlab.worker.run.runner import run_study
from damperlab.worker.run.small_batch import AT_ONCE, compute_together
from damperlab.worker.scenes import scenes
from damperlab.worker.warm import missing

if TYPE_CHECKING:
    import xarray as xr
    from distributed import Client

    from damperlab.studies.kind import AnyStudy

LOOK_SECONDS = 0.25
"""Interval at which the run checks whether a study has ended [s]."""
ROOM_SECONDS = 5.0
"""Interval between attempts to submit studies while too many studies wait or run [s]."""

_log = logging.getLogger("damperlab.designs")


class _Over(Exception):
    """Raised to end the search if the design has ended, the service has died or a stop is requested."""


class _Stop(Event):
    """Event that is set at SIGTERM. The present study then stops, and its stored blocks are reused later."""

    computing = False
    withdrawn = False
    """Whether another process has cancelled or deleted the present study."""

    def is_set(self) -> bool:
        """Return whether a stop is requested or the present study is withdrawn."""
        return self.withdrawn or super().is_set()

    def ask(self, *_: object) -> None:
        """Handle SIGTERM: request a stop. If no study is being computed, end the process immediately."""
        self.set()
        if not self.computing:
            sys.exit(0)


class _Unable(Exception):
    """Raised if the search cannot continue. The message gives the reason."""


def run_design(settings: Settings, design_id: str, wake: "Connection[object, object]") -> None:
    """Run the search for a design until the design has ended, as the main function of a separate process.

    Parameters
    ----------
    settings : Settings
        Settings of the service.
    design_id : str
        Full id of the design.
    wake : Connection
        Connection to the service. Each message makes the service check immediately for new studies.
    """
    stop = _Stop()
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # at Ctrl-C, the service ends this process
    signal.signal(signal.SIGTERM, stop.ask)
    stand_back()
    _bound_memory(settings.work_memory_bytes)
    start_logging(settings.log_level, settings.log_format)
    shelf = Shelf(settings.data_dir)
    try:
        with closing(settings.open_store()) as store:
            _Search(settings, shelf, store, shelf.get(design_id), wake, stop).run()
    except _Over:
        return
    except (_Unable, StudyFaults, QuotaReached) as error:
        shelf.end(design_id, "failed", str(error))
    except (StoreFault, OSError) as error:
        _log.warning("design %s is tried again: %s", design_id, error)
        sys.exit(os.EX_TEMPFAIL)
    except Exception as error:
        _log.exception("design %s failed", design_id)
        shelf.end(design_id, "failed", f"{type(error).__name__}: {error}")


def _no_cluster() -> "AbstractContextManager[Client]":
    raise AssertionError("a study that is computed in this process never opens a cluster")


def _bound_memory(memory_bytes: int) -> None:
    _, most = resource.getrlimit(resource.RLIMIT_DATA)
    resource.setrlimit(resource.RLIMIT_DATA, (memory_bytes if most < 0 else min(memory_bytes, most), most))


@dataclass
class _Search:
    """The search for one design.

    Parameters
    ----------
    settings : Settings
        Settings of the service.
    shelf : Shelf
        Store of designs.
    store : Store
        Store of studies.
    kept : Kept
        The design.
    wake : Connection
        Connection to the service, see `run_design`.
    stop : _Stop
        Event that requests a stop.
    """

    settings: Settings
    shelf: Shelf
    store: Store
    kept: Kept
    wake: "Connection[object, object]"
    stop: _Stop

    def run(self) -> None:
        """Run the search to its end, and store the answer."""
        submitter.set(self.kept.owner)
        self._started = now() if self.kept.round is None else self.kept.round.started
        self._asked = parse_specification(self.kept.specification, self.settings.records)
        # storing a round marks the design as running
        if self.kept.round is None:
            self.shelf.follow(self.kept.id, Round("the first look", 0, 0, 0, (), None, self._started))
        rounds = designing(self._asked, self.kept.budget_points)
        number = 1
        try:
            ask = next(rounds)
            while True:
                ask = rounds.send(self._cubes(ask, number))
                number += 1
        except StopIteration as end:
            found: Found = end.value
        if not self.shelf.ended(self.kept.id):
            # imported only here, because a service does not need matplotlib
            from damperlab.service.design_report import keep_answer

            keep_answer(self.shelf, self.kept.id, found, number, self._started)
            _log.info("design %s is done: %d points", self.kept.id, found.book.spent)

    def _cubes(self, ask: Ask, number: int) -> "Iterable[xr.Dataset]":
        """Compute the studies of a round, in this process or in the service, and return their cubes."""
        stored = [self.store.newest(study.digest) for study in ask.studies]
        if all(record is not None and record.state == "done" for record in stored):
            return [self._cube(record.id) for record in stored if record is not None]
        self._follow(ask, number)
        records = self._entered(ask, number, stored)
        left = [pair for pair in zip(ask.studies, records, strict=True) if pair[1].state != "done"]
        here = [record.id for study, record in left if self._is_small(study)]
        if len(here) < len(left):
            self._tell()
        self._compute_together(
            [record.id for _, record in left if record.id in here and record.blocks_total == 1]
        )
        for study_id in here:
            if self.store.find(study_id).state == "queued":
                self._compute(study_id)
        return [self._cube(self._ended(record.id)) for record in records]

    def _is_small(self, study: "AnyStudy") -> bool:
        """Return whether a study is small enough to be computed in this process.

        If the settings name a scheduler or a batch system, every study is computed there, so that no design
        mixes results of different machines.
        """
        elsewhere = self.settings.scheduler is not None or self.settings.cluster is not None
        if elsewhere or missing(scenes(study)):
            return False
        return make_plan(study, seconds_per_point).seconds <= HERE_SECONDS

    def _compute_together(self, ids: list[str]) -> None:
        """Compute queued studies of one block each in parallel.

        A study that fails is queued again, and `_compute` repeats it.
        """
        for start in range(0, len(ids), AT_ONCE):
            self._require_wanted()
            self.stop.computing = True
            compute_together(self.store, ids[start : start + AT_ONCE], self.stop.is_set)
            self.stop.computing = False
            if self.stop.is_set():
                raise _Over

    def _compute(self, study_id: str) -> None:
        """Compute a queued study. If the service has started the study meanwhile, do nothing."""

        def look(_: object) -> None:
            try:
                self.stop.withdrawn = self.store.find(study_id).ended
            except StudyNotFound:
                self.stop.withdrawn = True

        self._require_wanted()
        self.stop.computing, self.stop.withdrawn = True, False
        with suppress(StudyBusy, StudyNotFound):
            run_study(
                self.store,
                study_id,
                _no_cluster,
                look,
                self.stop,
                only_from=("queued",),
                continues=True,
                here_seconds=math.inf,
            )
        self.stop.computing = self.stop.withdrawn = False
        if self.stop.is_set():
            raise _Over

    def _follow(self, ask: Ask, number: int, message: str | None = None) -> None:
        """Store the ids of a round's studies before their submission, so that a cancellation includes the studies."""
        wanted = sum(study.points for study in ask.studies)
        ids = tuple(study.digest[:12] for study in ask.studies)
        known = None if ask.ahead is None else plain(known_document(self._asked, ask.ahead))
        at = Round(ask.stage, number, ask.spent, wanted, ids, known, self._started, message)
        self.shelf.follow(self.kept.id, at)

    def _entered(self, ask: Ask, number: int, stored: list[Record | None]) -> list[Record]:
        """Submit or resume the studies of a round, and return all records. Pause while too many studies wait or run."""
        known = {record.digest: record for record in stored if record is not None}
        by = provenance() | {DESIGNS: self._asked.digest}
        new = [
            Submission(study, make_plan(study, seconds_per_point).chunk, by, self.settings.reuse)
            for study in ask.studies
            if study.digest not in known
        ]
        waited = False
        while new:
            entered, refused = self._enter(new)
            known |= {record.digest: record for record in entered}
            new = new[len(entered) :]
            if refused is not None:
                if not waited:
                    self._follow(ask, number, str(refused))
                waited = True
                self._tell()  # the service then runs the submitted studies, which makes room for further studies
                self._pause(ROOM_SECONDS)
        if waited:
            self._follow(ask, number)
        for record in known.values():
            if record.state in ("cancelled", "failed"):
                self.store.set_state(record.id, "queued", only_from=("cancelled", "failed"))
        return [known[study.digest] for study in ask.studies]

    def _enter(self, new: list[Submission]) -> tuple[list[Record], TooManyUnfinished | None]:
        """Submit as many studies as possible: all of them, or the first half, the first quarter and so on.

        Returns
        -------
        list of Record, TooManyUnfinished or None
            Records of the submitted studies, and the error if some studies could not be submitted.
        """
        count, refused = len(new), None
        while count:
            try:
                return [record for record, _ in self.store.submit_all(new[:count])], refused
            except TooManyUnfinished as error:
                count, refused = count // 2, error
        return [], refused

    def _ended(self, study_id: str) -> str:
        """Return the id of a study when it is done. Raise `_Unable` if the study is deleted, failed or cancelled."""
        while True:
            try:
                record = self.store.find(study_id)
            except StudyNotFound:
                raise _Unable(
                    f"Study {study_id} was deleted while the design waited for it. Resume the design to compute it again."
                ) from None
            if record.state == "done":
                return study_id
            if record.ended:
                why = f": {record.message}" if record.message else ""
                raise _Unable(
                    f"Study {study_id}, which the design needs, is {record.state}{why}. Resume the design to "
                    "continue it."
                )
            self._pause(LOOK_SECONDS)

    def _cube(self, study_id: str) -> "xr.Dataset":
        return self.store.steadily([study_id], lambda: self.store.cube(study_id).load())

    def _pause(self, seconds: float) -> None:
        """Wait for some seconds, and raise `_Over` if the design has ended meanwhile."""
        time.sleep(seconds)
        self._require_wanted()

    def _require_wanted(self) -> None:
        """Raise `_Over` if the design has ended or the service has died."""
        parent = multiprocessing.parent_process()
        if self.shelf.ended(self.kept.id) or (parent is not None and not parent.is_alive()):
            raise _Over

    def _tell(self) -> None:
        with suppress(OSError):
            self.wake.send(None)
