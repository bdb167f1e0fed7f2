"""How a variable's chunks become bytes and back, as Zarr has it, without Zarr's own machinery between them.

Zarr spends most of its time between chunks: a slice across the leading dimensions touches hundreds, and a block of
eighteen variables writes eighteen. What is encoded here any Zarr reader decodes, and the other way round.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import google_crc32c
import numpy as np
import zarr
from numcodecs import blosc  # type: ignore[import-untyped]
from zarr.codecs import BloscCodec, BytesCodec, Crc32cCodec
from zarr.core.buffer import Buffer, default_buffer_prototype
from zarr.storage import MemoryStore

_CHECKSUM_BYTES = 4
_SHUFFLES = {"noshuffle": 0, "shuffle": 1, "bitshuffle": 2}


@dataclass(frozen=True)
class StoredArray:
    """One array of a cube, as its metadata describe it.

    Parameters
    ----------
    name : str
        The variable.
    shape, chunks : tuple of int
        Of the array, and of every one of its chunks.
    dtype : dtype
        Little-endian.
    fill : number
        Stands where nothing is stored.
    compressor : BloscCodec
        With its settings.
    checked : bool
        Whether the last four bytes of a chunk are the checksum of the others; the first cubes had none.
    attributes : dict
        Unit, meaning, flags.
    """

    name: str
    shape: tuple[int, ...]
    chunks: tuple[int, ...]
    dtype: np.dtype[Any]
    fill: Any
    compressor: BloscCodec
    checked: bool
    attributes: dict[str, Any]

    def encode(self, values: np.ndarray) -> bytes:
        """Encode a chunk; at the array's end it may be smaller than the others, and is filled up."""
        if values.shape != self.chunks:
            whole = np.full(self.chunks, self.fill, self.dtype)
            whole[tuple(map(slice, values.shape))] = values
            values = whole
        body: bytes = blosc.compress(
            np.ascontiguousarray(values, self.dtype).reshape(-1).view(np.uint8),
            self.compressor.cname.value.encode(),
            self.compressor.clevel,
            _SHUFFLES[self.compressor.shuffle.value],
            self.compressor.blocksize,
            self.compressor.typesize,
        )
        return body + google_crc32c.value(body).to_bytes(_CHECKSUM_BYTES, "little") if self.checked else body

    def decode(self, content: bytes) -> np.ndarray:
        """Decode a chunk.

        Raises
        ------
        ValueError, RuntimeError
            If the bytes are not what was written.
        """
        if not self.intact(content):
            raise ValueError("the checksum of the file is not that of its contents")
        body = content[:-_CHECKSUM_BYTES] if self.checked else content
        return np.frombuffer(blosc.decompress(body), self.dtype).reshape(self.chunks)

    def intact(self, content: bytes) -> bool:
        """Say whether a chunk's bytes are what was written, as far as can be told without decoding them."""
        if not self.checked:
            return True
        body, checksum = content[:-_CHECKSUM_BYTES], content[-_CHECKSUM_BYTES:]
        return bool(body) and google_crc32c.value(body) == int.from_bytes(checksum, "little")


@dataclass(frozen=True)
class Description:
    """What a cube's metadata say.

    Parameters
    ----------
    attributes : mapping
        Of the cube.
    dimensions : tuple of str
        Of every array, in their order.
    arrays : mapping
        By name; coordinates are not among them.
    coordinates : mapping
        Attributes of each coordinate, by name.
    """

    attributes: Mapping[str, Any]
    dimensions: tuple[str, ...]
    arrays: Mapping[str, StoredArray]
    coordinates: Mapping[str, Mapping[str, Any]]

    @property
    def grid(self) -> tuple[int, ...]:
        """Blocks along each dimension."""
        first = next(iter(self.arrays.values()))
        return tuple(-(-extent // step) for extent, step in zip(first.shape, first.chunks, strict=True))


def decode_coordinate(metadata: bytes, name: str, content: bytes) -> np.ndarray:
    """Decode the one chunk of a coordinate, for which Zarr's own way is quick enough."""
    memory = {
        key: _buffer(piece) for key, piece in (("zarr.json", metadata), (coordinate_key(name), content))
    }
    array = zarr.open_group(MemoryStore(memory), mode="r", use_consolidated=True)[name]
    assert isinstance(array, zarr.Array)
    values = np.asarray(array[:])
    # texts of one length, as numpy has always had them
    return values if values.dtype.kind == "f" else np.array([str(value) for value in values])


def coordinate_key(name: str) -> str:
    """Give the key under which Zarr knows the one chunk of a coordinate."""
    return f"{name}/c/0"


@lru_cache(maxsize=64)
def describe_cube(metadata: bytes) -> Description:
    """Read a cube's consolidated metadata, the content of its first `zarr.json`.

    Raises
    ------
    ValueError
        If they are no such metadata.
    """
    group = zarr.open_group(MemoryStore({"zarr.json": _buffer(metadata)}), mode="r", use_consolidated=True)
    arrays, coordinates = {}, {}
    dimensions: tuple[str, ...] = ()
    for name, array in group.arrays():
        named = tuple(map(str, getattr(array.metadata, "dimension_names", None) or ()))
        if named == (name,):
            coordinates[name] = dict(array.attrs)
        else:
            arrays[name] = _stored(name, array)
            dimensions = named
    return Description(dict(group.attrs), dimensions, arrays, coordinates)


def _buffer(content: bytes) -> Buffer:
    return default_buffer_prototype().buffer.from_bytes(content)


def _stored(name: str, array: "zarr.Array[Any]") -> StoredArray:
    kinds = (BytesCodec, BloscCodec, Crc32cCodec)
    codecs = tuple(getattr(array.metadata, "codecs", ()))
    expected = len(codecs) in (2, 3) and all(map(isinstance, codecs, kinds[: len(codecs)]))
    if not expected or array.dtype.byteorder == ">":
        raise ValueError(f"{name} is coded as no cube is: {codecs}")
    return StoredArray(
        name,
        array.shape,
        array.chunks,
        array.dtype,
        array.fill_value,
        codecs[1],
        len(codecs) == 3,
        dict(array.attrs),
    )
