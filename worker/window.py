"""A bounded number of blocks at a cluster at any time; what fails is tried again."""

import queue
import time
import uuid
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass

from distributed import CancelledError, Client, Future, KilledWorker

from damperlab.studies.store.record import BlockOutcome
from damperlab.worker.outcomes import RETRIES, Failure, Outage, judged
from damperlab.worker.tasks import executing_keys

BLOCKS_PER_THREAD = 3
"""Blocks at the cluster per worker thread: one runs, one waits at the worker, one at the scheduler.

Fewer would let a worker idle while its answer travels; with all of a large study's blocks a scheduler crawls.
"""
LOOK_SECONDS = 2.0
"""Between two looks at how many threads the cluster has."""
WORKERLESS_SECONDS = 120.0
"""How long a cluster may be without a single worker before its study is put down."""
ANSWER_SECONDS = 30.0
"""How long a scheduler that is there may take to answer."""


@dataclass(frozen=True)
class _Attempt:
    index: int
    failures: int = 0
    suspect: bool = False


class Window:
    """Sends blocks to a cluster as it has room for them, and hands back what became of them.

    Parameters
    ----------
    client : Client
        Of the cluster.
    submit : callable
        Submits the block of the given index under the given task key.
    indices : iterator of int
        The blocks, in the order in which they shall run; drawn only as there is room.
    """

    def __init__(self, client: Client, submit: Callable[[int, str], Future], indices: Iterator[int]) -> None:
        self._client = client
        self._submit = submit
        self._fresh = indices
        self._again: deque[_Attempt] = deque()
        # A worker's death puts every block that it held under suspicion. Suspects run one at a time, so that
        # only the one that kills workers is tried too often, and not its innocent neighbours.
        self._suspects: deque[_Attempt] = deque()
        self._flying: dict[str, tuple[Future, _Attempt]] = {}
        self._ended: queue.SimpleQueue[str] = queue.SimpleQueue()
        self._run = uuid.uuid4().hex[:8]
        self._sent = 0
        self.threads = self._count_threads()
        self._looked = self._peopled = time.monotonic()

    @property
    def empty(self) -> bool:
        """Whether no block is at the cluster."""
        return not self._flying

    def fill(self) -> None:
        """Send blocks until every thread has enough.

        Raises
        ------
        Interrupted
            The scheduler does not answer, or there has been no worker for long.
        """
        self._look()
        while len(self._flying) < BLOCKS_PER_THREAD * max(1, self.threads):
            attempt = self._next()
            if attempt is None:
                return
            # No key is ever used twice: the scheduler would answer with what it remembers of the first use.
            key = f"block-{self._run}-{self._sent}"
            self._sent += 1
            future = self._submit(attempt.index, key)
            self._flying[key] = future, attempt
            future.add_done_callback(lambda future: self._ended.put(future.key))

    def collect(self, wait_seconds: float) -> Iterator[BlockOutcome | Failure]:
        """Hand back the blocks that have ended since the last call.

        Parameters
        ----------
        wait_seconds : float
            Longest wait for the first of them [s]; no more are taken once it is over, however many have ended,
            so that a large cluster is sent new blocks meanwhile.

        Yields
        ------
        BlockOutcome or Failure
            In the order of their end. A block that will be tried again is not among them.

        Raises
        ------
        Interrupted
            The scheduler is lost, a worker holds other code, or the data cannot be read or written.
        """
        block = True
        deadline = time.monotonic() + wait_seconds
        while block or time.monotonic() < deadline:
            try:
                key = self._ended.get(block, wait_seconds)
            except queue.Empty:
                return
            block = False
            if key in self._flying:
                future, attempt = self._flying.pop(key)
                ended = self._judge(future, attempt)
                if ended is not None:
                    yield ended

    def drain(self, grace_seconds: float) -> Iterator[BlockOutcome | Failure]:
        """Send nothing more, drop what has not begun, and hand back what ends within a grace.

        Parameters
        ----------
        grace_seconds : float
            How long blocks that run may still take [s].

        Yields
        ------
        BlockOutcome or Failure
            As `collect` does.
        """
        deadline = time.monotonic() + grace_seconds
        running: set[str] = set()
        for keys in self._client.run(executing_keys, on_error="ignore").values():
            running.update(keys)
        self._drop(set(self._flying) - running)
        while self._flying and (left := deadline - time.monotonic()) > 0.0:
            yield from self.collect(min(left, 1.0))
        self.close()

    def close(self) -> None:
        """Drop every block that is still at the cluster."""
        with suppress(OSError, TimeoutError):
            self._drop(set(self._flying))

    def _drop(self, keys: set[str]) -> None:
        futures = [self._flying.pop(key)[0] for key in keys]
        if futures:
            self._client.cancel(futures, reason="the study was stopped")

    def _next(self) -> _Attempt | None:
        if self._suspects and not any(attempt.suspect for _, attempt in self._flying.values()):
            return self._suspects.popleft()
        if self._again:
            return self._again.popleft()
        index = next(self._fresh, None)
        return None if index is None else _Attempt(index)

    def _judge(self, future: Future, attempt: _Attempt) -> BlockOutcome | Failure | None:
        if future.cancelled():
            raise Outage("the connection to the Dask scheduler was lost")
        try:
            outcome: BlockOutcome = future.result(timeout=ANSWER_SECONDS)
        except CancelledError as error:
            raise Outage("the connection to the Dask scheduler was lost") from error
        except KilledWorker:
            failures = attempt.failures + 1
            if failures > RETRIES:
                return Failure(
                    attempt.index,
                    f"its worker died {failures} times (crashed, was killed, or ran out of memory)",
                )
            self._suspects.append(_Attempt(attempt.index, failures, suspect=True))
        except Exception as error:
            failure = judged(error, attempt.index, attempt.failures)
            if failure is not None:
                return failure
            self._again.append(_Attempt(attempt.index, attempt.failures + 1, attempt.suspect))
        else:
            return outcome
        return None

    def _look(self) -> None:
        now = time.monotonic()
        if now - self._looked < LOOK_SECONDS:
            return
        self._looked = now
        self.threads = self._count_threads()
        if self.threads:
            self._peopled = now
        elif now - self._peopled > WORKERLESS_SECONDS:
            raise Outage(f"the cluster has had no worker for {WORKERLESS_SECONDS:g} s")

    def _count_threads(self) -> int:
        try:
            threads = self._client.sync(self._client.scheduler.ncores, callback_timeout=ANSWER_SECONDS)
        except (OSError, TimeoutError) as error:
            raise Outage("the connection to the Dask scheduler was lost") from error
        return sum(threads.values())
