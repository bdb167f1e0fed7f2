"""The one cluster that all studies of a service share: opened when first needed, replaced when it is lost."""

import threading
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager

from distributed import Client

from damperlab.worker.cluster import connect


class SharedCluster:
    """A cluster for many threads.

    Parameters
    ----------
    workers : int, optional
        Worker processes of an own cluster; by default one per core.
    scheduler : str, optional
        Address of a Dask scheduler to use instead.
    """

    def __init__(self, workers: int | None, scheduler: str | None) -> None:
        self._workers = workers
        self._scheduler = scheduler
        self._lock = threading.Lock()
        self._stack: ExitStack | None = None
        self._client: Client | None = None

    @property
    def state(self) -> str:
        """One of idle (no study has needed it yet), running, lost (the scheduler has gone away)."""
        client = self._client
        if client is None:
            return "idle"
        return "running" if client.status == "running" else "lost"

    @contextmanager
    def borrow(self) -> Iterator[Client]:
        """Lend the client; the cluster stays when the borrower is done.

        Raises
        ------
        ClusterUnusable
            There is no cluster to compute on.
        """
        with self._lock:
            if self.state == "lost":
                self._close()
            if self._client is None:
                stack = ExitStack()
                self._client = stack.enter_context(connect(workers=self._workers, scheduler=self._scheduler))
                self._stack = stack
            client = self._client
        yield client

    def close(self) -> None:
        """End the cluster, if it is the service's own, and the connection to it."""
        with self._lock:
            self._close()

    def _close(self) -> None:
        stack, self._stack, self._client = self._stack, None, None
        if stack is not None:
            stack.close()
