"""Chunks read and decoded without Zarr's own overhead, the last ones kept, so that slices of a large cube are quick.

A slice across the leading dimensions touches hundreds of small chunks, and Zarr spends most of its time between
them. A chunk's file is never overwritten and its name carries its generation, so what is kept does not grow stale;
its size and time are looked at all the same, so that a file that was lost or damaged since is not overlooked.
"""

import os
import threading
from collections import OrderedDict
from collections.abc import Callable
from itertools import product
from typing import Any

import google_crc32c
import numpy as np
import zarr
from numcodecs.blosc import decompress  # type: ignore[import-untyped]
from zarr.codecs import BloscCodec, BytesCodec, Crc32cCodec

KEPT_BYTES = 64 * 2**20
"""Decoded chunks that a process keeps, whatever the size of its cubes."""

_CHECKSUM_BYTES = 4


class DecodedChunks:
    """The chunks that were decoded last, up to a number of bytes; for any number of threads.

    Parameters
    ----------
    limit : int
        Most bytes that are kept.
    """

    def __init__(self, limit: int = KEPT_BYTES) -> None:
        self._limit = limit
        self._kept: OrderedDict[tuple[str, int, int], np.ndarray] = OrderedDict()
        self._bytes = 0
        self._lock = threading.Lock()

    def get(self, path: str, dtype: np.dtype[Any], shape: tuple[int, ...]) -> np.ndarray:
        """Give the chunk in a file, decoding it where it is not kept.

        Raises
        ------
        FileNotFoundError
            If the file is gone.
        ValueError, RuntimeError
            If its bytes are not what was written.
        """
        now = os.stat(path)  # noqa: PTH116
        key = (path, now.st_mtime_ns, now.st_size)
        with self._lock:
            found = self._kept.get(key)
            if found is not None:
                self._kept.move_to_end(key)
                return found
        with open(path, "rb") as file:  # noqa: PTH123
            found = _decode(file.read(), dtype, shape)
        with self._lock:
            if key not in self._kept:
                self._kept[key] = found
                self._bytes += found.nbytes
            while self._bytes > self._limit:
                _, oldest = self._kept.popitem(last=False)
                self._bytes -= oldest.nbytes
        return found


KEPT = DecodedChunks()
"""Of this process."""


def plainly_coded(array: "zarr.Array[Any]") -> bool:
    """Whether the array is coded as this module decodes it: little-endian bytes, Blosc, a checksum."""
    metadata = array.metadata
    codecs = getattr(metadata, "codecs", ())
    if len(codecs) != 3 or array.dtype.byteorder == ">":
        return False
    return all(
        isinstance(codec, kind)
        for codec, kind in zip(codecs, (BytesCodec, BloscCodec, Crc32cCodec), strict=True)
    )


def _decode(data: bytes, dtype: np.dtype[Any], shape: tuple[int, ...]) -> np.ndarray:
    body, checksum = data[:-_CHECKSUM_BYTES], data[-_CHECKSUM_BYTES:]
    if len(checksum) < _CHECKSUM_BYTES or google_crc32c.value(body) != int.from_bytes(checksum, "little"):
        raise ValueError("the checksum of the file is not that of its contents")
    return np.frombuffer(decompress(body), dtype).reshape(shape)


def read_outer(
    array: "zarr.Array[Any]",
    key: tuple[Any, ...],
    chunk: Callable[[tuple[int, ...]], np.ndarray | None],
) -> np.ndarray:
    """Index an array along each dimension on its own, chunk by chunk.

    Parameters
    ----------
    array : Array
        For shape, chunks, type and fill value.
    key : tuple
        For each dimension an integer, a slice, or an array of integers.
    chunk : callable
        Gives the decoded chunk at a place of the grid of chunks, or None where everything is fill value.

    Returns
    -------
    ndarray
        As `array.oindex[key]`.
    """
    points = [
        np.arange(extent)[index] if isinstance(index, slice) else np.atleast_1d(np.asarray(index))
        for index, extent in zip(key, array.shape, strict=True)
    ]
    values = np.full([p.size for p in points], array.fill_value, array.dtype)
    # for each dimension: the chunks that are touched, where they land, and what of them is taken
    touched: list[list[tuple[int, Any, Any]]] = []
    for wanted, extent, step in zip(points, array.shape, array.chunks, strict=True):
        wanted = np.where(wanted < 0, wanted + extent, wanted)
        home, inside = wanted // step, wanted % step
        parts: list[tuple[int, Any, Any]] = []
        for place in np.unique(home).tolist():
            to = np.flatnonzero(home == place)
            parts.append((place, _compact(to), _compact(inside[to])))
        touched.append(parts)
    # numpy treats one array among slices as each dimension on its own, but two arrays as pairs
    paired = (
        sum(any(not isinstance(to, slice) or not isinstance(t, slice) for _, to, t in p) for p in touched) > 1
    )
    for parts_here in product(*touched):
        places, into, taken = zip(*parts_here, strict=True)
        found = chunk(places)
        if found is not None and paired:
            values[_outer(into, values.shape)] = found[_outer(taken, found.shape)]
        elif found is not None:
            values[into] = found[taken]
    kept = tuple(0 if isinstance(index, int | np.integer) else slice(None) for index in key)
    return np.asarray(values[kept])


def _compact(index: np.ndarray) -> Any:
    """Write a run of ascending neighbours as a slice, which numpy copies faster."""
    if index[-1] - index[0] == index.size - 1 and (np.diff(index) == 1).all():
        return slice(int(index[0]), int(index[-1]) + 1)
    return index


def _outer(parts: tuple[Any, ...], shape: tuple[int, ...]) -> tuple[Any, ...]:
    """Make an index that treats each dimension on its own."""
    spelled = [
        np.arange(extent)[part] if isinstance(part, slice) else part
        for part, extent in zip(parts, shape, strict=True)
    ]
    return tuple(np.ix_(*spelled))
