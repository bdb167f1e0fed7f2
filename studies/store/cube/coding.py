"""Encoding and decoding of a variable's chunks in Zarr's format, without the library Zarr.

The library has a large overhead per chunk, and a slice across the leading dimensions reads hundreds of chunks. The
library can decode chunks that this module has encoded, and vice versa.
"""

import hashlib
import struct
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import google_crc32c
import numpy as np

from damperlab.studies.store.files.shelf import Shelf

CHECKSUM_BYTES = 4

BLOSC: dict[str, Any] = {"cname": "zstd", "clevel": 1, "shuffle": "shuffle", "blocksize": 0}
"""Settings of the codec `blosc` of every array, named as in Zarr's metadata."""


@dataclass(frozen=True)
class StoredArray:
    """Format of one array of a cube, read from the cube's metadata.

    Parameters
    ----------
    name : str
        Name of the variable.
    shape, chunks : tuple of int
        Shape of the array, and shape of each chunk.
    dtype : dtype
        Type of the values, little-endian.
    fill : number
        Fill value: the value of points that have not been computed.
    attributes : dict
        Attributes of the variable: unit, description and meanings of the codes.
    """

    name: str
    shape: tuple[int, ...]
    chunks: tuple[int, ...]
    dtype: np.dtype[Any]
    fill: Any
    attributes: dict[str, Any]

    def encode(self, values: np.ndarray) -> bytes:
        """Encode a chunk. A smaller chunk at the end of the array is padded with the fill value."""
        if values.shape != self.chunks:
            whole = np.full(self.chunks, self.fill, self.dtype)
            whole[tuple(map(slice, values.shape))] = values
            values = whole
        from numcodecs import blosc  # type: ignore[import-untyped]  # imported here, so that a service starts without it

        body: bytes = blosc.compress(
            np.ascontiguousarray(values, self.dtype).reshape(-1).view(np.uint8),
            BLOSC["cname"].encode(),
            BLOSC["clevel"],
            blosc.SHUFFLE,
            BLOSC["blocksize"],
            self.dtype.itemsize,
        )
        return with_checksum(body)

    def decode(self, content: bytes) -> np.ndarray:
        """Decode a chunk.

        Raises
        ------
        ValueError, RuntimeError
            If the bytes are damaged.
        """
        from numcodecs import blosc

        return np.frombuffer(blosc.decompress(without_checksum(content)), self.dtype).reshape(self.chunks)


@dataclass(frozen=True)
class StoredCoordinate:
    """Format of the coordinate of one dimension, read from the cube's metadata.

    Parameters
    ----------
    name : str
        Name of the dimension.
    size : int
        Number of values.
    text : bool
        True if the values are texts, False if the values are doubles.
    value : float, optional
        The value of a dimension with a single number, which is stored in the metadata; None for other dimensions.
    key : str
        Key of the file that holds the values as a single chunk.
    attributes : dict
        Attributes of the coordinate: unit and description.
    """

    name: str
    size: int
    text: bool
    value: float | None
    key: str
    attributes: dict[str, Any]

    def decode(self, content: bytes) -> np.ndarray:
        """Decode the content of the coordinate's file; raise `ValueError` if the content is damaged."""
        body = without_checksum(content)
        values = np.array(_texts(body)) if self.text else np.frombuffer(body, "<f8")
        if len(values) != self.size:
            raise ValueError(f"{len(values)} values in place of {self.size}")
        return values

    def read(self, shelf: Shelf) -> np.ndarray:
        """Return the values of the coordinate."""
        return self.decode(shelf.get(self.key)) if self.value is None else np.array([self.value])


def encode_coordinate(values: np.ndarray) -> bytes:
    """Encode a coordinate as a single chunk of doubles, or of texts in the format of Zarr's codec `vlen-utf8`."""
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
    """Append the CRC-32C of the bytes, as Zarr's codec `crc32c` does."""
    checksum: int = google_crc32c.value(body)
    return body + checksum.to_bytes(CHECKSUM_BYTES, "little")


def without_checksum(content: bytes) -> bytes:
    """Remove the CRC-32C at the end; raise `ValueError` if the CRC-32C does not match the other bytes."""
    if not checksum_holds(content):
        raise ValueError("the checksum of the file does not match its contents")
    return content[:-CHECKSUM_BYTES]


def checksum_holds(content: bytes) -> bool:
    """Whether the checksum of an encoded chunk matches its content."""
    body, checksum = content[:-CHECKSUM_BYTES], content[-CHECKSUM_BYTES:]
    return bool(body) and google_crc32c.value(body) == int.from_bytes(checksum, "little")


def checksum(values: Mapping[str, np.ndarray]) -> str:
    """Return a hash of the values of a block. The hash is the same before encoding and after decoding.

    Parameters
    ----------
    values : mapping of array
        Every stored variable, in its stored type; the order of the variables has no effect.

    Returns
    -------
    str
        BLAKE2b hash of 16 bytes in hexadecimal. The hash depends on every bit of the values, also on the bits of a NaN.
    """
    digest = hashlib.blake2b(digest_size=16)
    for name in sorted(values):
        array = np.ascontiguousarray(values[name])
        little = array.astype(array.dtype.newbyteorder("<"), copy=False)
        digest.update(f"{name} {little.dtype.str} {little.shape}\n".encode())
        digest.update(little.tobytes())
    return digest.hexdigest()
