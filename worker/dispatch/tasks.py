"""Sends tasks to named workers of a cluster, and observes their end. Only this module uses Dask's client."""

import pickle
import queue
import time
import uuid
from collections.abc import Callable, Collection, Iterator
from contextlib import suppress
from typing import Any

from distributed import Client, Future
from distributed.protocol.pickle import dumps

from damperlab.worker.outcomes import Outage, SchedulerLost, asking_the_cluster

ANSWER_SECONDS = 30.0
"""Longest time for an answer of an existing scheduler."""
FETCH_SECONDS = 1.0
"""Longest time to fetch an answer of a few bytes from its worker, before it is checked whether the answer still exists.
"""

Call = tuple[Any, ...]
"""A function and its arguments."""


class Tasks:
    """Tasks at the workers of a cluster.

    Parameters
    ----------
    client : Client
        Of the cluster.
    priority : int
        Of two tasks that wait at a worker, the one with the higher priority starts first.
    """

    def __init__(self, client: Client, priority: int) -> None:
        self._client = client
        self._priority = priority
        self._ended: queue.SimpleQueue[str] = queue.SimpleQueue()
        self._run = uuid.uuid4().hex[:8]
        self._sent = 0

    def key(self, what: str) -> str:
        """Give a key that no task has had, because for a used key the scheduler would return the earlier result."""
        key = f"{what}-{self._run}-{self._sent}"
        self._sent += 1
        return key

    def send(self, key: str, address: str, call: Call) -> Future:
        """Send a call to one particular worker.

        Parameters
        ----------
        key : str
            Key of the task.
        address : str
            The worker.
        call : tuple
            The function, and its arguments.

        Raises
        ------
        SchedulerLost
            The scheduler is lost.
        """
        with asking_the_cluster(self._client):
            future = self._client.submit(
                *sealed(*call),
                key=key,
                pure=False,
                workers=[address],
                allow_other_workers=False,
                retries=0,
                priority=self._priority,
            )
        future.add_done_callback(lambda future: self._ended.put(future.key))
        return future

    def ended(self, wait_seconds: float) -> Iterator[str]:
        """Give the keys of tasks that have ended since the last call, in the order of their end.

        Parameters
        ----------
        wait_seconds : float
            Longest wait for the first key, and for the call as a whole [s]. Further keys are left to the next call.
        """
        block = True
        deadline = time.monotonic() + wait_seconds
        while block or time.monotonic() < deadline:
            try:
                yield self._ended.get(block, wait_seconds)
            except queue.Empty:
                return
            block = False

    def again(self, key: str) -> None:
        """Give a key again in a later call."""
        self._ended.put(key)

    def drop(self, futures: list[Future], reason: str) -> None:
        """Remove tasks from the cluster; a lost scheduler has none."""
        if futures:
            with suppress(Outage), asking_the_cluster(self._client):
                self._client.cancel(futures, reason=reason)

    def workers(self) -> tuple[dict[str, int], Collection[str]]:
        """Give the present workers, by address with their threads, and those that accept tasks.

        Raises
        ------
        SchedulerLost
            The scheduler is lost, or does not answer.
        """
        self.require_scheduler()
        with asking_the_cluster(self._client):
            ask = self._client.scheduler
            threads = self._client.sync(ask.ncores, callback_timeout=ANSWER_SECONDS)
            running = self._client.sync(ask.ncores_running, callback_timeout=ANSWER_SECONDS)
        return threads, running

    def require_scheduler(self) -> None:
        """Raise `SchedulerLost` if it is lost."""
        if self._client.status != "running":
            raise SchedulerLost


class _Call:
    """A pickled call: unpickling it makes the call and gives its value."""

    def __init__(self, function: Callable[..., Any], arguments: tuple[Any, ...]) -> None:
        self._what = function, arguments

    def __reduce__(self) -> tuple[Callable[..., Any], tuple[Any, ...]]:
        return self._what


def sealed(function: Callable[..., Any], *arguments: Any) -> tuple[Callable[[bytes], Any], bytes]:
    """Pack a function and its arguments so that only the executing worker unpickles them.

    A Dask scheduler unpickles tasks, and so loads the modules of their functions and arguments. Loading the
    solver and the stores would double the time that the scheduler needs to start. Of a sealed call, it sees only bytes.
    Workers need nothing from this module, so a worker with another version of damperlab can still report its version.

    Parameters
    ----------
    function : callable
        The function. It is sent by name if it can be imported; otherwise it is pickled as Dask pickles its own calls.
    *arguments
        Its arguments.
    """
    return pickle.loads, dumps(_Call(function, arguments))
