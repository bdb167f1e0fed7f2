"""Cache of decoded chunks, so that slices of a large cube are fast.

Files are never overwritten, so cached values never become outdated. In a folder, the time and the size of a file are
checked before cached values are used, so that loss or damage of the file is noticed.
"""

import threading
from collections import OrderedDict
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from itertools import islice, product
from typing import Any

import numpy as np

from damperlab.studies.store.cube.coding import StoredArray
from damperlab.studies.store.files.shelf import Shelf

KEPT_BYTES = 64 * 2**20
"""Size of the cache of decoded chunks in a process."""


class DecodedChunks:
    """A cache of the most recently used chunks. Several threads may use the same cache."""

    def __init__(self) -> None:
        self._kept: OrderedDict[tuple[str, str, str, tuple[int, ...]], np.ndarray] = OrderedDict()
        self._bytes = 0
        self._lock = threading.Lock()

    def get(self, shelf: Shelf, key: str, load: Callable[[], np.ndarray], part: str = "") -> np.ndarray:
        """Return the decoded content of a file, or of the file's part `part`. Call `load` if the content is not cached.

        Raises
        ------
        OSError
            If the file cannot be read.
        ValueError, RuntimeError
            If the content of the file is damaged.
        """
        kept_as = (shelf.address, key, part, shelf.stamp(key))
        with self._lock:
            found = self._kept.get(kept_as)
            if found is not None:
                self._kept.move_to_end(kept_as)
                return found
        found = load()
        with self._lock:
            if kept_as not in self._kept:
                self._kept[kept_as] = found
                self._bytes += found.nbytes
            while self._bytes > KEPT_BYTES:
                _, oldest = self._kept.popitem(last=False)
                self._bytes -= oldest.nbytes
        return found

    def clear(self) -> None:
        """Empty the cache."""
        with self._lock:
            self._kept.clear()
            self._bytes = 0


KEPT = DecodedChunks()
"""The cache of this process."""


def read_outer(
    array: StoredArray,
    key: tuple[Any, ...],
    chunk: Callable[[tuple[int, ...]], np.ndarray | None],
    readers: int = 1,
) -> np.ndarray:
    """Index an array along each dimension separately, chunk by chunk.

    Parameters
    ----------
    array : StoredArray
        The array to index.
    key : tuple
        For each dimension an integer, a slice, or an array of integers.
    chunk : callable
        Function that returns the decoded chunk at an index in the grid; None if the chunk has only fill values.
    readers : int
        Number of chunks to read in parallel.

    Returns
    -------
    ndarray
        The values that Zarr returns for `array.oindex[key]`.
    """
    # for each dimension and each needed chunk: index of the chunk, place in the result, and part of the chunk
    touched: list[list[tuple[int, Any, Any]]] = []
    sizes: list[int] = []
    for index, extent, step in zip(key, array.shape, array.chunks, strict=True):
        if isinstance(index, slice) and index.step in (None, 1):
            start, stop, _ = index.indices(extent)
            sizes.append(max(stop - start, 0))
            touched.append(list(_parts_of_range(start, stop, step)))
            continue
        wanted = np.arange(extent)[index] if isinstance(index, slice) else np.atleast_1d(np.asarray(index))
        sizes.append(wanted.size)
        wanted = np.where(wanted < 0, wanted + extent, wanted)
        home, inside = wanted // step, wanted % step
        parts: list[tuple[int, Any, Any]] = []
        for place in np.unique(home).tolist():
            to = np.flatnonzero(home == place)
            parts.append((place, _compact(to), _compact(inside[to])))
        touched.append(parts)
    values = np.full(sizes, array.fill, array.dtype)
    # numpy indexes each dimension separately only if at most one index is an array
    paired = (
        sum(any(not isinstance(to, slice) or not isinstance(t, slice) for _, to, t in p) for p in touched) > 1
    )
    for into, taken, found in _found(product(*touched), chunk, readers):
        if found is not None and paired:
            values[_outer(into, values.shape)] = found[_outer(taken, found.shape)]
        elif found is not None:
            values[into] = found[taken]
    kept = tuple(0 if isinstance(index, int | np.integer) else slice(None) for index in key)
    return np.asarray(values[kept])


def _parts_of_range(start: int, stop: int, step: int) -> Iterator[tuple[int, slice, slice]]:
    """Yield the chunks of length `step` that a range of indices needs, as `read_outer` lists them."""
    for place in range(start // step, -(-stop // step)):
        first, last = max(start, place * step), min(stop, (place + 1) * step)
        yield place, slice(first - start, last - start), slice(first - place * step, last - place * step)


def _found(
    boxes: Iterable[tuple[tuple[int, Any, Any], ...]],
    chunk: Callable[[tuple[int, ...]], np.ndarray | None],
    readers: int,
) -> Iterator[tuple[Any, Any, np.ndarray | None]]:
    """For each needed chunk, yield its place in the result, the part to copy, and the decoded values."""
    turned = (tuple(zip(*box, strict=True)) for box in boxes)
    if readers == 1:
        yield from ((into, taken, chunk(place)) for place, into, taken in turned)
        return
    with ThreadPoolExecutor(readers) as pool:
        # request only as many chunks as are read in parallel, so that not all chunks are in memory together
        while some := list(islice(turned, readers)):
            found = pool.map(chunk, [place for place, _, _ in some])
            yield from ((into, taken, values) for (_, into, taken), values in zip(some, found, strict=True))


def _compact(index: np.ndarray) -> Any:
    """Convert consecutive indices to a slice, because numpy copies slices faster."""
    if index[-1] - index[0] == index.size - 1 and (np.diff(index) == 1).all():
        return slice(int(index[0]), int(index[-1]) + 1)
    return index


def _outer(parts: tuple[Any, ...], shape: tuple[int, ...]) -> tuple[Any, ...]:
    """Return an index with which numpy indexes each dimension separately."""
    spelled = [
        np.arange(extent)[part] if isinstance(part, slice) else part
        for part, extent in zip(parts, shape, strict=True)
    ]
    return tuple(np.ix_(*spelled))
