"""The coarse sub-grid of a large study, computed before its blocks as a study of its own, whose points it takes over."""

import logging
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from threading import Event
from typing import TYPE_CHECKING

from damperlab.studies.coarse import coarse
from damperlab.studies.kind import AnyStudy
from damperlab.studies.plan import make_plan
from damperlab.studies.store.faults import StoreFault
from damperlab.studies.store.provenance import ASKED_BY_PROGRAMS, COARSE_OF, SUBMITTED_BY, submitter
from damperlab.studies.store.record import Record
from damperlab.studies.store.store import Store
from damperlab.worker.dispatch.cost_model import seconds_per_point
from damperlab.worker.outcomes import ClusterUnusable
from damperlab.worker.provenance import provenance
from damperlab.worker.run.account import Account
from damperlab.worker.run.progress import Progress

if TYPE_CHECKING:
    from distributed import Client

_log = logging.getLogger(__name__)

PREVIEWED_SECONDS = 60.0
"""A study that is expected to take longer on one core has its sub-grid computed first."""


class Preview:
    """Computes the sub-grid of a study, if it has one.

    Whatever becomes of it, the study itself goes on: where the sub-grid could not be computed, there is no early map.

    Parameters
    ----------
    store : Store
        Where the study is.
    record, study : Record, AnyStudy
        The study.
    account : Account
        Told how far it is.
    stopping : callable
        Whether the study shall stop.
    run : callable
        Runs a study: `damperlab.worker.run.runner.run_study`, which begins this one.
    """

    def __init__(
        self,
        store: Store,
        record: Record,
        study: AnyStudy,
        account: Account,
        stopping: Callable[[], bool],
        run: Callable[..., Record],
    ) -> None:
        self._store = store
        self._record = record
        self._study = study
        self._account = account
        self._stopping = stopping
        self._run = run

    def compute(self, client: "Client") -> None:
        """Compute it at a cluster where the kernels are compiled already."""
        try:
            with _entered_for(self._record):
                self._compute(client)
        except (StoreFault, ClusterUnusable) as error:
            _log.info("study %s has no early map: %s", self._record.id, error)
        except Exception:
            _log.exception("study %s has no early map", self._record.id)

    def _compute(self, client: "Client") -> None:
        asked_by_somebody = self._record.provenance.keys().isdisjoint(ASKED_BY_PROGRAMS)
        first = coarse(self._study) if self._record.reuse and asked_by_somebody else None
        if first is None or self._stopping():
            return

        def tell(progress: Progress) -> None:
            self._account.enter("previewing", progress.points_done, progress.points_total)

        plan = make_plan(first, seconds_per_point)
        facts = provenance() | {COARSE_OF: self._record.id}
        record, _ = self._store.submit(first, plan, facts, priority=self._record.priority)
        self._run(
            self._store,
            record.id,
            lambda: nullcontext(client),
            tell,
            _StopsWith(self._stopping),
            only_from=("queued", "running"),
            outage_as="cancelled",
        )


class _StopsWith(Event):
    """Is set as soon as another study shall stop, also while this one waits for workers and tells nothing."""

    def __init__(self, stopping: Callable[[], bool]) -> None:
        super().__init__()
        self._stopping = stopping

    def is_set(self) -> bool:
        """Ask the other study."""
        return super().is_set() or self._stopping()


@contextmanager
def _entered_for(record: Record) -> Iterator[None]:
    """Enter studies for whoever has submitted one."""
    token = submitter.set(record.provenance.get(SUBMITTED_BY))
    try:
        yield
    finally:
        submitter.reset(token)
