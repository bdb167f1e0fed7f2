"""A cube as a table with one row per point, given in pieces, and this table as CSV."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from damperlab.studies.store.export.slabs import BUDGET, rows
from damperlab.studies.units import coordinates_in_units, results_in_units
from damperlab.studies.variables import BEFORE

if TYPE_CHECKING:
    import xarray as xr

_FORMATS = {"f": "%.17g", "i": "%d", "U": "%s"}

ROWS_AT_ONCE = 2**13
"""Rows in one piece of CSV text; about four megabytes."""


def dimensions_of(cube: "xr.Dataset") -> tuple[str, ...]:
    """Give the dimensions of a cube in their order, even if it has no variables."""
    first = next(iter(cube.data_vars.values()), None)
    return tuple(map(str, cube.sizes if first is None else first.dims))


def coordinates_beside(cube: "xr.Dataset") -> tuple[str, ...]:
    """Name the coordinates that accompany the dimensions: those over several dimensions, and ratios of a cavity."""
    of_cavity = [name for name in BEFORE if name not in cube.sizes]
    return tuple(str(name) for name in cube.coords if cube[name].ndim > 1 or name in of_cavity)


def chunks_of(variable: "xr.DataArray") -> tuple[int, ...]:
    """Give the stored chunks of a variable."""
    # the encoding of a part still gives the chunks of the complete cube
    stored = variable.encoding.get("chunks", variable.shape)
    return tuple(min(step, extent) for step, extent in zip(stored, variable.shape, strict=True))


def csv_lines(cube: "xr.Dataset") -> Iterator[str]:
    """Give a cube as CSV: one row per point in C order, the coordinates, then the variables, each also in units.

    Numbers have 17 digits, which reproduce every float64; a missing value is `nan`, codes are integers.

    Parameters
    ----------
    cube : Dataset
        A study's cube, `Store.cube`.

    Yields
    ------
    str
        The header line, then pieces of complete lines.
    """
    described = column_attributes(cube)
    yield ",".join(described) + "\n"
    if not cube.data_vars:
        return
    line = ",".join(_FORMATS[dtype.kind] for dtype, _ in described.values()) + "\n"
    for piece in columns(cube):
        for start in range(0, next(iter(piece.values())).size, ROWS_AT_ONCE):
            lists = [column[start : start + ROWS_AT_ONCE].tolist() for column in piece.values()]
            yield "".join(map(line.__mod__, zip(*lists, strict=True)))


def column_attributes(cube: "xr.Dataset") -> dict[str, tuple[np.dtype[Any], dict[str, Any]]]:
    """Give type and attributes of every column of a cube's table, in their order."""
    found = {name: (cube[name].dtype, dict(cube[name].attrs)) for name in dimensions_of(cube)}
    found |= {each.name: (np.dtype("f8"), dict(each.attributes)) for each in coordinates_in_units(cube)}
    found |= {
        str(name): (cube[name].dtype, dict(cube[name].attrs))
        for name in (*coordinates_beside(cube), *cube.data_vars)
    }
    return found | {each.name: (np.dtype("f8"), dict(each.attributes)) for each in results_in_units(cube)}


def columns(cube: "xr.Dataset") -> Iterator[dict[str, np.ndarray]]:
    """Give a cube as pieces of a table: one row per point in C order.

    Parameters
    ----------
    cube : Dataset
        A study's cube, or a part of one, with at least one variable.

    Yields
    ------
    dict of ndarray, each (n,)
        Columns in the order of `column_attributes`: coordinates, coordinates in units, variables, variables in units.
    """
    names = [str(name) for name in cube.data_vars]
    first = cube[names[0]]
    dimensions = dimensions_of(cube)
    coordinates, results = coordinates_in_units(cube), results_in_units(cube)
    for slab in rows(first.shape, chunks_of(first), BUDGET):
        piece = cube.isel(dict(zip(dimensions, slab, strict=True)))
        axes = np.meshgrid(*(piece[name].values for name in dimensions), indexing="ij", copy=False)
        table = dict(zip(dimensions, axes, strict=True))
        table |= {each.name: each.of(table[each.source]) for each in coordinates}
        table |= {name: _spread(piece, name, dimensions) for name in coordinates_beside(cube)}
        table |= {name: piece[name].values for name in names}
        table |= {each.name: each.of(table[each.source]) for each in results}
        yield {name: column.reshape(-1) for name, column in table.items()}


def _spread(piece: "xr.Dataset", name: str, dimensions: tuple[str, ...]) -> np.ndarray:
    """Broadcast a coordinate of some dimensions over all of them."""
    import xarray as xr

    spread, _ = xr.broadcast(piece[name], piece["status"])
    return np.asarray(spread.transpose(*dimensions).values)
