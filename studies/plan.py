"""The division of the grid of a study into blocks, which are created on demand."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from damperlab.studies.kind import AnyStudy

Cost = Callable[[AnyStudy, dict[str, NDArray[Any]]], NDArray[np.float64]]
"""Function that receives a study and the coordinates of N points. The function returns the expected run time
of each point [s], above 0, shape (N,).
"""

BLOCK_SECONDS = 2.0
"""Expected time of a block in a long study. Scheduling and storing a block take much less time."""

SHORTEST_BLOCK_SECONDS = 0.125
"""Shortest expected time of a block. In a shorter block, most of the time would be overhead."""

SLOWEST_BLOCK_SECONDS = 10.0
"""Expected time of a block in the slowest part of a study."""

BALANCED_BLOCKS = 32
"""Smallest number of blocks of a study that takes four seconds or more. A longer study has more blocks, in proportion to
the square root of its time, so that few workers are idle at the end.
"""

MAX_BLOCK_POINTS = 65_536
MAX_BLOCKS = 50_000
"""Largest number of blocks of a study, limited by the speed of one scheduler; see docs/scheduling.md."""

_SAMPLES = {
    "clearance_ratio": 7,
    "friction_ratio": 7,
    "frequency_ratio": 9,
    "record": 16,
    "base_amplitude_m": 7,
}
"""Number of values along each dimension at which the cost is sampled."""
_FEWEST_SAMPLES = 3
_SAMPLED = 16
"""Largest number of points at which the cost of a block is sampled."""
_MOST_SAMPLED, _FEWEST_SAMPLED = 1 << 16, 2
"""Largest number of sampled points in a plan, and smallest number of sampled points in a block.

A plan with very many blocks has more sampled points, because the number for a block takes precedence.
"""
_BLOCKS_AT_ONCE = 1024


@dataclass(frozen=True)
class Block:
    """A box of the grid, stored as one chunk of the cube.

    Parameters
    ----------
    index : int
        Number of the block, in the row-major order of the grid of blocks.
    start, shape : tuple of int
        First index and number of values along each dimension.
    """

    index: int
    start: tuple[int, ...]
    shape: tuple[int, ...]

    @classmethod
    def whole(cls, shape: tuple[int, ...]) -> "Block":
        """Return one block that covers a complete grid of this shape."""
        return cls(0, (0,) * len(shape), shape)

    @property
    def slices(self) -> tuple[slice, ...]:
        """The box as an index into an array of the study's shape."""
        return tuple(slice(a, a + n) for a, n in zip(self.start, self.shape, strict=True))

    @property
    def points(self) -> int:
        """Number of design points in the box."""
        return math.prod(self.shape)


class Plan:
    """The blocks of a study. All blocks have the same shape, except that blocks at the upper edges of the grid may be
    smaller.

    Parameters
    ----------
    study : AnyStudy
        The study.
    chunk : tuple of int
        Shape of a block.
    cost : callable
        Expected seconds per point, see `Cost`.
    """

    def __init__(self, study: AnyStudy, chunk: tuple[int, ...], cost: Cost) -> None:
        self.study = study
        self.chunk = chunk
        self._cost = cost
        self._coordinates = study.coordinates
        self.shape = tuple(len(values) for values in self._coordinates.values())
        self.grid = tuple(-(-n // c) for n, c in zip(self.shape, chunk, strict=True))
        self.count = math.prod(self.grid)
        self.points = math.prod(self.shape)

    def block(self, index: int) -> Block:
        """Return one block.

        Raises
        ------
        IndexError
            If there is no block with this number.
        """
        if not 0 <= index < self.count:
            raise IndexError(f"block {index} of a plan of {self.count} blocks")
        start = []
        rest = int(index)
        for blocks, size in zip(reversed(self.grid), reversed(self.chunk), strict=True):
            rest, position = divmod(rest, blocks)
            start.append(position * size)
        start.reverse()
        shape = tuple(min(c, n - a) for a, c, n in zip(start, self.chunk, self.shape, strict=True))
        return Block(int(index), tuple(start), shape)

    @cached_property
    def block_seconds(self) -> NDArray[np.float64]:
        """Expected seconds of each block, from the cost at points spread over the block; shape (count,)."""
        return self.seconds_of(np.arange(self.count))

    def seconds_of(self, blocks: NDArray[np.int64]) -> NDArray[np.float64]:
        """Return the expected seconds of some blocks, shape (N,)."""
        seconds = np.empty(len(blocks))
        samples = min(_SAMPLED, math.prod(self.chunk), max(_FEWEST_SAMPLED, _MOST_SAMPLED // self.count))
        places = _lattice(samples, len(self.shape))
        for first in range(0, len(blocks), _BLOCKS_AT_ONCE):
            some = blocks[first : first + _BLOCKS_AT_ONCE]
            cost = self._cost(self.study, self._within(some, places)).reshape(len(some), samples)
            seconds[first : first + len(some)] = self._points_of(some) * cost.mean(axis=1)
        return seconds

    def _within(self, indices: NDArray[np.int64], places: NDArray[np.float64]) -> dict[str, NDArray[Any]]:
        """Return the coordinates of points at the same relative positions in each block, block by block."""
        points: dict[str, NDArray[Any]] = {}
        for (name, values), position, size, place in zip(
            self._coordinates.items(), np.unravel_index(indices, self.grid), self.chunk, places.T, strict=True
        ):
            start = position * size
            length = np.minimum(size, len(values) - start)
            points[name] = values[
                (start[:, None] + np.floor(place * length[:, None]).astype(np.int64)).ravel()
            ]
        return points

    def _points_of(self, indices: NDArray[np.int64]) -> NDArray[np.float64]:
        points = np.ones(len(indices))
        for position, size, length in zip(
            np.unravel_index(indices, self.grid), self.chunk, self.shape, strict=True
        ):
            points *= np.minimum(size, length - position * size)
        return points

    @property
    def seconds(self) -> float:
        """Expected seconds of the complete study on one core."""
        return float(self.block_seconds.sum())

    def order(self, indices: ArrayLike | None = None) -> NDArray[np.int64]:
        """Return block indices by decreasing expected time. Blocks of equal time keep the order of their numbers.

        Parameters
        ----------
        indices : array of int, optional
            The blocks to order, each once; all blocks by default.
        """
        chosen = np.arange(self.count) if indices is None else np.sort(np.asarray(indices, dtype=np.int64))
        ordered: NDArray[np.int64] = chosen[np.argsort(-self.block_seconds[chosen], kind="stable")]
        return ordered


def make_plan(study: AnyStudy, cost: Cost) -> Plan:
    """Divide a study into blocks of about two seconds.

    A short study gets shorter blocks, but none below `SHORTEST_BLOCK_SECONDS`. The number of blocks and their duration
    both grow with the square root of the study's time, starting from `BALANCED_BLOCKS` blocks of
    `SHORTEST_BLOCK_SECONDS`. A very long study gets longer blocks, so that it has at most `MAX_BLOCKS` blocks. A block
    has at most `MAX_BLOCK_POINTS` points, or more if it consists of one complete row (`AnyStudy.whole_rows`).
    """
    mean, most = _sampled_cost(study, cost)
    shape = study.shape
    points = math.prod(shape)
    balanced = math.sqrt(mean * points * SHORTEST_BLOCK_SECONDS / BALANCED_BLOCKS)
    seconds = min(max(balanced, SHORTEST_BLOCK_SECONDS), BLOCK_SECONDS)
    wanted = min(seconds / mean, SLOWEST_BLOCK_SECONDS / most, MAX_BLOCK_POINTS)
    size = max(1, int(wanted), -(-points // MAX_BLOCKS))
    if study.whole_rows:
        rows = chunk_of(shape[:-1], max(1, size // shape[-1]))
        return plan_with_chunk(study, (*rows, shape[-1]), cost)
    chunk = chunk_of(shape, size)
    # `chunk_of` prefers complete rows to the exact size, so there may be more blocks than requested.
    while math.prod(-(-n // c) for n, c in zip(shape, chunk, strict=True)) > MAX_BLOCKS:
        size += -(-size // 4)
        chunk = chunk_of(shape, size)
    return plan_with_chunk(study, chunk, cost)


def plan_with_chunk(study: AnyStudy, chunk: tuple[int, ...], cost: Cost) -> Plan:
    """Return the plan of a study with a given block shape, for example the shape in an existing cube.

    Raises
    ------
    ValueError
        If blocks of this study cannot have the shape `chunk`, or if `chunk` divides rows that must be complete.
    """
    shape = study.shape
    if study.whole_rows and chunk[-1] != shape[-1]:
        raise ValueError(f"chunk {chunk} cuts rows of {shape[-1]} values")
    if len(chunk) != len(shape) or not all(1 <= c <= n for c, n in zip(chunk, shape, strict=False)):
        raise ValueError(f"chunk {chunk} does not cut a grid of shape {shape}")
    return Plan(study, tuple(int(c) for c in chunk), cost)


def chunk_of(shape: tuple[int, ...], size: int) -> tuple[int, ...]:
    """Divide a grid evenly into boxes of at most `size` points, and return the shape of a box.

    The first dimensions are divided first, so that response curves along the last dimension are read from few chunks.
    """
    chunk = []
    for length in reversed(shape):
        pieces = -(-length // size)
        chunk.append(-(-length // pieces))
        size = max(1, size // chunk[-1])
    chunk.reverse()
    return tuple(chunk)


def _sampled_cost(study: AnyStudy, cost: Cost) -> tuple[float, float]:
    """Return the mean and the largest cost over a coarse sub-grid that spans every axis."""
    picked = []
    for name, values in study.coordinates.items():
        count = min(len(values), _SAMPLES.get(name, _FEWEST_SAMPLES))
        # the centres of equal parts are sampled, because the ends of an axis would represent fewer points
        picked.append(values[((np.arange(count) + 0.5) * len(values) / count).astype(np.int64)])
    mesh = np.meshgrid(*picked, indexing="ij")
    points = {name: axis.ravel() for name, axis in zip(study.coordinates, mesh, strict=True)}
    seconds = cost(study, points)
    return float(seconds.mean()), float(seconds.max())


def _lattice(count: int, dimensions: int) -> NDArray[np.float64]:
    """Return points spread over a unit box, shape (count, dimensions).

    The points are equally spaced along the last dimension. The other coordinates are the fractional parts of multiples
    of 1/g, 1/g² and so on. The generalised golden ratio g is the solution of g^d = g + 1 with d = `dimensions`.
    """
    golden = 2.0
    for _ in range(64):
        golden = (1.0 + golden) ** (1.0 / dimensions)
    steps = np.array([golden**-k for k in range(1, dimensions)])
    numbers = np.arange(count)
    others = (0.5 + numbers[:, None] * steps) % 1.0
    return np.column_stack([others, (numbers + 0.5) / count])
