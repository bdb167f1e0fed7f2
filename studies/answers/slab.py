"""Divides a cube into slabs that fit in memory.

A slab contains some of the designs, each with all its cases.
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.answers.selection import dimensions_of
from damperlab.studies.store.export.slabs import BUDGET, slabs

if TYPE_CHECKING:
    import xarray as xr

Places = NDArray[np.intp]


@dataclass(frozen=True)
class Slab:
    """Some designs of a cube, with all cases.

    Parameters
    ----------
    cube : Dataset
        The cube of a study of any kind.
    designs, cases : tuple of str
        The dimensions of a design, and all other dimensions.
    index : mapping of int arrays
        Grid indices along every dimension. Every combination of grid indices is examined.
    """

    cube: "xr.Dataset"
    designs: tuple[str, ...]
    cases: tuple[str, ...]
    index: Mapping[str, Places]

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of grid indices along each dimension in `designs`."""
        return tuple(self.index[name].size for name in self.designs)

    @property
    def extent(self) -> int:
        """Number of cases."""
        return math.prod(self.index[name].size for name in self.cases)

    def read(self, name: str) -> NDArray[Any]:
        """Return a variable as an array (design, case)."""
        values = self.cube[name].isel(self.index).transpose(*self.designs, *self.cases).values
        return np.asarray(values.reshape(math.prod(self.shape), -1))

    def designs_at(self, rows: Places) -> dict[str, Places]:
        """Return the grid indices of designs, by dimension."""
        return self._places(self.designs, rows)

    def cases_at(self, columns: Places) -> dict[str, Places]:
        """Return the grid indices of cases, by dimension."""
        return self._places(self.cases, columns)

    def _places(self, names: tuple[str, ...], flat: Places) -> dict[str, Places]:
        at = np.unravel_index(flat, [self.index[name].size for name in names])
        return {name: self.index[name][place] for name, place in zip(names, at, strict=True)}


def slabs_of(cube: "xr.Dataset", index: Mapping[str, Places], designs: tuple[str, ...]) -> Iterator[Slab]:
    """Divide the examined part of a cube along the designs, so that every chunk is read once.

    Parameters
    ----------
    cube, designs
        As in `Slab`.
    index : mapping of int arrays
        Grid indices to examine, by dimension. Along a dimension that is not named, all indices are examined.
    """
    every = dimensions_of(cube)
    cases = tuple(name for name in every if name not in designs)
    chosen = {name: index.get(name, np.arange(cube.sizes[name])) for name in every}
    status = cube["status"]
    chunks = dict(zip(every, status.encoding.get("chunks", status.shape), strict=True))
    whole = Slab(cube, designs, cases, chosen)
    for box in slabs(whole.shape, tuple(chunks[name] for name in designs), max(1, BUDGET // whole.extent)):
        part = {name: chosen[name][span] for name, span in zip(designs, box, strict=True)}
        yield Slab(cube, designs, cases, {**chosen, **part})
