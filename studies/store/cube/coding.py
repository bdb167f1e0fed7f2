"""Encoding and decoding of a variable's chunks in Zarr's format, without Zarr's own machinery.

Zarr spends most of its time on overhead per chunk. A slice across the leading dimensions touches hundreds of chunks,
and a block of eighteen variables writes eighteen. Any Zarr reader decodes our chunks, and these functions decode
Zarr's.
"""

import hashlib
import struct
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import google_crc32c
import numpy as np
from numcodecs import blosc  # type: ignore[import-untyped]

from damperlab.studies.store.files.shelf import Shelf

CHECKSUM_BYTES = 4
_SHUFFLES = {"noshuffle": 0, "shuffle": 1, "bitshuffle": 2}


@dataclass(frozen=True)
class Compressor:
    """Settings of Zarr's codec `blosc`, by its own names."""

    cname: str
    clevel: int
    shuffle: str
    blocksize: int
    typesize: int


@dataclass(frozen=True)
class StoredArray:
    """One array of a cube, from its metadata.

    Parameters
    ----------
    name : str
        The variable.
    shape, chunks : tuple of int
        Shape of the array, and of each of its chunks.
    dtype : dtype
        Type of the values, little-endian.
    fill : number
        Value of points that are not stored.
    compressor : Compressor
        Settings of the compression.
    attributes : dict
        Unit, meaning, flags.
    """

    name: str
    shape: tuple[int, ...]
    chunks: tuple[int, ...]
    dtype: np.dtype[Any]
    fill: Any
    compressor: Compressor
    attributes: dict[str, Any]

    def encode(self, values: np.ndarray) -> bytes:
        """Encode a chunk; one at the array's end may be smaller than the others, and is padded."""
        if values.shape != self.chunks:
            whole = np.full(self.chunks, self.fill, self.dtype)
            whole[tuple(map(slice, values.shape))] = values
            values = whole
        body: bytes = blosc.compress(
            np.ascontiguousarray(values, self.dtype).reshape(-1).view(np.uint8),
            self.compressor.cname.encode(),
            self.compressor.clevel,
            _SHUFFLES[self.compressor.shuffle],
            self.compressor.blocksize,
            self.compressor.typesize,
        )
        return with_checksum(body)

    def decode(self, content: bytes) -> np.ndarray:
        """Decode a chunk.

        Raises
        ------
        ValueError, RuntimeError
            If the bytes are damaged.
        """
        return np.frombuffer(blosc.decompress(without_checksum(content)), self.dtype).reshape(self.chunks)


@dataclass(frozen=True)
class StoredCoordinate:
    """The values along one dimension, from a cube's metadata.

    Parameters
    ----------
    name : str
        The dimension.
    size : int
        Number of values.
    text : bool
        Whether they are texts instead of doubles.
    value : float, optional
        The value, if the dimension has only one; it is then stored in the metadata, not in a piece of its own.
    key : str
        Key of the piece with the only chunk.
    attributes : dict
        Unit and meaning.
    """

    name: str
    size: int
    text: bool
    value: float | None
    key: str
    attributes: dict[str, Any]

    def decode(self, content: bytes) -> np.ndarray:
        """Decode the only chunk; raise `ValueError` if it is damaged."""
        body = without_checksum(content)
        values = np.array(_texts(body)) if self.text else np.frombuffer(body, "<f8")
        if len(values) != self.size:
            raise ValueError(f"{len(values)} values in place of {self.size}")
        return values

    def read(self, shelf: Shelf) -> np.ndarray:
        """Give the values, from the cube's shelf if there are several."""
        return self.decode(shelf.get(self.key)) if self.value is None else np.array([self.value])


def encode_coordinate(values: np.ndarray) -> bytes:
    """Encode the only chunk of a coordinate: doubles, or texts in the form of Zarr's codec `vlen-utf8`."""
    if values.dtype.kind != "U":
        return with_checksum(values.astype("<f8").tobytes())
    texts = [str(value).encode() for value in values]
    body = struct.pack("<I", len(texts)) + b"".join(struct.pack("<I", len(text)) + text for text in texts)
    return with_checksum(body)


def _texts(body: bytes) -> list[str]:
    (count,) = struct.unpack_from("<I", body)
    texts, at = [], 4
    for _ in range(count):
        (length,) = struct.unpack_from("<I", body, at)
        texts.append(body[at + 4 : at + 4 + length].decode())
        at += 4 + length
    return texts


def with_checksum(body: bytes) -> bytes:
    """Append the CRC-32C, as Zarr's codec `crc32c` does."""
    checksum: int = google_crc32c.value(body)
    return body + checksum.to_bytes(CHECKSUM_BYTES, "little")


def without_checksum(content: bytes) -> bytes:
    """Remove the CRC-32C; raise `ValueError` if it does not match the bytes before it."""
    if not checksum_holds(content):
        raise ValueError("the checksum of the file is not that of its contents")
    return content[:-CHECKSUM_BYTES]


def checksum_holds(content: bytes) -> bool:
    """Say whether the checksum of a chunk matches, without decoding it."""
    body, checksum = content[:-CHECKSUM_BYTES], content[-CHECKSUM_BYTES:]
    return bool(body) and google_crc32c.value(body) == int.from_bytes(checksum, "little")


def checksum(values: Mapping[str, np.ndarray]) -> str:
    """Hash the values of a block, before encoding and after reading back.

    Parameters
    ----------
    values : mapping of array
        Every stored variable, in its stored type; their order does not count.

    Returns
    -------
    str
        BLAKE2b of 16 bytes in hexadecimal. Equal for equal bits, including the kind of a NaN.
    """
    digest = hashlib.blake2b(digest_size=16)
    for name in sorted(values):
        array = np.ascontiguousarray(values[name])
        little = array.astype(array.dtype.newbyteorder("<"), copy=False)
        digest.update(f"{name} {little.dtype.str} {little.shape}\n".encode())
        digest.update(little.tobytes())
    return digest.hexdigest()
