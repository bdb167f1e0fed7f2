"""Commands that compute a study here, on an embedded Dask cluster or a scheduler elsewhere: run, resume."""

import signal
import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, ExitStack, closing, contextmanager, suppress
from dataclasses import dataclass, replace
from datetime import datetime
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, Annotated

import typer

from damperlab.service.cli.failures import FAILED
from damperlab.service.cli.options import (
    QUEUE_SECONDS,
    WAIT_SECONDS,
    AsJson,
    Budget,
    Cluster,
    DataDir,
    Priority,
    QuotaBytes,
    Scheduler,
    StoreAddress,
    StudyId,
    Until,
    Wait,
    Workers,
    check_cluster,
    read_time,
)
from damperlab.service.cli.output import duration, note, print_json, say, working
from damperlab.service.cli.progress import StudyProgress, preparation
from damperlab.service.cli.store import data_folder, label, open_store, settings_of
from damperlab.service.cli.studies import summary

if TYPE_CHECKING:
    from distributed import Client

    from damperlab.studies.kind import AnyStudy
    from damperlab.studies.store.record import Record
    from damperlab.studies.store.store import Store
    from damperlab.studies.vocabulary import BatchSystem

BYTES_PER_MEGABYTE = 1e6
HERE_SECONDS = 0.5
"""Expected work below which no cluster is started: its processes take longer than that to start."""
WATCH_SECONDS = 0.5
"""Between two looks at a study that another process runs."""


def run(
    study: Annotated[
        str,
        typer.Argument(
            metavar="STUDY",
            help="A .json or .yaml file, or a named study such as figure-11 (`damperlab studies --named` lists them).",
        ),
    ],
    data_dir: DataDir = None,
    workers: Workers = None,
    scheduler: Scheduler = None,
    cluster: Cluster = None,
    wait: Wait = None,
    place: StoreAddress = None,
    quota: QuotaBytes = None,
    budget: Budget = None,
    until: Until = None,
    priority: Priority = 0,
    dry_run: Annotated[
        bool,
        typer.Option(
            "--dry-run", help="Print the size of the study and its expected run time; store nothing."
        ),
    ] = False,
    reuse: Annotated[
        bool, typer.Option("--reuse/--no-reuse", help="Reuse points already computed by earlier studies.")
    ] = True,
    as_json: AsJson = False,
) -> None:
    """Compute a study and store it; points that are stored already are not computed again."""
    check_cluster(workers, scheduler, cluster)
    ends = read_time(until)
    from damperlab.studies.ground.shelf import Shelf
    from damperlab.studies.reading import read_study

    asked = read_study(study, Shelf(data_folder(data_dir)))
    if dry_run:
        _print_size(asked, data_dir, as_json)
        return
    store = open_store(data_dir, store=place, quota_bytes=quota)
    reuse = reuse and settings_of(data_dir).reuse
    record = find_or_submit(store, asked, reuse, priority=priority)
    terms = terms_of(store, record, workers, cluster, wait)
    finish(store, record, workers, scheduler, as_json, replace(terms, budget_hours=budget, ends=ends))


def resume(
    study: StudyId,
    data_dir: DataDir = None,
    workers: Workers = None,
    scheduler: Scheduler = None,
    cluster: Cluster = None,
    wait: Wait = None,
    budget: Budget = None,
    until: Until = None,
    as_json: AsJson = False,
) -> None:
    """Continue a study that was cancelled, was interrupted or has failed; only missing points are computed."""
    check_cluster(workers, scheduler, cluster)
    ends = read_time(until)
    store = open_store(data_dir)
    record = store.find(study)
    terms = terms_of(store, record, workers, cluster, wait)
    finish(store, record, workers, scheduler, as_json, replace(terms, budget_hours=budget, ends=ends))


def find_or_submit(
    store: "Store",
    asked: "AnyStudy",
    reuse: bool,
    more: "Mapping[str, str] | None" = None,
    priority: int = 0,
) -> "Record":
    """Find a study in the store, or put it there.

    Parameters
    ----------
    store : Store
        Where.
    asked : AnyStudy
        The study.
    reuse : bool
        Reuse points already computed by earlier studies.
    more : mapping, optional
        Put beside the provenance of a new study.
    priority : int
        Of a new study.
    """
    known = store.newest(asked.digest)
    if known is not None:
        return known
    # a plan, with the cost model behind it, is needed for a new one alone
    from damperlab.studies.plan import make_plan
    from damperlab.worker.cost import seconds_per_point
    from damperlab.worker.provenance import provenance

    with working("Planning"):
        plan = make_plan(asked, seconds_per_point)
        record, _ = store.submit(asked, plan, provenance() | dict(more or {}), reuse=reuse, priority=priority)
    return record


@dataclass(frozen=True)
class Terms:
    """How far a command goes to compute a study.

    Parameters
    ----------
    client : callable, optional
        Gives a client of a cluster that is not made for this study alone, or is no cluster of this machine.
    wait_seconds : float
        How long to wait while no worker can compute.
    here_seconds : float, optional
        Expected work up to which no cluster is used; by default `HERE_SECONDS` where none is named, else none.
    budget_hours : float, optional
        Core hours in kernels after which it stops, to be resumed.
    ends : datetime, optional
        When it stops, to be resumed.
    """

    client: "Callable[[], AbstractContextManager[Client]] | None" = None
    wait_seconds: float = WAIT_SECONDS
    here_seconds: float | None = None
    budget_hours: float | None = None
    ends: datetime | None = None


def terms_of(
    store: "Store",
    record: "Record",
    workers: int | None,
    cluster: "BatchSystem | None",
    wait: float | None,
) -> Terms:
    """Read the options that say where a study is computed."""
    if cluster is None:
        return Terms(wait_seconds=WAIT_SECONDS if wait is None else wait)
    from damperlab.service.cluster import opening

    settings = settings_of(store.data_dir, workers=workers, cluster=cluster)

    def left() -> int:
        now = store.find(record.id)
        return now.blocks_total - now.blocks_done

    note(f"Workers are jobs of {cluster}; what they print is kept under {settings.data_dir / 'jobs'}.")
    wait_seconds = QUEUE_SECONDS if wait is None else wait
    return Terms(opening(settings, left), wait_seconds)


def finish(
    store: "Store",
    record: "Record",
    workers: int | None,
    scheduler: str | None,
    as_json: bool,
    terms: Terms = Terms(),
) -> None:
    """Compute what is missing, if anything is, and print the record."""
    if record.state == "done":
        store.pending(record.id)  # a lost done-mark is told, and not taken for an end
        note(f"Study {label(record)} is complete; nothing was computed.")
        if record.outdated:
            note(
                f"An earlier solver computed it. To compute it with today's and keep both: damperlab recompute {record.id}"
            )
    else:
        record = compute(store, record, workers, scheduler, terms)
    if as_json:
        print_json(record.document())
    else:
        say(summary(record))
    if record.state != "done":
        left = record.points_total - record.points_done
        note(
            f"damperlab: study {label(record)} is {record.state} with {left} points left; computed points are kept. "
            f"Continue with: damperlab resume {record.id} --data-dir {store.data_dir}"
        )
        raise typer.Exit(FAILED)


def compute(
    store: "Store",
    record: "Record",
    workers: int | None,
    scheduler: str | None,
    terms: Terms = Terms(),
) -> "Record":
    """Run a study here or, while another process does, watch it.

    Parameters
    ----------
    store : Store
        Where the study is.
    record : Record
        The study.
    workers, scheduler : optional
        As in `damperlab.worker.cluster.connect`.
    terms : Terms
        How far to go.

    Returns
    -------
    Record
        As it ended.
    """
    from damperlab.studies.store.faults import StudyBusy
    from damperlab.worker.runner import SECONDS_PER_HOUR, run_study

    def own() -> "AbstractContextManager[Client]":
        # loaded only where a cluster is needed: it is most of what a tiny study would cost
        from damperlab.worker.cluster import connect

        return connect(workers=workers, scheduler=scheduler)

    here_seconds = terms.here_seconds
    if here_seconds is None:
        no_cluster_named = terms.client is None and workers is None and scheduler is None
        here_seconds = HERE_SECONDS if no_cluster_named else 0.0
    with (
        _stop_on_signals() as stop,
        _stop_at(terms.ends, stop) as over,
        StudyProgress(record.name or record.id, record.points_total) as progress,
    ):
        while True:
            try:
                ended = run_study(
                    store,
                    record.id,
                    terms.client or own,
                    lambda now: progress.update(
                        now.points_done,
                        now.points_failed,
                        now.points_per_second,
                        now.seconds_left,
                        preparation(now.phase, now.phase_done, now.phase_total),
                    ),
                    stop,
                    # asked to go on with what it is now; whoever cancels it meanwhile is heard
                    only_from=("queued", "running", record.state),
                    here_seconds=here_seconds,
                    wait_seconds=terms.wait_seconds,
                    budget_seconds=None
                    if terms.budget_hours is None
                    else terms.budget_hours * SECONDS_PER_HOUR,
                )
                return _told_of_the_time(store, ended, terms.ends) if over.is_set() else ended
            except StudyBusy as error:
                note(f"{error} Following it until it ends.")
                record = _watch(store, record.id, progress, stop)
                if record.ended or stop.is_set():
                    return record


def _watch(store: "Store", study_id: str, progress: StudyProgress, stop: threading.Event) -> "Record":
    """Follow a study that another process runs until it ends, its claim lapses, or this process shall stop."""
    while True:
        record = store.find(study_id)
        before = preparation(record.phase, record.phase_done, record.phase_total)
        progress.update(record.points_done, record.points_failed, None, record.seconds_left, before)
        if record.ended or record.owner is None or stop.wait(WATCH_SECONDS):
            return record


@contextmanager
def _stop_on_signals() -> Iterator[threading.Event]:
    """Turn the first Ctrl-C or termination request into a stop that keeps what is done; the second one ends at once."""
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
    """Stop at a time as a signal would; gives what is set where that has happened."""
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
    """Keep with a study that it was stopped at its time."""
    if record.state != "cancelled" or ends is None:
        return record
    left = record.blocks_total - record.blocks_done
    message = (
        f"it was to run until {ends:%Y-%m-%d %H:%M:%S}; {record.blocks_done} of {record.blocks_total} blocks are kept, "
        f"resume computes the other {left}"
    )
    return store.set_state(record.id, "cancelled", message, only_from=("cancelled",))


def _print_size(asked: "AnyStudy", data_dir: Path | None, as_json: bool) -> None:
    """Print what POST /studies?dry_run=true answers."""
    from damperlab.service.estimates import estimate_document
    from damperlab.studies.plan import make_plan
    from damperlab.studies.store.catalogue import SQLITE_FILE
    from damperlab.studies.store.faults import StoreFault
    from damperlab.worker.cost import seconds_per_point

    with working("Planning"), ExitStack() as stack:
        store = None
        if (data_folder(data_dir) / SQLITE_FILE).is_file() or settings_of(data_dir).catalogue is not None:
            # earlier studies tell what points take, where they can be asked; nothing is made for the sake of it
            with suppress(StoreFault):
                store = stack.enter_context(closing(open_store(data_dir)))
        size = estimate_document(asked, make_plan(asked, seconds_per_point), store)
    if as_json:
        print_json(size)
    else:
        compiling = size["compiling_seconds"]
        first = f", {duration(compiling)} of them for kernels that are compiled first" if compiling else ""
        say(
            f"{asked.name or 'The study'}: {size['points']} points in {size['blocks']} blocks, "
            f"{size['bytes'] / BYTES_PER_MEGABYTE:.3g} MB before compression, "
            f"about {duration(size['seconds'])} of one core{first} "
            f"(between {duration(size['seconds_low'])} and {duration(size['seconds_high'])}). Nothing was stored."
        )
