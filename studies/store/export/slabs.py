"""Split a cube into slabs that fit in memory, to read a large cube completely."""

from collections.abc import Iterator
from itertools import product
from math import prod

BUDGET = 2**18
"""Largest number of points of a slab. A slab of eighteen variables takes some tens of megabytes."""


def slabs(
    shape: tuple[int, ...], chunk: tuple[int, ...], budget: int = BUDGET
) -> Iterator[tuple[slice, ...]]:
    """Split a grid along borders of chunks, so that every chunk is read once. The slabs are not in C order.

    A slab has at most `budget` points. If a single chunk has more points, each slab is one chunk. Every point is in
    exactly one slab.
    """
    steps = [min(extent, step) for extent, step in zip(shape, chunk, strict=True)]
    for axis in reversed(range(len(shape))):
        steps[axis] = min(shape[axis], steps[axis] * max(1, budget // prod(steps)))
        if steps[axis] < shape[axis]:
            break
    yield from _boxes(shape, steps)


def rows(shape: tuple[int, ...], chunk: tuple[int, ...], budget: int = BUDGET) -> Iterator[tuple[slice, ...]]:
    """Split a grid so that the slabs, one after another, contain the points in C order, last dimension fastest.

    A slab has at most `budget` points. A chunk that overlaps several slabs is read once for each of them.
    Every point is in exactly one slab.
    """
    steps = [1] * len(shape)
    for axis in reversed(range(len(shape))):
        step = min(shape[axis], max(1, budget // prod(shape[axis + 1 :])))
        if chunk[axis] <= step < shape[axis]:
            # end each slab at a border of chunks; otherwise the next slab would read the cut chunk again
            step -= step % chunk[axis]
        steps[axis] = step
        if step < shape[axis]:
            break
    yield from _boxes(shape, steps)


def _boxes(shape: tuple[int, ...], steps: list[int]) -> Iterator[tuple[slice, ...]]:
    starts = [range(0, extent, step) for extent, step in zip(shape, steps, strict=True)]
    for corner in product(*starts):
        yield tuple(
            slice(at, min(at + step, extent)) for at, step, extent in zip(corner, steps, shape, strict=True)
        )
