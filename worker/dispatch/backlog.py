"""The blocks of a study that nobody computes yet: those that are expected to take longest begin first.

Towards the end they are cut: a block that takes long beside what is left for each thread would end when all others have.
"""

import heapq
import math
from collections.abc import Callable, Iterable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from damperlab.worker.dispatch.forecast import Forecast
from damperlab.worker.dispatch.piece import Piece, cut

ALIKE = 1.2
"""Expected times within this factor count as equal before anything is measured: so the first to end tell of
every part of the grid."""

ROUNDS, BLIND_ROUNDS = 0.5, 4.0
"""The end is near where what waits takes less than so many times the longest piece of all a thread; where nothing has been
measured."""
SHARES, BLIND_SHARES = 3.0, 4.0
"""A piece takes no more than what is left for each thread, over this; where nothing has been measured."""
RESERVE = 2.5
"""So many blocks a thread, the shortest, are left for the end, which they make even (`tests/benchmarks/model.py`: with fewer
of them 576 blocks on 128 workers end later)."""
SHORTEST_PART_SECONDS = 0.1
"""Below this a part of a block is mostly overhead."""
HANDING_SECONDS = 3.4e-3
"""The scheduler takes so long for each piece, one after the other (`tests/benchmarks/scale.py`): parts are long enough for it
to serve every thread meanwhile."""


class Backlog:
    """Blocks that wait.

    Parameters
    ----------
    indices : array of int
        The blocks; without a forecast the first begins first, and none is cut.
    forecast : Forecast, optional
        What they are expected to take, which orders them; asked again as it learns.
    whole : callable, optional
        Whether the block of an index must not be cut.
    """

    def __init__(
        self,
        indices: ArrayLike,
        forecast: Forecast | None = None,
        whole: Callable[[int], bool] = lambda index: False,
    ) -> None:
        self._waiting: NDArray[np.int64] = np.asarray(indices, dtype=np.int64)
        self._taken = 0
        self._parts: list[tuple[float, int, Piece]] = []  # a heap, the longest on top
        self._cuts = 0
        self._forecast = forecast
        self._whole = whole
        self._informed = False
        self._measured: dict[int, tuple[float, float]] = {}
        # without a forecast all are alike
        self._work_left, self._longest = float(len(self._waiting)), 1.0
        if forecast is not None:
            # equals in a mixed order, the same in every run
            self._waiting = np.random.default_rng(0).permutation(np.sort(self._waiting))
            self._sort()

    @property
    def left(self) -> int:
        """How many pieces wait."""
        return len(self._waiting) - self._taken + len(self._parts)

    def nears_end(self, threads: int) -> bool:
        """Whether so little waits for so many threads that a piece which is sent behind another may be the last to end."""
        longest = min(self._longest, self._most(threads))
        return self._work_left <= (ROUNDS if self._informed else BLIND_ROUNDS) * longest * threads

    def take(self, threads: int = 1, behind_seconds: float = 0.0) -> Piece | None:
        """Give the next piece; None where none waits.

        Parameters
        ----------
        threads : int
            Of all workers that compute: a block is cut where it takes long beside what is left for each.
        behind_seconds : float
            What the pieces take behind which it will wait. Where that is long, one is given that is too short for the
            scheduler to serve every thread meanwhile: so these do not all come at the end, when nothing waits at a worker.
        """
        if behind_seconds >= HANDING_SECONDS * threads and (short := self._short(threads)) is not None:
            self._work_left -= self.expected(short)
            return short
        most = self._most(threads)
        while (piece := self._next()) is not None:
            parts = self._cut(piece, most, self._least(threads))
            if len(parts) == 1:
                self._work_left -= self.expected(piece)
                return piece
            self._wait(parts)
        return None

    def drop(self, index: int) -> None:
        """Let the parts of a block wait no more."""
        parts, self._parts = [part for _, _, part in self._parts], []
        self._work_left -= sum(self.expected(part) for part in parts if part.index == index)
        self._wait(part for part in parts if part.index != index)

    def learn(self, piece: Piece, seconds: float) -> None:
        """Hear what a piece has taken in kernels [s]; 0 where that says nothing."""
        if self._forecast is None or seconds <= 0.0:
            return
        share, spent = self._measured.get(piece.index, (0.0, 0.0))
        share, spent = share + piece.share, spent + seconds
        if piece.part is not None:
            self._measured[piece.index] = share, spent
        if self._forecast.learn(piece.index, spent / share):
            self._sort()

    def expected(self, piece: Piece) -> float:
        """Give what a piece is expected to take; without a forecast all are alike."""
        return 1.0 if self._forecast is None else piece.share * float(self._forecast.seconds[piece.index])

    def _most(self, threads: int) -> float:
        """Longest time that a piece should take."""
        if self._forecast is None:
            return math.inf
        shares = (SHARES if self._informed else BLIND_SHARES) * max(1, threads)
        return max(self._least(threads), self._work_left / shares)

    def _least(self, threads: int) -> float:
        return max(SHORTEST_PART_SECONDS, HANDING_SECONDS * threads)

    def _cautious(self, piece: Piece) -> float:
        assert self._forecast is not None
        return piece.share * float(self._forecast.cautious[piece.index])

    def _short(self, threads: int) -> Piece | None:
        """Take the shortest block, where the scheduler could not serve every thread in its time and enough such are left."""
        kept = int(RESERVE * threads)
        if not self._informed or len(self._waiting) - self._taken <= kept:
            return None
        least = HANDING_SECONDS * threads
        if self.expected(Piece(int(self._waiting[-1 - kept]))) >= least:
            return None
        block = Piece(int(self._waiting[-1]))
        if self.expected(block) >= least:
            return None
        self._waiting = self._waiting[:-1]
        return block

    def _next(self) -> Piece | None:
        """Take the longest of what waits."""
        if self._taken == len(self._waiting):
            return heapq.heappop(self._parts)[-1] if self._parts else None
        block = Piece(int(self._waiting[self._taken]))
        if self._parts and -self._parts[0][0] > self._cautious(block):
            return heapq.heappop(self._parts)[-1]
        self._taken += 1
        return block

    def _cut(self, piece: Piece, most: float, least: float) -> list[Piece]:
        if self._forecast is None or self._cautious(piece) <= most:
            return [piece]
        plan = self._forecast.plan
        number = min(math.ceil(self._cautious(piece) / most), int(self.expected(piece) / least))
        if number < 2:
            return [piece]
        parts = cut(piece, plan.block(piece.index), number, plan.study.whole_rows)
        # asked last: it may take a look at the catalogue
        return [piece] if len(parts) == 1 or self._whole(piece.index) else parts

    def _wait(self, parts: Iterable[Piece]) -> None:
        for part in parts:
            self._cuts += 1
            heapq.heappush(self._parts, (-self._cautious(part), self._cuts, part))

    def _sort(self) -> None:
        assert self._forecast is not None
        waiting = self._waiting[self._taken :]
        expected = np.log(self._forecast.cautious[waiting])
        self._informed = self._forecast.informed
        if not self._informed:
            expected = np.round(expected / np.log(ALIKE))
        self._waiting, self._taken = waiting[np.argsort(-expected, kind="stable")], 0
        parts, self._parts = [part for _, _, part in self._parts], []
        self._wait(parts)
        self._work_left = float(self._forecast.seconds[waiting].sum()) + sum(map(self.expected, parts))
        self._longest = float(self._forecast.seconds.max())
