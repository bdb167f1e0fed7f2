"""Split a cube into pieces that fit in memory, to read all of it."""

from collections.abc import Iterator
from itertools import product
from math import prod

BUDGET = 2**18
"""Points in memory at a time; with eighteen variables, some tens of megabytes."""


def slabs(
    shape: tuple[int, ...], chunk: tuple[int, ...], budget: int = BUDGET
) -> Iterator[tuple[slice, ...]]:
    """Split along chunk borders, so that every chunk is read once. This is for reductions, for which order does not
    matter.

    Parameters
    ----------
    shape, chunk : tuple of int
        Shape of the array, and of its chunks.
    budget : int
        Largest number of points of a slab; a larger single chunk is still taken.

    Yields
    ------
    tuple of slice
        Every point is in exactly one slab.
    """
    steps = [min(extent, step) for extent, step in zip(shape, chunk, strict=True)]
    for axis in reversed(range(len(shape))):
        steps[axis] = min(shape[axis], steps[axis] * max(1, budget // prod(steps)))
        if steps[axis] < shape[axis]:
            break
    yield from _boxes(shape, steps)


def rows(shape: tuple[int, ...], chunk: tuple[int, ...], budget: int = BUDGET) -> Iterator[tuple[slice, ...]]:
    """Split so that the slabs, one after another, give the points in C order, last dimension fastest.

    A chunk that is longer than a slab along a leading dimension is read once for each slab that it meets.

    Parameters
    ----------
    shape, chunk : tuple of int
        Shape of the array, and of its chunks.
    budget : int
        Largest number of points of a slab.

    Yields
    ------
    tuple of slice
        Every point is in exactly one slab.
    """
    steps = [1] * len(shape)
    for axis in reversed(range(len(shape))):
        step = min(shape[axis], max(1, budget // prod(shape[axis + 1 :])))
        if chunk[axis] <= step < shape[axis]:
            # if a slab ended inside a chunk, the next one would read it again
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
