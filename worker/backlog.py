"""The blocks of a study that nobody computes yet, in the order in which they shall begin."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import ArrayLike


class Backlog:
    """Blocks that wait.

    Parameters
    ----------
    indices : array of int
        The blocks, the first to begin first.
    """

    def __init__(self, indices: ArrayLike) -> None:
        waiting = np.asarray(indices, dtype=np.int64)
        self._next: Iterator[int] = map(int, waiting)
        self.left = len(waiting)
        """How many blocks wait."""

    def take(self) -> int | None:
        """Give the next block; None where none waits."""
        index = next(self._next, None)
        if index is not None:
            self.left -= 1
        return index
