"""The file of a block. The file begins with a header, which serves as the block's done-mark; the variables follow, each
with a checksum.

    8 bytes   DAMPBLK1
    4 bytes   length of the header in bytes, little-endian
    4 bytes   CRC-32C of the 12 bytes above and of the header
    header    JSON: digest, block, generation, counts, times, checksum of the values, offset and size of each variable
    parts     the variables, each encoded as a chunk of a Zarr array that ends with its CRC-32C

Every byte has a checksum. The header names the study, so that a lost catalogue can be rebuilt.

Every attempt to compute a block has a unique name, the generation. The attempt writes a new file, and the name of the
file contains the generation. For each complete block, the catalogue stores one generation, and readers read only the
file of this generation. No file is ever overwritten, so a reader never mixes two attempts. If the file is lost or
damaged, reading raises an error and never returns a fill value.
"""

import json
import struct
import time
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import google_crc32c
import numpy as np

from damperlab.studies.plan import Block
from damperlab.studies.store.cube.coding import checksum, checksum_holds
from damperlab.studies.store.cube.description import Description, description_of
from damperlab.studies.store.files.folder import open_shelf
from damperlab.studies.store.files.shelf import Shelf
from damperlab.studies.store.record import BlockOutcome
from damperlab.studies.variables import Status

BLOCKS = "blocks"
"""Name of the folder in a cube that contains the block files."""

Marks = Mapping[int, str]
"""The generation of each done block, by the block's index. A generation is the unique name of an attempt to compute a
block.
"""

_MAGIC = b"DAMPBLK1"
_FRAME = struct.Struct("<8sII")
LONGEST_HEADER = _FRAME.size + (1 << 20)
"""Largest size of a header, in bytes."""


def block_key(index: int, generation: str) -> str:
    """Return the name of a block's file, relative to the cube."""
    return f"{BLOCKS}/{index}~{generation}"


def parse_block_key(key: str) -> tuple[int, str] | None:
    """Return the index and the generation in the name of a block's file; None for any other name."""
    folder, _, name = key.partition("/")
    index, tilde, generation = name.partition("~")
    if folder != BLOCKS or not tilde or not (index.isascii() and index.isdigit() and len(index) < 10):
        return None
    return int(index), generation


@dataclass(frozen=True)
class Header:
    """Content of a block's header.

    Parameters
    ----------
    mark : mapping
        The done-mark: `digest`, `block`, `at`, and fields of `BlockOutcome` such as `generation` and `checksum`.
    parts : mapping
        Offset in the file and number of bytes of each variable.
    """

    mark: Mapping[str, Any]
    parts: Mapping[str, tuple[int, int]]

    def require(self, digest: str, index: int, generation: str) -> None:
        """Raise `ValueError` if the file belongs to another study, block or generation."""
        told = self.mark.get("digest"), self.mark.get("block"), self.mark.get("generation")
        if told != (digest, index, generation):
            raise ValueError(f"the file belongs to block {told[1]} of study {str(told[0])[:12]}")


def pack(mark: Mapping[str, Any], parts: Mapping[str, bytes]) -> bytes:
    """Return the content of a block's file, made of the done-mark and the encoded variables."""
    table: dict[str, tuple[int, int]] = {}
    start = 0
    for name, part in parts.items():
        table[name] = start, len(part)
        start += len(part)
    header = json.dumps({"mark": dict(mark), "parts": table}, separators=(",", ":")).encode()
    frame = _MAGIC + struct.pack("<I", len(header))
    crc = struct.pack("<I", google_crc32c.value(frame + header))
    return b"".join((frame, crc, header, *parts.values()))


def write_region(
    cube_path: str,
    block: Block,
    values: Mapping[str, np.ndarray],
    generation: str = "",
    fields: Mapping[str, Any] | None = None,
) -> BlockOutcome:
    """Write the file of one block, and return when the file is on the disk. The caller must not set the done-mark
    earlier.

    Parameters
    ----------
    cube_path : str
        Location of the cube, from `Store.cube_path`.
    block : Block
        The block, which must be one of the cube's chunks.
    values : mapping of array
        Stored variables by name. Every variable has the shape of the block.
    generation : str
        Unique name of this attempt to compute the block. The name of the file and the done-mark contain this name.
    fields : mapping, optional
        Values of further fields of `BlockOutcome`, for the header of the file and for the returned outcome.

    Returns
    -------
    BlockOutcome
        Values for the done-mark.

    Raises
    ------
    FileNotFoundError
        If the cube does not exist, for example because the study was deleted meanwhile.
    KeyError
        If a stored variable is missing from `values`.
    ValueError
        If a variable has another shape than the block.
    OSError
        If the file cannot be written, for example to a full disk, or the cube's description is damaged.
    """
    shelf = open_shelf(cube_path)
    described = description_of(shelf)
    arrays = described.arrays
    for name in arrays:
        if values[name].shape != block.shape:
            raise ValueError(f"{name} has shape {values[name].shape}, its block {block.shape}")
    stored = {name: np.asarray(values[name], array.dtype) for name, array in arrays.items()}
    encoded = {name: array.encode(stored[name]) for name, array in arrays.items()}
    outcome = BlockOutcome(
        index=block.index,
        points=block.points,
        failed=int(np.count_nonzero(stored["status"] >= Status.TOO_MANY_EVENTS)),
        generation=generation,
        checksum=checksum(stored),
        **(fields or {}),
    )
    mark = {
        "digest": described.digest,
        "block": block.index,
        "generation": generation,
        "checksum": outcome.checksum,
        "points": outcome.points,
        "failed": outcome.failed,
        "at": time.time(),
        **(fields or {}),
    }
    shelf.put(block_key(block.index, generation), pack(mark, encoded))
    return outcome


def parse_header(content: bytes) -> Header | None:
    """Read the header from the first bytes of a block's file; return None if more bytes are needed.

    Raises
    ------
    ValueError
        If the header is damaged, or the file is not the file of a block.
    """
    if len(content) < _FRAME.size:
        return None
    magic, length, crc = _FRAME.unpack_from(content)
    if magic != _MAGIC or length > LONGEST_HEADER:
        raise ValueError("the file does not begin like the file of a block")
    end = _FRAME.size + length
    if len(content) < end:
        return None
    header = content[_FRAME.size : end]
    if google_crc32c.value(content[: _FRAME.size - 4] + header) != crc:
        raise ValueError("the checksum of the file's header does not match the header")
    document = json.loads(header)
    parts = {name: (end + start, size) for name, (start, size) in document["parts"].items()}
    return Header(document["mark"], parts)


def read_header(shelf: Shelf, key: str) -> tuple[Header, bytes]:
    """Read the header of a block's file. Return the header, and the bytes that were read from the start of the file.

    Raises
    ------
    OSError
        If the file cannot be read.
    ValueError
        If the header is damaged.
    """
    for length in (shelf.first_bytes, LONGEST_HEADER):
        content = shelf.read(key, 0, length)
        header = parse_header(content)
        if header is not None:
            return header, content
    raise ValueError("the file is cut short")


def read_part(shelf: Shelf, digest: str, index: int, generation: str, variable: str) -> bytes:
    """Read the encoded values of one variable of a block. Decoding the values checks their checksum.

    Raises
    ------
    OSError
        If the file cannot be read.
    ValueError
        If the file is damaged, or belongs to another block.
    """
    key = block_key(index, generation)
    header, content = read_header(shelf, key)
    header.require(digest, index, generation)
    if variable not in header.parts:
        raise ValueError(f"the file lacks {variable}")
    start, size = header.parts[variable]
    if start + size <= len(content):
        return content[start : start + size]
    part = shelf.read(key, start, size)
    if len(part) != size:
        raise ValueError("the file is cut short")
    return part


def read_whole(shelf: Shelf, described: Description, index: int, generation: str) -> tuple[Header, bytes]:
    """Read and check a block's file. Return the header and the content of the file.

    Raise `ValueError` if the file is damaged or belongs to another block, and `OSError` if it cannot be read.
    """
    content = shelf.get(block_key(index, generation))
    header = parse_header(content)
    if header is None:
        raise ValueError("the file is cut short")
    header.require(described.digest, index, generation)
    if header.parts.keys() != described.arrays.keys():
        raise ValueError("the file does not hold the study's variables")
    for name, (start, size) in header.parts.items():
        if not checksum_holds(content[start : start + size]):
            raise ValueError(f"{name} is not as it was written")
    return header, content
