"""The unassigned blocks of a study, the longest first, and the attempts at them."""

from collections import deque
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray


class Backlog:
    """Blocks that wait.

    Parameters
    ----------
    indices : array of int
        The blocks, in the order in which they are taken.
    seconds : array of float, optional
        Expected time of each block of the study [s]; by default all are equal.
    """

    def __init__(self, indices: ArrayLike, seconds: NDArray[np.float64] | None = None) -> None:
        self._waiting = deque(np.asarray(indices, dtype=np.int64).tolist())
        self._seconds = seconds

    @property
    def left(self) -> int:
        """Number of waiting blocks."""
        return len(self._waiting)

    def take(self) -> int | None:
        """Give the next block; None if none waits."""
        return self._waiting.popleft() if self._waiting else None

    def expected(self, index: int) -> float:
        """Give the expected time of a block [s]."""
        return 1.0 if self._seconds is None else float(self._seconds[index])


@dataclass(frozen=True)
class Attempt:
    """An attempt at a block.

    Parameters
    ----------
    index : int
        Index of the block.
    errors, crashes : int
        Number of exceptions that it raised, and number of processes that it certainly ended.
    apart : bool
        Whether to compute it in a separate process, because a worker vanished during it. If the block was the cause,
        only that process is lost.
    avoid : frozenset of str
        Workers at which it failed.
    tries : int
        Number of earlier attempts.
    moved : bool
        Whether it was taken from a worker at which it did not end. An attempt at a moved block has no time limit.
    """

    index: int
    errors: int = 0
    crashes: int = 0
    apart: bool = False
    avoid: frozenset[str] = frozenset()
    tries: int = 0
    moved: bool = False

    def begun(self, apart: bool = False) -> "Attempt":
        """Give the next attempt after one that ended without the block's fault; on request, in a separate process."""
        return replace(self, tries=self.tries + 1, apart=self.apart or apart)

    def elsewhere(self, address: str) -> "Attempt":
        """Give the same attempt, to be made at another worker if there is one."""
        return replace(self, avoid=self.avoid | {address})
