"""A cluster whose workers are jobs of Slurm. The number of jobs depends on the remaining work."""

import logging
import shutil
import socket
import threading
import time
import uuid
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from distributed import Client

from damperlab.worker.cluster.batch import SHORTEST_SECONDS, Jobs, Place, cancel, script, submit, worker_name
from damperlab.worker.cluster.certificates import make_certificates, security
from damperlab.worker.cluster.cluster import closed_where_lost, without_workers
from damperlab.worker.outcomes import ClusterUnusable

LOOK_SECONDS = 2.0
"""Interval between checks of the present workers [s]."""
AGAIN_SECONDS = 10.0
"""Shortest interval between submissions [s], which matters if all jobs end immediately."""

_log = logging.getLogger(__name__)


class Hired:
    """The submitted jobs of one cluster.

    A job counts as ended when its worker has left the cluster, so Slurm is not queried.

    Parameters
    ----------
    jobs : Jobs
        Settings of the jobs.
    place : Place
        Address of the scheduler, and folder of the certificates.
    """

    def __init__(self, jobs: Jobs, place: Place) -> None:
        self._jobs = jobs
        self._place = place
        self._submitted: dict[str, set[str]] = {}
        self._came: set[str] = set()
        self._gone: set[str] = set()
        self._again = 0.0

    def look(self, wanted: int, present: set[str], now: float) -> None:
        """Submit the missing jobs if `AGAIN_SECONDS` have passed since the last submission.

        Parameters
        ----------
        wanted : int
            Number of workers for which there is work.
        present : set of str
            Names of the present workers.
        now : float
            Time of the caller's clock [s].

        Raises
        ------
        ClusterUnusable
            If the command of Slurm is missing or fails.
        """
        names = set().union(*self._submitted.values())
        self._came |= present & names
        self._gone = self._came - present
        missing = min(self._jobs.most, wanted) - len(names - self._gone)
        if missing > 0 and now >= self._again:
            self._again = now + AGAIN_SECONDS
            self._submit(missing)

    def dismiss(self) -> None:
        """Cancel all jobs that have not ended."""
        for job, names in self._submitted.items():
            if names - self._gone:
                # the command fails if the jobs have ended in the meantime
                with suppress(ClusterUnusable):
                    cancel(job)

    def _submit(self, count: int) -> None:
        number = len(self._submitted) + 1
        job = submit(script(self._jobs, self._place, number, count))
        self._submitted[job] = {worker_name(number, task) for task in range(1, count + 1)}
        _log.info("%d jobs submitted as %s", count, job)


@contextmanager
def hire(jobs: Jobs, host: str | None, folder: Path, wanted: Callable[[], int]) -> Iterator[Client]:
    """Start a cluster whose workers are jobs of Slurm. The scheduler runs on this machine.

    At the end of the context, the scheduler is closed and the jobs are cancelled.

    Parameters
    ----------
    jobs : Jobs
        Settings of the jobs.
    host : str, optional
        Name or address at which the jobs reach this machine; by default its host name.
    folder : Path
        Folder that this machine shares with the machines of the jobs. The certificates and the jobs' output are written
        to this folder.
    wanted : callable
        Returns the number of workers for which there is work. The function is also called from another thread.

    Yields
    ------
    Client
        Client of the cluster. Workers join the cluster when Slurm starts their jobs.

    Raises
    ------
    ClusterUnusable
        If the first jobs cannot be submitted, or the settings of the jobs are not usable.
    """
    _check(jobs, folder)
    place = folder / f"{time.strftime('%Y%m%dT%H%M%S')}-{uuid.uuid4().hex[:8]}"
    tls = place / "tls"
    tls.mkdir(parents=True, mode=0o700)
    try:
        make_certificates(tls)
        shown = security(tls)
        with (
            without_workers(shown, host=socket.gethostname() if host is None else host) as cluster,
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
        # the certificates are no longer needed; the folder remains if it contains output of jobs
        shutil.rmtree(tls, ignore_errors=True)
        with suppress(OSError):
            place.rmdir()


def _keep(client: Client, hired: Hired, wanted: Callable[[], int], stop: threading.Event) -> None:
    while not stop.wait(LOOK_SECONDS):
        try:
            known = client.sync(client.scheduler.identity, n_workers=-1)["workers"].values()
            hired.look(wanted(), {str(one["name"]) for one in known}, time.monotonic())
        # the scheduler, the catalogue or Slurm may answer at the next check
        except Exception as error:
            _log.warning("no jobs can be submitted now: %s", error)


def _check(jobs: Jobs, folder: Path) -> None:
    if jobs.wall_seconds < SHORTEST_SECONDS:
        raise ClusterUnusable(
            "job_seconds",
            f"{jobs.wall_seconds:g}",
            f"{SHORTEST_SECONDS:g} or more",
            "give jobs time to start, to compute and to leave",
        )
    if any(sign.isspace() for sign in str(folder)):
        raise ClusterUnusable(
            "data_dir",
            repr(str(folder)),
            "a path without blanks",
            "move the data folder: Slurm accepts no blank in the path of a job's output",
        )
