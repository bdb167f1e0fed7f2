"""Keys of the chunks that clients request: single blocks, or joined blocks of a complete cube.

Without joined chunks, a client would request hundreds of blocks to read a plane of a large cube. A reader that
opened the cube before it was complete continues to request single blocks. The two kinds of request differ in
their keys: joined chunks have keys in Zarr's encoding `v2`, and single blocks have keys in the default encoding.
"""

import json
from dataclasses import dataclass, replace
from functools import lru_cache
from hashlib import blake2b
from itertools import product
from math import prod

import numpy as np

from damperlab.studies.store.cube.block_file import Marks
from damperlab.studies.store.cube.coding import StoredArray
from damperlab.studies.store.cube.description import Description, block_grid
from damperlab.studies.store.files.shelf import Shelf

POINTS = 2**16
"""Largest number of points of a joined chunk: half a megabyte of doubles before compression."""


@dataclass(frozen=True)
class Group:
    """A chunk of joined blocks.

    Parameters
    ----------
    described : Description
        Description of the cube.
    array : StoredArray
        Metadata of the variable, whose chunks are the blocks.
    chunks : tuple of int
        Extent of the joined chunk along each dimension, a multiple of the extent of a block.
    place : tuple of int
        Index of the joined chunk along each dimension.
    """

    described: Description
    array: StoredArray
    chunks: tuple[int, ...]
    place: tuple[int, ...]

    def blocks(self) -> list[int]:
        """Return the indices of the joined blocks, ascending."""
        grid = block_grid(self.array.shape, self.array.chunks)
        ranges = [
            range(at * (step // own), min((at + 1) * (step // own), count))
            for at, step, own, count in zip(self.place, self.chunks, self.array.chunks, grid, strict=True)
        ]
        return [int(np.ravel_multi_index(place, grid)) for place in product(*ranges)]

    def tag(self, marks: Marks) -> str:
        """Return an ETag of the content, computed from the generations of the joined blocks."""
        names = "\n".join(f"{index} {marks[index]}" for index in self.blocks())
        return blake2b(names.encode(), digest_size=8).hexdigest()

    def content(self, shelf: Shelf, marks: Marks) -> bytes:
        """Read the blocks and encode them as one chunk. Exceptions are as in `open_cube`."""
        from damperlab.studies.store.cube.opened import CheckedArray

        region = tuple(
            slice(at * step, min((at + 1) * step, extent))
            for at, step, extent in zip(self.place, self.chunks, self.array.shape, strict=True)
        )
        values = CheckedArray(shelf, self.described, self.array, marks).read(region)
        return replace(self.array, chunks=self.chunks).encode(values)


def group_of(key: str, described: Description) -> Group | None:
    """Read the key of a joined chunk, as in `amplitude_ratio/0.0.0.2.0.0`; return None for any other key."""
    variable, _, name = key.partition("/")
    array = described.arrays.get(variable)
    if array is None:
        return None
    chunks = grouped_chunks(array.shape, array.chunks)
    place = _place(name, block_grid(array.shape, chunks))
    return None if place is None else Group(described, array, chunks, place)


def grouped_chunks(shape: tuple[int, ...], chunk: tuple[int, ...]) -> tuple[int, ...]:
    """Return the shape of a joined chunk. Blocks are joined along the last dimension first."""
    steps = list(chunk)
    for axis in reversed(range(len(shape))):
        blocks = -(-shape[axis] // chunk[axis])
        room = max(1, POINTS // prod(steps))
        steps[axis] *= min(blocks, room)
        if room < blocks:
            break
    return tuple(steps)


@lru_cache(maxsize=64)
def grouped_metadata(metadata: bytes) -> bytes:
    """Return the `zarr.json` of a cube or of one variable, rewritten for joined chunks; coordinates are unchanged."""
    document = json.loads(metadata)
    members = document.get("consolidated_metadata", {}).get("metadata", {})
    for node in (document, *members.values()):
        if node.get("node_type") == "array" and len(node["shape"]) > 1:  # coordinates have one dimension
            grid = node["chunk_grid"]["configuration"]
            grid["chunk_shape"] = grouped_chunks(tuple(node["shape"]), tuple(grid["chunk_shape"]))
            node["chunk_key_encoding"] = {"name": "v2", "configuration": {"separator": "."}}
    return json.dumps(document).encode()


def chunk_place(key: str, grid: tuple[int, ...]) -> tuple[str, int] | None:
    """Read the variable and the block's index from the key of a chunk; return None for any other key."""
    variable, slash, name = key.partition("/c.")
    place = _place(name, grid) if slash else None
    return None if place is None else (variable, int(np.ravel_multi_index(place, grid)))


def _place(name: str, grid: tuple[int, ...]) -> tuple[int, ...] | None:
    """Read the indices of a chunk from a text such as `0.0.2`; return None if the grid has no such chunk."""
    parts = name.split(".")
    if len(parts) != len(grid) or not all(
        part.isascii() and part.isdigit() and len(part) < 10 for part in parts
    ):
        return None
    place = tuple(map(int, parts))
    return place if all(at < count for at, count in zip(place, grid, strict=True)) else None
