"""Lazy reading of a cube as a Dataset of the blocks that are done. A lost or damaged file causes an error."""

from collections.abc import Mapping
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

from damperlab.studies.amplitudes import AMPLITUDE
from damperlab.studies.conventions import of_variable_in_units
from damperlab.studies.store.cube.block_file import Marks, block_key, read_part
from damperlab.studies.store.cube.coding import StoredArray
from damperlab.studies.store.cube.decoded import KEPT, read_outer
from damperlab.studies.store.cube.description import DESCRIPTION, Description, block_grid, describe_cube
from damperlab.studies.store.faults import reporting_damage
from damperlab.studies.store.files.shelf import Shelf
from damperlab.studies.units import base_of, ratios_beside, results_along


def open_cube(shelf: Shelf, marks: Marks) -> xr.Dataset:
    """Open a cube lazily. Points of blocks that are not done have the fill values, and the status `NOT_COMPUTED`.

    Opening takes the same time for a small and a large cube. Indexing an array reads only the chunks that are needed.

    Parameters
    ----------
    shelf : Shelf
        Storage location of the cube.
    marks : mapping
        The generation of every block that is done, by the block's index.

    Returns
    -------
    Dataset
        Arrays that are read on demand, and that show only the blocks in `marks`. Reading an array raises `BlockDamaged`
        if a block is lost or damaged, and `StoreFault` if the disk or the server reports an error.

    Raises
    ------
    BlockDamaged
        If the description or a coordinate is lost or damaged.
    StoreFault
        If the description or a coordinate cannot be read.
    """
    with reporting_damage(shelf, None, "the cube's description", "a file of it is lost"):
        described = describe_cube(shelf.get(DESCRIPTION))
        variables: dict[str, xr.Variable] = {}
        for name, one in described.coordinates.items():
            read = partial(one.read, shelf)
            values = read() if one.value is not None else KEPT.get(shelf, one.key, read)
            variables[name] = xr.Variable((name,), values, dict(one.attributes))
    for name, array in described.arrays.items():
        attributes = dict(array.attributes)
        if "flag_values" in attributes:
            # CF requires that `flag_values` have the variable's type, and JSON does not preserve the type
            attributes["flag_values"] = np.asarray(attributes["flag_values"], array.dtype)
        lazy = LazilyIndexedArray(CheckedArray(shelf, described, array, marks))
        variables[name] = xr.Variable(described.dimensions, lazy, attributes, {"chunks": array.chunks})
    if AMPLITUDE in described.coordinates:
        variables |= _along_amplitudes(described, shelf, marks, variables)
    complete = "yes" if len(marks) == int(np.prod(described.grid)) else "no"
    cube = xr.Dataset(variables, attrs={**described.attributes, "complete": complete})
    beside = ratios_beside(cube)
    return cube.assign_coords(beside) if beside else cube


def _along_amplitudes(
    described: Description, shelf: Shelf, marks: Marks, variables: Mapping[str, xr.Variable]
) -> dict[str, xr.Variable]:
    """For a study over base amplitudes, return results in physical units, computed on demand from ratios."""
    found = {}
    cube = xr.Dataset(variables, attrs=described.attributes)
    for each in results_along(cube):
        array = described.arrays[each.source]
        base = base_of(cube)
        shape = [base.sizes.get(name, 1) for name in described.dimensions]
        factors = each.factor * base.values.reshape(shape) ** each.power
        lazy = LazilyIndexedArray(_Along(CheckedArray(shelf, described, array, marks), factors))
        encoding = {"chunks": array.chunks}
        attributes = {**each.attributes, **of_variable_in_units(array.attributes)}
        found[each.name] = xr.Variable(described.dimensions, lazy, attributes, encoding)
    return found


class _Along(BackendArray):
    """A stored array multiplied by factors that broadcast to its shape."""

    def __init__(self, source: "CheckedArray", factors: np.ndarray) -> None:
        self._source = source
        self._factors = factors
        self.shape = source.shape
        self.dtype = np.dtype(np.float64)

    def __getitem__(self, key: ExplicitIndexer) -> Any:
        return explicit_indexing_adapter(key, self.shape, IndexingSupport.OUTER, self._read)

    def _read(self, key: tuple[Any, ...]) -> np.ndarray:
        factors = self._factors
        for axis in reversed(range(factors.ndim)):
            one = key[axis]
            if factors.shape[axis] == 1:
                one = 0 if isinstance(one, int | np.integer) else slice(None)
            factors = factors[(slice(None),) * axis + (one,)]
        return np.asarray(self._source.read(key) * factors)


class CheckedArray(BackendArray):
    """A stored array that is read on demand, with the fill value where no point is computed.

    The error for a damaged chunk names the block; see `open_cube`.
    """

    def __init__(self, shelf: Shelf, described: Description, array: StoredArray, marks: Marks) -> None:
        self._shelf = shelf
        self._described = described
        self._array = array
        self._marks = marks
        self._grid = block_grid(array.shape, array.chunks)
        self.shape = array.shape
        self.dtype = array.dtype

    def __getitem__(self, key: ExplicitIndexer) -> Any:
        """Index the array as xarray requests."""
        return explicit_indexing_adapter(key, self.shape, IndexingSupport.OUTER, self.read)

    def read(self, key: tuple[Any, ...]) -> np.ndarray:
        """Index the array along each dimension separately; see `read_outer`."""
        return read_outer(self._array, key, self._chunk, self._shelf.readers)

    def _chunk(self, place: tuple[int, ...]) -> np.ndarray | None:
        """Return the decoded chunk of a block; None if the block is not done."""
        index = 0
        for at, count in zip(place, self._grid, strict=True):
            index = index * count + at
        generation = self._marks.get(index)
        if generation is None:
            return None
        name = self._array.name
        with reporting_damage(
            self._shelf, index, name, "its file is lost, or replaced since the cube was opened"
        ):
            file = block_key(index, generation)
            return KEPT.get(self._shelf, file, partial(self._load, index, generation), name)

    def _load(self, index: int, generation: str) -> np.ndarray:
        content = read_part(self._shelf, self._described.digest, index, generation, self._array.name)
        return self._array.decode(content)
