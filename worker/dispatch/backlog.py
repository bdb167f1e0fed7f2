"""The unassigned blocks of a study, and attempts to compute blocks."""

from collections import deque
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray


class Backlog:
    """Queue of the blocks that have not been assigned to a worker yet.

    Parameters
    ----------
    indices : array of int
        Indices of the blocks, in the order in which they are assigned.
    seconds : array of float, optional
        Expected time of each block of the study [s]; by default 1 s for every block.
    """

    def __init__(self, indices: ArrayLike, seconds: NDArray[np.float64] | None = None) -> None:
        self._waiting = deque(np.asarray(indices, dtype=np.int64).tolist())
        self._seconds = seconds

    @property
    def left(self) -> int:
        """Number of blocks in the queue."""
        return len(self._waiting)

    def take(self) -> int | None:
        """Remove the first block from the queue and return its index; None if the queue is empty."""
        return self._waiting.popleft() if self._waiting else None

    def expected(self, index: int) -> float:
        """Return the expected time of a block [s]."""
        return 1.0 if self._seconds is None else float(self._seconds[index])


@dataclass(frozen=True)
class Attempt:
    """An attempt to compute a block.

    Parameters
    ----------
    index : int
        Index of the block.
    errors, crashes : int
        Number of exceptions that the block has raised, and number of processes that crashed while computing the block.
    apart : bool
        Whether a separate process computes the block, because a worker was lost while computing the block. If the
        separate process crashes, the worker survives.
    avoid : frozenset of str
        Addresses of workers at which the block failed.
    tries : int
        Number of earlier attempts.
    moved : bool
        Whether the block ran far too long at another worker. The attempt then has no time limit.
    """

    index: int
    errors: int = 0
    crashes: int = 0
    apart: bool = False
    avoid: frozenset[str] = frozenset()
    tries: int = 0
    moved: bool = False

    def begun(self, apart: bool = False) -> "Attempt":
        """Return the next attempt at the block; if `apart` is true, the attempt runs in a separate process."""
        return replace(self, tries=self.tries + 1, apart=self.apart or apart)

    def elsewhere(self, address: str) -> "Attempt":
        """Return a copy of this attempt that avoids the given worker."""
        return replace(self, avoid=self.avoid | {address})
