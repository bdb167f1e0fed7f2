"""The cluster that all studies of a service share, opened at the first use and replaced when it is lost."""

import threading
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, ExitStack, contextmanager
from typing import TYPE_CHECKING, Literal

from damperlab.service.settings import Settings
from damperlab.worker.cluster.batch import Jobs

if TYPE_CHECKING:
    from distributed import Client

MOST_JOBS = 16
"""Default limit on the number of jobs in a batch system."""


def open_cluster(settings: Settings, wanted: Callable[[], int]) -> "AbstractContextManager[Client]":
    """Open the cluster that the settings describe, and close it at the end of the context.

    Parameters
    ----------
    settings : Settings
        Settings of the service, or of a command.
    wanted : callable
        Returns the number of workers that have work. A batch system starts this number of jobs, within limits.

    Raises
    ------
    ClusterUnusable
        If the cluster cannot be opened.
    """
    # both modules import Dask, and a service that computes nothing needs no Dask
    if settings.cluster is None:
        from damperlab.worker.cluster.cluster import connect

        return connect(settings.workers, settings.scheduler)
    from damperlab.worker.cluster.jobs import hire

    most = MOST_JOBS if settings.workers is None else settings.workers
    jobs = Jobs(most, settings.job_seconds, settings.job_memory_bytes, settings.job_options)
    return hire(jobs, settings.cluster_host, settings.data_dir / "jobs", wanted)


ClusterState = Literal["idle", "running", "lost"]
"""State of a shared cluster."""


class SharedCluster:
    """A cluster that is shared by several threads.

    Parameters
    ----------
    opened : callable
        Opens the cluster, as `open_cluster` does.
    """

    def __init__(self, opened: "Callable[[], AbstractContextManager[Client]]") -> None:
        self._opened = opened
        self._lock = threading.Lock()
        self._stack: ExitStack | None = None
        self._client: Client | None = None

    @property
    def state(self) -> ClusterState:
        """State of the cluster: "idle" before the first use, "running", or "lost" if the scheduler is lost."""
        client = self._client
        if client is None:
            return "idle"
        return "running" if client.status == "running" else "lost"

    @contextmanager
    def borrow(self) -> "Iterator[Client]":
        """Open the cluster if necessary, and yield a client. The cluster stays open after the context.

        Raises
        ------
        ClusterUnusable
            If the cluster cannot be opened.
        """
        with self._lock:
            if self.state == "lost":
                self._close()
            if self._client is None:
                stack = ExitStack()
                self._client = stack.enter_context(self._opened())
                self._stack = stack
            client = self._client
        yield client

    def close(self) -> None:
        """Close the connection to the cluster. Stop the cluster if the service has started it."""
        with self._lock:
            self._close()

    def _close(self) -> None:
        stack, self._stack, self._client = self._stack, None, None
        if stack is not None:
            stack.close()
