"""Blocks computed in this process, one after the other: what a study needs that ends before a cluster has started."""

import uuid
from collections.abc import Callable, Iterator

from damperlab.studies.store.record import BlockOutcome
from damperlab.worker.outcomes import Failure, judged


class InThisProcess:
    """Computes blocks in the thread that asks for them; stands in the place of `damperlab.worker.dispatch.window.Window`.

    Parameters
    ----------
    run : callable
        Computes and stores the block of the given index under the given task key.
    indices : iterator of int
        The blocks, in the order in which they shall run.
    """

    def __init__(self, run: Callable[[int, str], BlockOutcome], indices: Iterator[int]) -> None:
        self._run = run
        self._indices = indices
        self._next = next(indices, None)

    @property
    def empty(self) -> bool:
        """Whether no block is left."""
        return self._next is None

    def fill(self) -> None:
        """Do nothing: a block begins when its outcome is asked for."""

    def collect(self, wait_seconds: float) -> Iterator[BlockOutcome | Failure]:
        """Compute the next block, however long it takes, and hand back what became of it.

        Raises
        ------
        Interrupted
            The data cannot be read or written.
        """
        if self._next is None:
            return
        index, self._next = self._next, next(self._indices, None)
        failures = 0
        while True:
            ended: BlockOutcome | Failure | None
            try:
                ended = self._run(index, f"block-{uuid.uuid4().hex[:12]}")
            except Exception as error:
                ended = judged(error, index, failures)
            if ended is not None:
                yield ended
                return
            failures += 1

    def drain(self, grace_seconds: float) -> Iterator[BlockOutcome | Failure]:
        """Hand back nothing: between two calls no block is under way."""
        yield from ()

    def close(self) -> None:
        """Do nothing: there is no cluster to tell."""
