"""The files of a cube's blocks: what they are called, and a Zarr store that shows the marked ones alone.

Every attempt at a block writes files of its own, which carry the attempt's generation in their names. The
block's done-mark names one generation, and by that one transaction all readers switch to it. No file is ever
overwritten, so a reader never meets half of one attempt and half of another.
"""

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from zarr.abc.store import ByteRequest, Store
from zarr.storage import LocalStore, WrapperStore

from studies.faults import Fault
from studies.store.faults import StoreFault
from studies.variables import DIMENSIONS

if TYPE_CHECKING:
    from zarr.core.buffer import Buffer, BufferPrototype

Marks = Mapping[int, str]
"""The generation of every done block, by the block's index."""


class BlockDamaged(StoreFault):
    """A block has its done-mark, but its files are lost or do not hold what was written."""


def damaged(path: Path, index: int | None, variable: str, found: str) -> BlockDamaged:
    """Make the fault for a block that cannot be read; the index is None where it is one of several."""
    return BlockDamaged(
        Fault(
            f"{'a block' if index is None else f'block {index}'} of {path.name}",
            f"{variable}: {found}",
            "the block as it was written",
            "find what is damaged with `damperlab verify`, and compute it again with `damperlab verify --repair`",
        )
    )


def chunk_key(variable: str, place: Iterable[int]) -> str:
    """Give the key under which Zarr knows a chunk of a variable."""
    return f"{variable}/c.{'.'.join(map(str, place))}"


def chunk_file(key: str, generation: str) -> str:
    """Give the name of a chunk's file, relative to the cube's folder; the first cubes had no generations."""
    return f"{key}~{generation}" if generation else key


def chunk_place(key: str, grid: tuple[int, ...]) -> tuple[str, int] | None:
    """Read a chunk's key: the variable and the block's index; None for any other key, as of a coordinate."""
    variable, slash, name = key.partition("/c.")
    if not slash or variable in DIMENSIONS:
        return None
    parts = name.split(".")
    if len(parts) != len(grid) or not all(part.isascii() and part.isdigit() for part in parts):
        return None
    place = tuple(map(int, parts))
    if any(at >= count for at, count in zip(place, grid, strict=True)):
        return None
    return variable, int(np.ravel_multi_index(place, grid))


class MarkedChunks(WrapperStore[Store]):
    """A cube for reading: chunks of done blocks in their generation, and nothing of the others.

    Parameters
    ----------
    root : Path
        The cube's folder.
    grid : tuple of int
        Blocks along each dimension.
    marks : mapping
        The done blocks.
    """

    def __init__(self, root: Path, grid: tuple[int, ...], marks: Marks) -> None:
        super().__init__(LocalStore(root, read_only=True))
        self._root = root
        self._grid = grid
        self._marks = marks

    def _with_store(self, store: Store) -> "MarkedChunks":
        return type(self)(self._root, self._grid, self._marks)

    async def get(
        self, key: str, prototype: "BufferPrototype", byte_range: ByteRequest | None = None
    ) -> "Buffer | None":
        """Read a chunk's file; None, for which Zarr puts its fill value, only where the block is not done."""
        place = chunk_place(key, self._grid)
        if place is None:
            return await super().get(key, prototype, byte_range)
        variable, index = place
        generation = self._marks.get(index)
        if generation is None:
            return None
        found = await super().get(chunk_file(key, generation), prototype, byte_range)
        if found is None:
            raise damaged(
                self._root, index, variable, "its file is lost, or replaced since the cube was opened"
            )
        return found


class NewGeneration(WrapperStore[Store]):
    """A cube for writing blocks of one generation.

    Parameters
    ----------
    root : Path
        The cube's folder.
    generation : str
        Goes into the files' names.
    """

    def __init__(self, root: Path, generation: str) -> None:
        super().__init__(LocalStore(root))
        self._root = root
        self._generation = generation

    def _with_store(self, store: Store) -> "NewGeneration":
        return type(self)(self._root, self._generation)

    async def get(
        self, key: str, prototype: "BufferPrototype", byte_range: ByteRequest | None = None
    ) -> "Buffer | None":
        """Read metadata; a chunk is written whole and never read for it."""
        return None if "/c." in key else await super().get(key, prototype, byte_range)

    async def set(self, key: str, value: "Buffer", *ignored: Any) -> None:
        """Write a chunk under its generation's name."""
        await super().set(chunk_file(key, self._generation) if "/c." in key else key, value)
