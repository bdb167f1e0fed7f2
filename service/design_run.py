"""One design of a running service, searched in a separate process.

Its rounds are studies. Small ones are computed in this process, without a cluster; the service runs the others.
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
"""Interval between checks of a study."""
ROOM_SECONDS = 5.0
"""Interval between attempts to enter studies while the limit of waiting and running studies is reached."""

_log = logging.getLogger("damperlab.designs")


class _Over(Exception):
    """Another process ended the design, or the service is gone."""


class _Stop(Event):
    """Set by SIGTERM. The present study is stopped cleanly; everything stored so far is used again later."""

    computing = False
    withdrawn = False
    """Whether the present study was cancelled or deleted."""

    def is_set(self) -> bool:
        """Whether to start no further block."""
        return self.withdrawn or super().is_set()

    def ask(self, *_: object) -> None:
        """Request the stop; a handler for `signal.signal`."""
        self.set()
        if not self.computing:
            sys.exit(0)


class _Unable(Exception):
    """The design cannot continue; the message gives the reason."""


def run_design(settings: Settings, design_id: str, wake: "Connection[object, object]") -> None:
    """Search until the design has ended; in a separate process, which may be killed at any moment.

    Parameters
    ----------
    settings : Settings
        Of the service.
    design_id : str
        The whole id.
    wake : Connection
        Connection that is written to when studies were entered, so that the service checks for them immediately.
    """
    stop = _Stop()
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the service handles Ctrl-C, and ends this process
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
    settings, shelf, store
        Settings and stores of the service, which hold the design and its studies.
    kept : Kept
        The design.
    wake : Connection
        As for `run_design`.
    stop : _Stop
        Set from outside.
    """

    settings: Settings
    shelf: Shelf
    store: Store
    kept: Kept
    wake: "Connection[object, object]"
    stop: _Stop

    def run(self) -> None:
        """Complete the search, and store the answer."""
        submitter.set(self.kept.owner)
        self._started = now() if self.kept.round is None else self.kept.round.started
        self._asked = parse_specification(self.kept.specification, self.settings.records)
        # the design counts as running from now on, even if all its studies are already stored
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
            # the service imports this module to start a search but draws nothing, so matplotlib is imported only for a
            # figure
            from damperlab.service.design_report import keep_answer

            keep_answer(self.shelf, self.kept.id, found, number, self._started)
            _log.info("design %s is done: %d points", self.kept.id, found.book.spent)

    def _cubes(self, ask: Ask, number: int) -> "Iterable[xr.Dataset]":
        """Have studies computed, and give their cubes one after the other."""
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
        """Whether to compute a study in this process, because a cluster of this machine would take longer.

        A cluster with other machines computes all studies of a design, so that no answer combines results of different
        machines.
        """
        elsewhere = self.settings.scheduler is not None or self.settings.cluster is not None
        if elsewhere or missing(scenes(study)):
            return False
        return make_plan(study, seconds_per_point).seconds <= HERE_SECONDS

    def _compute_together(self, ids: list[str]) -> None:
        """Compute waiting studies of one block, one on each core; a study that fails is left to `_compute`."""
        for start in range(0, len(ids), AT_ONCE):
            self._require_wanted()
            self.stop.computing = True
            compute_together(self.store, ids[start : start + AT_ONCE], self.stop.is_set)
            self.stop.computing = False
            if self.stop.is_set():
                raise _Over

    def _compute(self, study_id: str) -> None:
        """Compute a waiting study, unless the service has started it meanwhile; its record gives the outcome."""

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
                stopped_as="queued",
                outage_as="queued",
                here_seconds=math.inf,
            )
        self.stop.computing = self.stop.withdrawn = False
        if self.stop.is_set():
            raise _Over

    def _follow(self, ask: Ask, number: int, message: str | None = None) -> None:
        """Record the wanted studies before they are entered, so that the process that ends the design finds them."""
        wanted = sum(study.points for study in ask.studies)
        ids = tuple(study.digest[:12] for study in ask.studies)
        known = None if ask.ahead is None else plain(known_document(self._asked, ask.ahead))
        at = Round(ask.stage, number, ask.spent, wanted, ids, known, self._started, message)
        self.shelf.follow(self.kept.id, at)

    def _entered(self, ask: Ask, number: int, stored: list[Record | None]) -> list[Record]:
        """Enter the studies that are not stored, once there is room, and resume those that were stopped."""
        known = {record.digest: record for record in stored if record is not None}
        by = provenance() | {DESIGNS: self._asked.digest}
        new = [
            Submission(study, make_plan(study, seconds_per_point), by, self.settings.reuse)
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
                self._tell()  # entered studies make room when they end
                self._pause(ROOM_SECONDS)
        if waited:
            self._follow(ask, number)
        for record in known.values():
            if record.state in ("cancelled", "failed"):
                self.store.set_state(record.id, "queued", only_from=("cancelled", "failed"))
        return [known[study.digest] for study in ask.studies]

    def _enter(self, new: list[Submission]) -> tuple[list[Record], TooManyUnfinished | None]:
        """Enter all studies or, while there is no room for them, the first half, quarter and so on. Give the entered
        studies, and the fault that refused more.
        """
        count, refused = len(new), None
        while count:
            try:
                return [record for record, _ in self.store.submit_all(new[:count])], refused
            except TooManyUnfinished as error:
                count, refused = count // 2, error
        return [], refused

    def _ended(self, study_id: str) -> str:
        """Wait until a study is done."""
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
        return self.store.cube(study_id).load()

    def _pause(self, seconds: float) -> None:
        """Wait briefly; raise `_Over` if the design was ended."""
        time.sleep(seconds)
        self._require_wanted()

    def _require_wanted(self) -> None:
        """Raise `_Over` if the design was ended, here or elsewhere, or the service is gone."""
        parent = multiprocessing.parent_process()
        if self.shelf.ended(self.kept.id) or (parent is not None and not parent.is_alive()):
            raise _Over

    def _tell(self) -> None:
        with suppress(OSError):
            self.wake.send(None)
