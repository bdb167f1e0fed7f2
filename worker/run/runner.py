"""Runs a study: claims it, computes and stores its pending blocks, and sets its final state."""

import math
import time
from collections.abc import Callable
from contextlib import AbstractContextManager, closing, suppress
from dataclasses import dataclass
from threading import Event
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.plan import Plan, plan_with_chunk
from damperlab.studies.store.care.sweep import sweep
from damperlab.studies.store.cube.definition import parse_stored
from damperlab.studies.store.cube.description import description_of
from damperlab.studies.store.faults import StoreFault, StudyNotFound, may_pass
from damperlab.studies.store.files.folder import open_shelf
from damperlab.studies.store.record import Record
from damperlab.studies.store.store import Store
from damperlab.studies.vocabulary import STATES
from damperlab.worker.cores import core_count
from damperlab.worker.dispatch.cost_model import seconds_per_point
from damperlab.worker.outcomes import ClusterUnusable, Interrupted, Outage, unusable_data
from damperlab.worker.provenance import WrongCode, computing, require_solver
from damperlab.worker.run.calls import Calls
from damperlab.worker.run.in_this_process import InThisProcess
from damperlab.worker.run.lease import Lease, hold
from damperlab.worker.run.progress import Progress, Reporter
from damperlab.worker.run.results import Results
from damperlab.worker.scenes import Scene, scenes
from damperlab.worker.warm import compile_apart, missing

if TYPE_CHECKING:
    from distributed import Client

    from damperlab.worker.dispatch.window import Window

GRACE_SECONDS = 15.0
"""Longest wait for the running blocks of a stopped study [s]. A block takes a few seconds."""
AGAIN_SECONDS = 1.0
"""Interval between checks of a store that does not answer [s]."""
POLL_SECONDS = 0.2
"""Longest wait of the coordinator for results [s]. A request to stop is noticed after this time at the latest."""
SECONDS_PER_HOUR = 3600.0


def run_study(
    store: Store,
    study_id: str,
    client_factory: "Callable[[], AbstractContextManager[Client]]",
    on_progress: Callable[[Progress], None],
    stop: Event,
    *,
    only_from: tuple[str, ...] = STATES,
    continues: bool = False,
    here_seconds: float = 0.0,
    wait_seconds: float = 120.0,
    return_seconds: float = 0.0,
    budget_seconds: float = math.inf,
) -> Record:
    """Compute the missing blocks of a study.

    If all blocks have ended, the final state is `done`, or `failed` if every block failed. If the study is stopped,
    here or by another process, the final state is `cancelled`. If the study cannot continue, for example because the
    scheduler is lost or the disk is full, the final state is `failed`, and the message gives the reason. In every case
    the finished blocks are kept, and a further call of this function computes the remaining blocks.

    Parameters
    ----------
    store : Store
        Store that holds the study.
    study_id : str
        Full id of the study.
    client_factory : callable
        Returns a context manager that yields a client, for example `damperlab.worker.cluster.cluster.connect`. The
        function is called only if blocks must be computed on a cluster.
    on_progress : callable
        Called in this thread at the start of the study, about twice a second during the study, and at its end.
    stop : Event
        Event that another thread sets to stop the run. No further block then starts, and running blocks may finish
        within `GRACE_SECONDS`.
    only_from : tuple of str
        States from which the study may start. In any other state, nothing is computed.
    continues : bool
        Whether the caller continues the study later. After `stop` and after a temporary failure, such as an absent
        cluster or a full disk, the study is then queued again. A state that another process has set meanwhile is kept.
    here_seconds : float
        If the missing blocks are expected to take at most this time [s], this process computes them without a cluster.
    wait_seconds : float
        Longest wait while no worker of the cluster can compute [s].
    return_seconds : float
        Longest wait for a lost scheduler, or for a store that does not answer [s].
    budget_seconds : float
        Kernel time after which no further block starts [s]. The study then ends as if it had been stopped, and the
        message says that the budget is spent.

    Returns
    -------
    Record
        The study in its final state.

    Raises
    ------
    StudyNotFound
        If the study does not exist, or was deleted while it ran.
    StudyBusy
        If another process runs the study. Nothing is changed in this case.
    ClusterUnusable
        If no cluster can be reached. The study can be run again.
    """
    store.find(study_id)
    stopped_as, outage_as = ("queued", "queued") if continues else ("cancelled", "failed")
    limits = Limits(here_seconds, wait_seconds, return_seconds, budget_seconds)
    with hold(store, study_id) as lease:
        run = Run(lease, Reporter(lease, on_progress), client_factory, stop, limits)
        if run.begin(only_from):
            try:
                run.complete(stopped_as)
            # Each branch writes the final state once: a process killed between two writes would leave a wrong state.
            except StudyNotFound:
                raise
            except (Outage, StoreFault) as error:
                # if the catalogue was locked or its server did not answer, writing the state may succeed now
                run.results.end_as(outage_as, f"{error}; {run.results.left()}")
            except Interrupted as error:
                run.results.end_as(
                    outage_as if store.trouble() else "failed", f"{error}; {run.results.left()}"
                )
            except WrongCode as error:
                run.results.end_as("failed", str(error))
            except KeyboardInterrupt:
                run.results.end_as("cancelled", None)
                raise
            except ClusterUnusable as error:
                run.results.end_as(outage_as, str(error))
                raise
            except Exception as error:
                run.results.end_as("failed", str(error))
                raise
    return store.find(study_id)


@dataclass(frozen=True)
class Limits:
    """Time limits of a run [s]; see the parameters of `run_study`."""

    here_seconds: float
    wait_seconds: float
    return_seconds: float
    budget_seconds: float


class Run:
    """One run of one claimed study.

    Parameters
    ----------
    lease : Lease
        This run's claim on the study.
    reporter : Reporter
        Object that reports phase and progress.
    client_factory : callable
        Returns a context manager that yields a client of the cluster.
    stop : Event
        Event that another thread sets to stop the run.
    limits : Limits
        Time limits of the run.
    """

    plan: Plan
    """Division of the study into blocks. It is set when the computation begins."""
    cube_path: str
    """Location of the cube. It is read once, so that a locked catalogue does not stop the handling of a failed block."""

    def __init__(
        self,
        lease: Lease,
        reporter: Reporter,
        client_factory: "Callable[[], AbstractContextManager[Client]]",
        stop: Event,
        limits: Limits,
    ) -> None:
        self.lease = lease
        self.reporter = reporter
        self.client_factory = client_factory
        self.limits = limits
        self.results = Results(self)
        self.had_cluster = False
        """Whether this run has used a cluster. The run then waits if no cluster can be reached."""
        self._store = lease.store
        self._study_id = lease.study_id
        self._stop = stop
        self._record = self._store.find(self._study_id)

    def begin(self, only_from: tuple[str, ...]) -> bool:
        """Set the state to `running` if the present state is in `only_from`. Return whether the study is running."""
        # the message of an earlier run is kept only if points have failed
        told = None if self._record.points_failed else ""
        owner = self.lease.owner
        self._record = self._store.set_state(
            self._study_id, "running", told, only_from=only_from, owner=owner
        )
        self.lease.begun.set()
        return self._record.state == "running"

    def complete(self, stopped_as: str) -> None:
        """Compute the pending blocks and set the final state. If the store does not answer, wait for an answer."""
        gives_up_at, kept = 0.0, -1
        while True:
            try:
                self._compute()
                self.reporter.report(at_once=True)
                self.results.end(stopped_as, self._budget_spent())
                return
            except StoreFault as error:
                if not may_pass(error) or self.stopping:
                    raise
                if self.results.marked > kept:
                    kept = self.results.marked
                    gives_up_at = time.monotonic() + self.limits.return_seconds
                self._wait_for_store(error, gives_up_at)

    def _wait_for_store(self, error: StoreFault, gives_up_at: float) -> None:
        """Wait until the catalogue answers, and read the record again.

        If there is no answer in time, raise the last error.
        """
        while time.monotonic() < gives_up_at and not self.stopping:
            self.reporter.wait(error.fault.sentence, gives_up_at)
            self._stop.wait(AGAIN_SECONDS)
            try:
                self._record = self._store.find(self._study_id)
                self.reporter.enter(None)
                return
            except StoreFault as again:
                if not may_pass(again):
                    raise
                error = again
        raise error

    def _compute(self) -> None:
        """Compute the pending blocks until none is left, the run is stopped or the budget is spent."""
        study = parse_stored(self._record.definition, self._record.digest)
        # the recorded chunk is used, because the cost model may have changed since the submission
        self.plan = plan_with_chunk(study, self._record.chunk, seconds_per_point)
        self.cube_path = self._store.cube_path(self._study_id)
        self._take_back_lost()
        pending = self.pending()
        work_left = float(self.plan.block_seconds[pending].sum())
        self.reporter.measure(self._record, work_left)
        self.reporter.report(at_once=True)
        if not pending.size or self.stopping:
            return
        sweep(self._store, self._study_id)
        if self._record.blocks_done:
            # the workers' processors are compared later, when a cluster has started
            require_solver(self._study_id, self._record.provenance)
        self._require_room()
        if work_left <= self.limits.here_seconds:
            self._compute_here(pending, work_left)
            return
        self._require_readable()
        # imported only here, because blocks computed in this process need no cluster library
        from damperlab.worker.run.on_cluster import compute_on_cluster

        compute_on_cluster(self)

    def pending(self) -> NDArray[np.int64]:
        """Return the indices of the blocks that are not done."""
        return self._store.pending(self._study_id)

    def _take_back_lost(self) -> None:
        """Mark blocks whose files are lost as pending, so that they are computed again."""
        lost = self._store.lost_blocks(self._study_id)
        if lost:
            require_solver(self._study_id, self._record.provenance)
            owner = self.lease.owner
            self._record = self._store.forget(self._study_id, lost, "their files are lost", owner=owner)

    def _compute_here(self, pending: NDArray[np.int64], work_left: float) -> None:
        calls = Calls(self, self._record)
        calls.agree({"this process": computing()})
        self.reporter.watch(None)
        self._compile_here(missing(scenes(self.plan.study)))
        self.reporter.begin_blocks(self._record, work_left)

        with closing(InThisProcess(calls.of_block, map(int, self.plan.order(pending)))) as here:
            self.pump(here)

    def _require_readable(self) -> None:
        try:
            description_of(open_shelf(self.cube_path))
        except OSError as error:
            # the run ends here, because every worker would fail to read the data and would be excluded
            raise unusable_data(error, "read") from error

    def _compile_here(self, lacking: list[Scene]) -> None:
        """Compile missing kernels in separate processes, before this process computes the study."""
        if not lacking:
            return
        self.reporter.enter("compiling", 0, len(lacking))
        # if a compilation fails, the first block compiles the kernel again and reports the error
        with suppress(RuntimeError), closing(compile_apart(lacking, core_count())) as compiled:
            for done, _ in enumerate(compiled, 1):
                self.reporter.enter("compiling", done, len(lacking))
                if self.stopping:
                    return

    @property
    def stopping(self) -> bool:
        """Whether no more blocks may start."""
        return self._stop.is_set() or self.lease.over or self._spent

    @property
    def _spent(self) -> bool:
        return self.results.spent_seconds >= self.limits.budget_seconds

    def _budget_spent(self) -> str | None:
        """Return a message if the budget is spent, and None otherwise."""
        if not self._spent:
            return None
        hours = self.limits.budget_seconds / SECONDS_PER_HOUR
        return f"the budget of {hours:.3g} core hours is spent; {self.results.left()}"

    def pump(self, window: "Window | InThisProcess") -> None:
        """Send blocks and record their results until no block is left or the run stops."""
        while not self.stopping:
            self._require_room()
            window.fill()
            if window.empty:
                return
            self.reporter.report_workers()
            self.results.keep(window.collect(POLL_SECONDS))
            self.reporter.report()
        for ended in window.drain(GRACE_SECONDS):
            self.results.keep([ended])
            self.reporter.report()

    def _require_room(self) -> None:
        trouble = self._store.trouble()
        if trouble is not None:
            raise Outage(trouble)
