"""The blocks of a study that nobody computes yet: those that are expected to take longest begin first."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from damperlab.worker.forecast import Forecast

ALIKE = 1.2
"""Expected times within this factor count as equal before anything is measured: so the first to end tell of
every part of the grid."""

ROUNDS, BLIND_ROUNDS = 0.25, 3.0
"""The end is near where what waits takes less than so many times the longest block of all a thread; where nothing has been
measured."""


class Backlog:
    """Blocks that wait.

    Parameters
    ----------
    indices : array of int
        The blocks; without a forecast the first begins first.
    forecast : Forecast, optional
        What they are expected to take, which orders them; asked again as it learns.
    """

    def __init__(self, indices: ArrayLike, forecast: Forecast | None = None) -> None:
        self._waiting: NDArray[np.int64] = np.asarray(indices, dtype=np.int64)
        self._taken = 0
        self._forecast = forecast
        self._informed = False
        # without a forecast all are alike
        self._work_left, self._longest = float(len(self._waiting)), 1.0
        if forecast is not None:
            # equals in a mixed order, the same in every run
            self._waiting = np.random.default_rng(0).permutation(np.sort(self._waiting))
            self._sort()

    @property
    def left(self) -> int:
        """How many blocks wait."""
        return len(self._waiting) - self._taken

    def nears_end(self, threads: int) -> bool:
        """Whether so few blocks wait for so many threads that one which is sent behind another may be the last to end."""
        return self._work_left <= (ROUNDS if self._informed else BLIND_ROUNDS) * self._longest * threads

    def take(self) -> int | None:
        """Give the next block; None where none waits."""
        if not self.left:
            return None
        index = int(self._waiting[self._taken])
        self._taken += 1
        self._work_left -= self.expected(index)
        return index

    def learn(self, index: int, seconds: float) -> None:
        """Hear what a block has taken in kernels [s]; 0 where that says nothing."""
        if self._forecast is not None and self._forecast.learn(index, seconds):
            self._sort()

    def _sort(self) -> None:
        assert self._forecast is not None
        waiting = self._waiting[self._taken :]
        expected = np.log(self._forecast.cautious[waiting])
        self._informed = self._forecast.informed
        if not self._informed:
            expected = np.round(expected / np.log(ALIKE))
        self._waiting, self._taken = waiting[np.argsort(-expected, kind="stable")], 0
        self._work_left = float(self._forecast.seconds[waiting].sum())
        self._longest = float(self._forecast.seconds.max())

    def expected(self, index: int) -> float:
        """Give what a block is expected to take; without a forecast all are alike."""
        return 1.0 if self._forecast is None else float(self._forecast.seconds[index])
