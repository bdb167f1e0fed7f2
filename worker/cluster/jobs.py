"""A cluster whose workers are jobs of a batch system. Their number follows the work, between two limits."""

import logging
import shutil
import socket
import threading
import time
import uuid
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from distributed import Client, SpecCluster

from damperlab.studies.faults import Fault
from damperlab.worker.cluster.batch import SHORTEST_SECONDS, Jobs, Place, cancel, script, submit, worker_name
from damperlab.worker.cluster.certificates import make_certificates, security
from damperlab.worker.cluster.cluster import SCHEDULER_CONFIG, closed_where_lost
from damperlab.worker.cluster.scheduler import SchedulerProcess
from damperlab.worker.outcomes import ClusterUnusable

LOOK_SECONDS = 2.0
"""Interval between checks for arrived and departed workers."""
AGAIN_SECONDS = 10.0
"""Interval between submissions, so that jobs which end immediately do not flood a batch system."""

_log = logging.getLogger(__name__)


class Hired:
    """The jobs of one cluster.

    A job waits, works or has ended. A job has ended once its worker has come and gone, so the batch system need not be
    queried often.

    Parameters
    ----------
    jobs : Jobs
        The requests to the batch system.
    place : Place
        Where the workers find their cluster.
    """

    def __init__(self, jobs: Jobs, place: Place) -> None:
        self._jobs = jobs
        self._place = place
        self._submitted: dict[str, set[str]] = {}
        self._came: set[str] = set()
        self._gone: set[str] = set()
        self._lasting: set[str] = set()
        self._again = 0.0

    def look(self, wanted: int, present: set[str], now: float) -> None:
        """Submit missing jobs.

        Parameters
        ----------
        wanted : int
            Number of workers that could be busy.
        present : set of str
            Names of the present workers.
        now : float
            Time by the caller's clock [s].

        Raises
        ------
        ClusterUnusable
            The batch system is missing, or refuses.
        """
        names = set().union(*self._submitted.values())
        self._came |= present & names
        self._gone = self._came - present
        alive = names - self._gone
        lasting = len(self._lasting - self._gone)
        most = self._jobs.most
        if now < self._again:
            return
        for count, idle in (
            (self._jobs.fewest - lasting, True),
            (min(most, wanted) - max(len(alive), self._jobs.fewest), False),
        ):
            if count > 0:
                self._again = now + AGAIN_SECONDS
                self._submit(count, idle)

    def dismiss(self) -> None:
        """Cancel all jobs that may still wait or run."""
        for job, names in self._submitted.items():
            if names - self._gone:
                # jobs that have ended meanwhile cannot be cancelled
                with suppress(ClusterUnusable):
                    cancel(self._jobs.system, job)

    def _submit(self, count: int, idle: bool) -> None:
        number = len(self._submitted) + 1
        job = submit(self._jobs.system, script(self._jobs, self._place, number, count, idle))
        names = {worker_name(number, task) for task in range(1, count + 1)}
        self._submitted[job] = names
        if idle:
            self._lasting |= names
        _log.info("%d jobs submitted to %s as %s", count, self._jobs.system, job)


@contextmanager
def hire(jobs: Jobs, host: str | None, folder: Path, wanted: Callable[[], int]) -> Iterator[Client]:
    """Client of a cluster with a scheduler on this machine and jobs of a batch system as workers; all end with the
    context.

    Parameters
    ----------
    jobs : Jobs
        The requests to the batch system.
    host : str, optional
        Name or address of this machine for the jobs; by default its host name.
    folder : Path
        A folder shared with the jobs' machines, for certificates and the jobs' output.
    wanted : callable
        Gives how many workers could be busy; called from another thread.

    Yields
    ------
    Client
        Not the process's default client. Its workers join as the batch system starts jobs.

    Raises
    ------
    ClusterUnusable
        The first jobs cannot be submitted, or the requested jobs could not work.
    """
    _check(jobs, folder)
    place = folder / f"{time.strftime('%Y%m%dT%H%M%S')}-{uuid.uuid4().hex[:8]}"
    tls = place / "tls"
    tls.mkdir(parents=True, mode=0o700)
    try:
        make_certificates(tls)
        shown = security(tls)
        address = socket.gethostname() if host is None else host
        options = {"security": shown, "config": SCHEDULER_CONFIG, "host": address}
        with (
            SpecCluster(
                workers={},
                scheduler={"cls": SchedulerProcess, "options": options},
                security=shown,
                silence_logs=logging.CRITICAL,
            ) as cluster,
            closed_where_lost(cluster),
            Client(cluster, security=shown, set_as_default=False) as client,
        ):
            hired = Hired(jobs, Place(cluster.scheduler_address, tls))
            stop = threading.Event()
            thread = threading.Thread(target=_keep, args=(client, hired, wanted, stop), daemon=True)
            try:
                hired.look(wanted(), set(), time.monotonic())
                thread.start()
                yield client
            finally:
                stop.set()
                if thread.is_alive():
                    thread.join()
                hired.dismiss()
    finally:
        # jobs that start later find no scheduler; the output of the jobs is kept
        shutil.rmtree(tls, ignore_errors=True)
        with suppress(OSError):
            place.rmdir()


def _keep(client: Client, hired: Hired, wanted: Callable[[], int], stop: threading.Event) -> None:
    while not stop.wait(LOOK_SECONDS):
        try:
            known = client.sync(client.scheduler.identity, n_workers=-1)["workers"].values()
            hired.look(wanted(), {str(one["name"]) for one in known}, time.monotonic())
        # a missing scheduler, catalogue or batch system may be back at the next check
        except Exception as error:
            _log.warning("no jobs can be submitted now: %s", error)


def _check(jobs: Jobs, folder: Path) -> None:
    if jobs.wall_seconds < SHORTEST_SECONDS:
        raise ClusterUnusable(
            Fault(
                "job_seconds",
                f"{jobs.wall_seconds:g}",
                f"{SHORTEST_SECONDS:g} or more",
                "give jobs time to start, to compute and to leave",
            )
        )
    if jobs.fewest > jobs.most:
        raise ClusterUnusable(
            Fault(
                "workers_min",
                f"{jobs.fewest}, with at most {jobs.most} workers",
                f"at most {jobs.most}",
                "raise `workers`, or lower `workers_min`",
            )
        )
    if any(sign.isspace() for sign in str(folder)):
        raise ClusterUnusable(
            Fault(
                "data_dir",
                repr(str(folder)),
                "a path without blanks",
                "move the data folder: batch systems accept no blank in the path of a job's output",
            )
        )
