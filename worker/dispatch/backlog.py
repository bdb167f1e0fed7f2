"""The blocks of a study that nobody computes yet, the longest first, and attempts at them."""

from collections import deque
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray


class Backlog:
    """Blocks that wait.

    Parameters
    ----------
    indices : array of int
        The blocks, in the order in which they shall begin.
    seconds : array of float, optional
        What each block of the study is expected to take [s]; without it all are alike.
    """

    def __init__(self, indices: ArrayLike, seconds: NDArray[np.float64] | None = None) -> None:
        self._waiting = deque(np.asarray(indices, dtype=np.int64).tolist())
        self._seconds = seconds

    @property
    def left(self) -> int:
        """How many blocks wait."""
        return len(self._waiting)

    def take(self) -> int | None:
        """Give the next block; None where none waits."""
        return self._waiting.popleft() if self._waiting else None

    def expected(self, index: int) -> float:
        """Give what a block is expected to take [s]."""
        return 1.0 if self._seconds is None else float(self._seconds[index])


@dataclass(frozen=True)
class Attempt:
    """A block on its way.

    Parameters
    ----------
    index : int
        Of the block.
    errors, crashes : int
        How often computing it raised an exception, and how often it is proven to have ended its process.
    apart : bool
        Compute it in a process of its own: a worker has vanished while it ran, and whether that was the block's doing is
        seen there, and seen without a worker being lost.
    avoid : frozenset of str
        Workers at which it failed.
    tries : int
        How often it was begun before.
    moved : bool
        It was taken from a worker at which it did not end; the next one may take as long as it likes.
    """

    index: int
    errors: int = 0
    crashes: int = 0
    apart: bool = False
    avoid: frozenset[str] = frozenset()
    tries: int = 0
    moved: bool = False

    def begun(self, apart: bool = False) -> "Attempt":
        """Give the next attempt after one that began and ended by nobody's fault; in a process of its own where asked."""
        return replace(self, tries=self.tries + 1, apart=self.apart or apart)

    def elsewhere(self, address: str) -> "Attempt":
        """Give the same attempt, to be made by another worker if there is one."""
        return replace(self, avoid=self.avoid | {address})
