"""Options that say where to compute, and the class that computes studies for commands."""

import inspect
import math
import shlex
import signal
import threading
from collections.abc import Iterator, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager
from dataclasses import dataclass, fields
from datetime import datetime
from functools import wraps
from types import FrameType
from typing import TYPE_CHECKING, Any

from damperlab.service.cli.asked import Command, parameter, with_parameters
from damperlab.service.cli.failures import CommandFailed
from damperlab.service.cli.options import (
    QUEUE_SECONDS,
    WAIT_SECONDS,
    Cluster,
    Scheduler,
    Wait,
    Workers,
    check_cluster,
)
from damperlab.service.cli.output import duration, note
from damperlab.service.cli.progress import Shown, StudyProgress, preparation
from damperlab.service.cli.store import settings_of
from damperlab.studies.faults import sentence
from damperlab.studies.vocabulary import BatchSystem

if TYPE_CHECKING:
    from distributed import Client

    from damperlab.service.cluster import SharedCluster
    from damperlab.studies.store.record import Record
    from damperlab.studies.store.store import Store
    from damperlab.worker.run.progress import Progress

HERE_SECONDS = 0.5
"""Expected run time [s] below which no cluster is started, because starting the processes would take longer."""
WATCH_SECONDS = 0.5
"""Interval between checks of a study that another process runs."""
OPTIONS = {"workers": Workers, "scheduler": Scheduler, "cluster": Cluster, "wait": Wait}


@dataclass(frozen=True)
class Means:
    """Where a command computes: on this machine, with a Dask scheduler, or with jobs of a batch system.

    Parameters
    ----------
    workers : int, optional
        Number of processes on this machine, or largest number of jobs of a batch system.
    scheduler : str, optional
        Address of an existing Dask scheduler.
    cluster : str, optional
        Batch system whose jobs are the workers.
    wait : float, optional
        Longest wait while no worker can compute [s].

    Raises
    ------
    BadParameter
        If two options exclude each other.
    """

    workers: int | None = None
    scheduler: str | None = None
    cluster: BatchSystem | None = None
    wait: float | None = None

    def __post_init__(self) -> None:
        """Refuse options that exclude each other."""
        check_cluster(self.workers, self.scheduler, self.cluster)

    @property
    def elsewhere(self) -> bool:
        """Whether a scheduler or a batch system computes the studies, instead of this machine."""
        return self.scheduler is not None or self.cluster is not None

    @property
    def wait_seconds(self) -> float:
        """Longest wait while no worker can compute [s]."""
        if self.wait is not None:
            return self.wait
        return WAIT_SECONDS if self.cluster is None else QUEUE_SECONDS


def computes(command: Command) -> Command:
    """Replace a command's parameter of type `Means` by one option for each field of `Means`."""
    signature = inspect.signature(command, eval_str=True)
    names = [each.name for each in fields(Means)]
    parameters: list[inspect.Parameter] = []
    taken = ""
    for name, each in signature.parameters.items():
        if each.annotation is Means:
            taken = name
            parameters += [parameter(option, OPTIONS[option], None) for option in names]
        else:
            parameters.append(each.replace(kind=inspect.Parameter.KEYWORD_ONLY))

    @wraps(command)
    def computing(**given: Any) -> None:
        means = Means(**{name: given.pop(name) for name in names})
        command(**given, **{taken: means})

    return with_parameters(computing, parameters)


@dataclass(frozen=True)
class Limits:
    """Limits on the computation of a study. A stopped study can be resumed.

    Parameters
    ----------
    budget_hours : float, optional
        Computing time in core hours after which the study is stopped.
    ends : datetime, optional
        Time at which the study is stopped.
    """

    budget_hours: float | None = None
    ends: datetime | None = None


NO_LIMITS = Limits()


class Computer(ExitStack):
    """Computes studies one after the other. All studies share one cluster, which is started when first needed.

    Use the object as a context manager. A cluster that the object has started is closed at the end of the context.

    Parameters
    ----------
    store : Store
        The store.
    means : Means
        Where to compute.
    here_seconds : float, optional
        Expected run time [s] up to which a study is computed in this process; by default `HERE_SECONDS`. If a scheduler
        or a batch system is named, every study is computed there.
    """

    def __init__(self, store: "Store", means: Means, here_seconds: float | None = None) -> None:
        super().__init__()
        self.store = store
        self._means = means
        if here_seconds is None:
            here_seconds = HERE_SECONDS if means.workers is None else 0.0
        self._here_seconds = 0.0 if means.elsewhere else here_seconds
        self._cluster: SharedCluster | None = None
        self._now: str | None = None
        self._stopped = False

    def compute(
        self,
        record: "Record",
        limits: Limits = NO_LIMITS,
        shown: AbstractContextManager[Shown] | None = None,
    ) -> "Record":
        """Compute a study. While another process computes the study, follow its progress.

        After a request to stop, later studies are returned unchanged. This also holds for a request during the last
        block of a study.

        Parameters
        ----------
        record : Record
            The study.
        limits : Limits
            Limits on the computation.
        shown : context of Shown, optional
            Display of the progress; by default a bar.

        Returns
        -------
        Record
            The record of the study at the end.
        """
        from damperlab.studies.store.faults import StoreFault, StudyBusy, may_pass
        from damperlab.worker.run.runner import SECONDS_PER_HOUR, run_study

        if self._stopped:
            return record
        budget = math.inf if limits.budget_hours is None else limits.budget_hours * SECONDS_PER_HOUR
        self._now = record.id
        with (
            _stop_on_signals() as stop,
            _stop_at(limits.ends, stop) as over,
            shown or StudyProgress(record.name or record.id, record.points_total) as progress,
            self._noting(stop),
        ):
            while True:
                try:
                    ended = run_study(
                        self.store,
                        record.id,
                        self._lent,
                        _Told(progress),
                        stop,
                        # a study that was cancelled meanwhile is not resumed
                        only_from=("queued", "running", record.state),
                        here_seconds=self._here_seconds,
                        wait_seconds=self._means.wait_seconds,
                        return_seconds=self._means.wait_seconds,
                        budget_seconds=budget,
                    )
                    return _told_of_the_time(self.store, ended, limits.ends) if over.is_set() else ended
                except StudyBusy as error:
                    note(f"{error} This command follows the study until it ends.")
                    record = self._watch(record.id, progress, stop)
                    if record.ended or stop.is_set():
                        return record
                except StoreFault as error:
                    if not may_pass(error):
                        raise
                    raise CommandFailed(
                        "store-away",
                        f"{error} Computed points are kept. Continue with: {self.go_on(record.id)}",
                    ) from error

    def compute_together(self, records: "Sequence[Record]") -> set[str]:
        """Compute the short studies among `records` together, on all cores of this machine.

        Returns
        -------
        set of str
            Ids of the studies that are done.
        """
        from damperlab.worker.run.small_batch import compute_together

        short = [record.id for record in records if record.state == "queued" and self._is_short(record)]
        if self._stopped or not short:
            return set()
        with _stop_on_signals() as stop, self._noting(stop):
            return compute_together(self.store, short, stop.is_set)

    def _is_short(self, record: "Record") -> bool:
        """Whether this process computes a study without a cluster, with kernels that are compiled already."""
        from damperlab.studies.plan import plan_with_chunk
        from damperlab.studies.store.cube.definition import parse_stored
        from damperlab.worker.dispatch.cost_model import seconds_per_point
        from damperlab.worker.scenes import scenes
        from damperlab.worker.warm import missing

        study = parse_stored(record.definition, record.digest)
        plan = plan_with_chunk(study, record.chunk, seconds_per_point)
        return plan.seconds <= self._here_seconds and not missing(scenes(study))

    def go_on(self, study_id: str) -> str:
        """Return the command that continues a study."""
        means = self._means
        given = {"workers": means.workers, "scheduler": means.scheduler, "cluster": means.cluster}
        words = ["damperlab", "run", study_id, "--data-dir", str(self.store.data_dir)]
        for name, value in given.items():
            words += [] if value is None else [f"--{name}", str(value)]
        return shlex.join(words)

    @contextmanager
    def _noting(self, stop: threading.Event) -> "Iterator[None]":
        try:
            yield
        finally:
            self._stopped = stop.is_set()

    def _watch(self, study_id: str, progress: Shown, stop: threading.Event) -> "Record":
        """Follow a study that another process computes.

        The function returns when the study ends, when no process claims the study, or when a stop is requested.
        """
        while True:
            record = self.store.find(study_id)
            before = preparation(record.phase, record.phase_done, record.phase_total)
            progress.update(record.points_done, record.points_failed, None, record.seconds_left, before)
            if record.ended or record.owner is None or stop.wait(WATCH_SECONDS):
                return record

    @contextmanager
    def _lent(self) -> "Iterator[Client]":
        # without a cluster, this import would take most of the time of a tiny study
        from damperlab.service.cluster import SharedCluster

        if self._cluster is None:
            self._cluster = SharedCluster(self._opened)
            self.callback(self._cluster.close)
        with self._cluster.borrow() as client:
            yield client

    def _opened(self) -> "AbstractContextManager[Client]":
        means = self._means
        if means.cluster is None:
            from damperlab.worker.cluster.cluster import connect

            return connect(workers=means.workers, scheduler=means.scheduler)
        from damperlab.service.cluster import open_cluster

        settings = settings_of(self.store.data_dir, workers=means.workers, cluster=means.cluster)
        note(f"Workers are jobs of {means.cluster}; their output is kept under {settings.data_dir / 'jobs'}.")
        return open_cluster(settings, self._left)

    def _left(self) -> int:
        """Return the number of blocks of the present study that are not computed yet."""
        if self._now is None:
            return 0
        now = self.store.find(self._now)
        return now.blocks_total - now.blocks_done


class _Told:
    """Passes the progress of a run to the display. If the run waits, the reason is printed once."""

    def __init__(self, shown: Shown) -> None:
        self._shown = shown
        self._waits_for = ""

    def __call__(self, now: "Progress") -> None:
        """Show the present progress."""
        before = preparation(now.phase, now.phase_done, now.phase_total)
        if now.phase == "waiting":
            left = duration(now.gives_up_in)
            before = f"{'waiting' if now.waits_for else before}, giving up in {left}"
            if now.waits_for and not self._waits_for:
                note(f"{sentence(now.waits_for)} Waiting up to {left}.")
        self._waits_for = now.waits_for
        self._shown.update(
            now.points_done, now.points_failed, now.points_per_second, now.seconds_left, before
        )


@contextmanager
def _stop_on_signals() -> Iterator[threading.Event]:
    """Convert the first Ctrl-C or termination signal into a stop that keeps finished blocks.

    A second signal ends the process immediately.
    """
    stop = threading.Event()

    def ask(number: int, frame: FrameType | None) -> None:
        if stop.is_set():
            signal.signal(number, before[signal.Signals(number)])
            signal.raise_signal(number)
        stop.set()
        note("Stopping after the blocks that are running. Press Ctrl-C again to stop immediately.")

    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    for number in before:
        signal.signal(number, ask)
    try:
        yield stop
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


@contextmanager
def _stop_at(ends: datetime | None, stop: threading.Event) -> Iterator[threading.Event]:
    """Set `stop` at a given time. The yielded event is set at the same moment."""
    over = threading.Event()

    def end() -> None:
        over.set()
        stop.set()

    if ends is None:
        yield over
        return
    timer = threading.Timer(max(0.0, (ends - datetime.now(ends.tzinfo)).total_seconds()), end)
    timer.daemon = True
    timer.start()
    try:
        yield over
    finally:
        timer.cancel()


def _told_of_the_time(store: "Store", record: "Record", ends: datetime | None) -> "Record":
    """If a study was cancelled, record the event that its run was limited to the time `ends`."""
    if record.state != "cancelled" or ends is None:
        return record
    left = record.blocks_total - record.blocks_done
    message = (
        f"it was to run until {ends:%Y-%m-%d %H:%M:%S}; {record.blocks_done} of {record.blocks_total} "
        f"blocks are kept; a continued run computes the other {left}"
    )
    return store.set_state(record.id, "cancelled", message, only_from=("cancelled",))
