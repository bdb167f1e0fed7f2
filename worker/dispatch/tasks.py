"""Sends tasks to particular workers of a Dask cluster, and reports which tasks have ended."""

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
"""Longest wait for an answer of a connected scheduler [s]."""
FETCH_SECONDS = 1.0
"""Longest wait for a result of a few bytes from a worker [s]. A worker that takes longer may have left."""

Call = tuple[Any, ...]
"""A function and its arguments."""


class Tasks:
    """Sends tasks to the workers of a cluster, and collects the keys of ended tasks.

    Parameters
    ----------
    client : Client
        Client of the cluster.
    priority : int
        Priority of the tasks. If several tasks wait at a worker, the task with the highest priority starts first.
    """

    def __init__(self, client: Client, priority: int) -> None:
        self._client = client
        self._priority = priority
        self._ended: queue.SimpleQueue[str] = queue.SimpleQueue()
        self._run = uuid.uuid4().hex[:8]
        self._sent = 0

    def key(self, what: str) -> str:
        """Return a new, unique key for a task. For a used key, the scheduler would return the earlier result."""
        key = f"{what}-{self._run}-{self._sent}"
        self._sent += 1
        return key

    def send(self, key: str, address: str, call: Call) -> Future:
        """Send a function call to the worker at an address; raise `SchedulerLost` if the connection is lost."""
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
        """Yield the keys of tasks that have ended since the last call, in the order in which they ended.

        Parameters
        ----------
        wait_seconds : float
            Longest wait for the first key [s]. After this time, the remaining keys are left to the next call.
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
        """Put a key back, so that `ended` yields it again."""
        self._ended.put(key)

    def drop(self, futures: list[Future], reason: str) -> None:
        """Cancel tasks. Errors of a lost scheduler are ignored, because its tasks are lost too."""
        if futures:
            with suppress(Outage), asking_the_cluster(self._client):
                self._client.cancel(futures, reason=reason)

    def workers(self) -> tuple[dict[str, int], Collection[str]]:
        """Return the number of threads of each present worker by address, and the addresses of the workers that accept
        tasks.

        Raises
        ------
        SchedulerLost
            If the connection to the scheduler is lost, or the scheduler does not answer.
        """
        self.require_scheduler()
        with asking_the_cluster(self._client):
            ask = self._client.scheduler
            threads = self._client.sync(ask.ncores, callback_timeout=ANSWER_SECONDS)
            running = self._client.sync(ask.ncores_running, callback_timeout=ANSWER_SECONDS)
        return threads, running

    def require_scheduler(self) -> None:
        """Raise `SchedulerLost` if the connection to the scheduler is lost."""
        if self._client.status != "running":
            raise SchedulerLost


class _Call:
    """A function call that can be pickled. Unpickling executes the call and returns its result."""

    def __init__(self, function: Callable[..., Any], arguments: tuple[Any, ...]) -> None:
        self._what = function, arguments

    def __reduce__(self) -> tuple[Callable[..., Any], tuple[Any, ...]]:
        return self._what


def sealed(function: Callable[..., Any], *arguments: Any) -> tuple[Callable[[bytes], Any], bytes]:
    """Pack a function and its arguments so that only the worker that executes the call unpickles them.

    A Dask scheduler unpickles tasks, and so imports the modules of their functions and arguments. Importing the solver
    and the stores would double the time that the scheduler needs to start. A worker unpacks a call with the standard
    library alone, so a worker with another version of damperlab can still report its version.

    A function that can be imported is sent by name; any other function is pickled by value. The result has
    two parts: a function that unpacks and executes the call, and the argument of this function.
    """
    return pickle.loads, dumps(_Call(function, arguments))
