"""A cube opened for reading: lazily, with the blocks that are done, and an error where a file is lost or damaged."""

from functools import partial
from typing import Any

import numpy as np
import xarray as xr
from xarray.backends.common import BackendArray
from xarray.core.indexing import (
    ExplicitIndexer,
    IndexingSupport,
    LazilyIndexedArray,
    explicit_indexing_adapter,
)

from damperlab.studies.registry import variables_of
from damperlab.studies.store.chunks import Marks, chunk_file, chunk_key, damaged
from damperlab.studies.store.coding import StoredArray, coordinate_key, decode_coordinate, describe_cube
from damperlab.studies.store.cube import block_grid
from damperlab.studies.store.decoded import KEPT, DecodedChunks, read_outer
from damperlab.studies.store.faults import cannot_use
from damperlab.studies.store.shelf import Shelf


def open_cube(shelf: Shelf, marks: Marks, kept: DecodedChunks = KEPT) -> xr.Dataset:
    """Open a cube lazily; points of blocks that are not done read as not computed.

    Opening costs the same for a small and a large cube, and indexing reads the chunks that it touches.

    Parameters
    ----------
    shelf : Shelf
        Where the cube is.
    marks : mapping
        The generation of every block that is done.
    kept : DecodedChunks
        What was read before.

    Returns
    -------
    Dataset
        Of numpy arrays read on demand. The marks say what was done when they were taken: no file is written
        twice, so what is read later agrees with them, and newer blocks stay hidden. Reading raises
        `BlockDamaged` where a done block cannot be read, and `StoreFault` where nothing can.

    Raises
    ------
    OSError
        If there is no cube, or it cannot be read.
    """
    metadata = shelf.get("zarr.json")
    described = describe_cube(metadata)
    variables: dict[str, xr.Variable] = {}
    for name, attributes in described.coordinates.items():
        values = kept.get(shelf, coordinate_key(name), partial(decode_coordinate, metadata, name))
        variables[name] = xr.Variable((name,), values, dict(attributes))
    for name, array in described.arrays.items():
        attributes = dict(array.attributes)
        if "flag_values" in attributes:
            # CF wants them of the variable's own type, which JSON does not keep
            attributes["flag_values"] = np.asarray(attributes["flag_values"], array.dtype)
        lazy = LazilyIndexedArray(_CheckedArray(shelf, array, marks, kept))
        variables[name] = xr.Variable(described.dimensions, lazy, attributes, {"chunks": array.chunks})
    names = (*described.dimensions, *variables_of(described.dimensions))
    ordered = [name for name in names if name in variables]
    return xr.Dataset({name: variables[name] for name in ordered}, attrs=dict(described.attributes))


def read_region(shelf: Shelf, array: StoredArray, marks: Marks, region: tuple[slice, ...]) -> np.ndarray:
    """Read a part of one array; what is not done reads as not computed, and what cannot be read raises as in `open_cube`."""
    return _CheckedArray(shelf, array, marks, KEPT).read(region)


class _CheckedArray(BackendArray):
    """A stored array whose damaged chunks are told by their block."""

    def __init__(self, shelf: Shelf, array: StoredArray, marks: Marks, kept: DecodedChunks) -> None:
        self._shelf = shelf
        self._array = array
        self._marks = marks
        self._kept = kept
        self._grid = block_grid(array.shape, array.chunks)
        self.shape = array.shape
        self.dtype = array.dtype

    def __getitem__(self, key: ExplicitIndexer) -> Any:
        return explicit_indexing_adapter(key, self.shape, IndexingSupport.OUTER, self.read)

    def read(self, key: tuple[Any, ...]) -> np.ndarray:
        """Read along each dimension on its own."""
        return read_outer(self._array, key, self._chunk, self._shelf.readers)

    def _chunk(self, place: tuple[int, ...]) -> np.ndarray | None:
        """Give a decoded chunk; None where its block is not done."""
        index = 0
        for at, count in zip(place, self._grid, strict=True):
            index = index * count + at
        generation = self._marks.get(index)
        if generation is None:
            return None
        name = self._array.name
        try:
            file = chunk_file(chunk_key(name, place), generation)
            return self._kept.get(self._shelf, file, self._array.decode)
        except FileNotFoundError as error:
            found = "its file is lost, or replaced since the cube was opened"
            raise damaged(self._shelf, index, name, found) from error
        except OSError as error:
            raise cannot_use(self._shelf.address, error) from error
        except (ValueError, RuntimeError) as error:
            raise damaged(self._shelf, index, name, str(error)) from error
