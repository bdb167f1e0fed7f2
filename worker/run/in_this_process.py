"""Blocks computed by threads of this process, for a study that ends before a cluster would have started."""

import uuid
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from typing import Any

from damperlab.studies.store.record import BlockOutcome
from damperlab.worker.cores import core_count
from damperlab.worker.outcomes import Failure, judged


class InThisProcess:
    """Computes a block on each core; has the interface of `damperlab.worker.dispatch.window.Window`.

    Kernels release the lock of the interpreter, so threads use the cores as processes would.

    Parameters
    ----------
    call : callable
        Gives the function that computes and stores the block of the given index under the given task key, and its
        arguments.
    indices : iterator of int
        The blocks, in the order in which they shall begin.
    """

    def __init__(self, call: Callable[[int, str], tuple[Any, ...]], indices: Iterator[int]) -> None:
        self._call = call
        self._indices = indices
        self._cores = core_count()
        self._threads = ThreadPoolExecutor(self._cores, "block")
        self._running: dict[Future[BlockOutcome], tuple[int, int]] = {}

    @property
    def empty(self) -> bool:
        """Whether no block is running; after `fill`, whether none remains."""
        return not self._running

    def fill(self) -> None:
        """Start blocks until every core has one."""
        while len(self._running) < self._cores and (index := next(self._indices, None)) is not None:
            self._begin(index)

    def _begin(self, index: int, failures: int = 0) -> None:
        function, *arguments = self._call(index, f"block-{uuid.uuid4().hex[:12]}")
        self._running[self._threads.submit(function, *arguments)] = index, failures

    def collect(self, wait_seconds: float | None) -> Iterator[BlockOutcome | Failure]:
        """Wait until a block has ended, and return its result; empty if none ends in time.

        Raises
        ------
        Interrupted
            The data cannot be read or written.
        """
        for future in wait(self._running, wait_seconds, FIRST_COMPLETED).done:
            index, failures = self._running.pop(future)
            ended: BlockOutcome | Failure | None
            try:
                ended = future.result()
            except Exception as error:
                ended = judged(error, index, failures)
            if ended is not None:
                yield ended
            else:
                self._begin(index, failures + 1)

    def drain(self, grace_seconds: float) -> Iterator[BlockOutcome | Failure]:
        """Wait for the running blocks, however long they take, because a thread cannot be ended."""
        while self._running:
            yield from self.collect(None)

    def close(self) -> None:
        """Wait for the running blocks, whose results are no longer wanted."""
        self._threads.shutdown(cancel_futures=True)
