"""Computes the blocks of a short study in threads of this process, because starting a cluster would take longer."""

import uuid
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from typing import Any

from damperlab.studies.store.record import BlockOutcome
from damperlab.worker.cores import core_count
from damperlab.worker.outcomes import Failure, Interrupted, unusable_data
from damperlab.worker.provenance import WrongCode


class InThisProcess:
    """Computes one block at a time on each core, with the interface of `damperlab.worker.dispatch.window.Window`.

    The kernels release Python's global interpreter lock, so threads can use all cores. A block that raises an exception
    is not tried again, because it would raise the same exception in the same process.

    Parameters
    ----------
    call : callable
        Called with the index of a block and a task key. It returns a tuple of the function that computes and stores the
        block, and the arguments of this function.
    indices : iterator of int
        Indices of the blocks, in the order in which they start.
    """

    def __init__(self, call: Callable[[int, str], tuple[Any, ...]], indices: Iterator[int]) -> None:
        self._call = call
        self._indices = indices
        self._cores = core_count()
        self._threads = ThreadPoolExecutor(self._cores, "block")
        self._running: dict[Future[BlockOutcome], int] = {}

    @property
    def empty(self) -> bool:
        """Whether no block is running. If no block is running after `fill`, all blocks have ended."""
        return not self._running

    def fill(self) -> None:
        """Start blocks until each core computes a block or no block is left."""
        while len(self._running) < self._cores and (index := next(self._indices, None)) is not None:
            function, *arguments = self._call(index, f"block-{uuid.uuid4().hex[:12]}")
            self._running[self._threads.submit(function, *arguments)] = index

    def collect(self, wait_seconds: float | None) -> Iterator[BlockOutcome | Failure]:
        """Wait until at least one block has ended, and yield the results of all ended blocks.

        If `wait_seconds` is None, the wait has no limit.

        Raises
        ------
        Interrupted
            If the data cannot be read or written.
        """
        for future in wait(self._running, wait_seconds, FIRST_COMPLETED).done:
            index = self._running.pop(future)
            ended: BlockOutcome | Failure
            try:
                ended = future.result()
            except Exception as error:
                ended = _judged(error, index)
            yield ended

    def drain(self, grace_seconds: float) -> Iterator[BlockOutcome | Failure]:
        """Yield the results of the running blocks. The time limit is ignored, because a thread cannot be stopped."""
        while self._running:
            yield from self.collect(None)

    def close(self) -> None:
        """Wait for the running blocks, and discard their results."""
        self._threads.shutdown(cancel_futures=True)


def _judged(error: Exception, index: int) -> Failure:
    """Return the failure of a block that has raised an exception.

    Raises
    ------
    Interrupted
        If the worker's code differs from the study's, or data cannot be read or written. The
        points of the block do not cause these errors.
    """
    if isinstance(error, WrongCode):
        raise Interrupted(str(error)) from error
    if isinstance(error, OSError):
        # a disk error is not caused by the points, so no block is recorded as failed
        raise unusable_data(error, "read or written") from error
    return Failure(index, f"{type(error).__name__}: {error}")
