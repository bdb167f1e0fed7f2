"""A cube as one file: netCDF, a CSV table or Parquet, piece by piece, so that memory does not grow with it."""

import json
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import h5netcdf
import h5py  # type: ignore[import-untyped]
import numpy as np
import xarray as xr

from damperlab.studies.conventions import of_variable_in_units
from damperlab.studies.store.export.slabs import BUDGET, rows, slabs
from damperlab.studies.store.provenance import PRIVATE
from damperlab.studies.units import coordinates_in_units, results_in_units
from damperlab.studies.vocabulary import ExportFormat

_FORMATS = {"f": "%.17g", "i": "%d", "U": "%s"}

ROWS_AT_ONCE = 2**13
"""Rows in one piece of CSV text; about four megabytes."""


def dimensions_of(cube: xr.Dataset) -> tuple[str, ...]:
    """Give the dimensions of a cube in their order, also of one without variables."""
    first = next(iter(cube.data_vars.values()), None)
    return tuple(map(str, cube.sizes if first is None else first.dims))


def _beside(cube: xr.Dataset) -> tuple[str, ...]:
    """Name the coordinates that lie over several dimensions of a cube."""
    return tuple(str(name) for name in cube.coords if cube[name].ndim > 1)


def without_names(cube: xr.Dataset) -> xr.Dataset:
    """Give a cube whose provenance names no user, host or owner of a key: a file may be handed on."""
    provenance = json.loads(cube.attrs.get("provenance", "{}"))
    kept = {name: value for name, value in provenance.items() if name not in PRIVATE}
    return cube.assign_attrs(provenance=json.dumps(kept))


def write_file(cube: xr.Dataset, path: Path, written_as: ExportFormat) -> None:
    """Write a cube; the file appears under its name when it is whole.

    Parameters
    ----------
    cube : Dataset
        A study's cube, `Store.cube`.
    path : Path
        The file, replaced if it is there.
    written_as : str
        In which format.

    Raises
    ------
    OSError
        If it cannot be written.
    """
    # which takes its columns from here
    from damperlab.studies.store.export.parquet import parquet_pieces

    partial = path.with_name(f"{path.name}.{os.getpid()}.partial")
    try:
        if written_as == "netcdf":
            with h5netcdf.File(partial, "w") as netcdf:
                _fill(netcdf, cube)
        else:
            with partial.open("wb") as file:
                if written_as == "csv":
                    file.writelines(line.encode() for line in csv_lines(cube))
                else:
                    file.writelines(parquet_pieces(cube))
        partial.replace(path)
    finally:
        partial.unlink(missing_ok=True)


def _fill(file: Any, cube: xr.Dataset) -> None:
    dimensions = dimensions_of(cube)
    file.dimensions = {name: cube.sizes[name] for name in dimensions}
    file.attrs.update({str(name): value for name, value in cube.attrs.items()})
    for name in dimensions:
        values = cube[name].values
        kind = values.dtype
        if kind.kind == "U":
            kind, values = h5py.string_dtype(), values.astype(object)
        coordinate = file.create_variable(name, (name,), kind, data=values)
        coordinate.attrs.update(cube[name].attrs)
    in_units = coordinates_in_units(cube)
    for each in in_units:
        values = each.of(cube[each.source].values)
        file.create_variable(each.name, (each.source,), "f8", data=values).attrs.update(each.attributes)
    for name in _beside(cube):
        file.create_variable(name, cube[name].dims, "f8", data=cube[name].values).attrs.update(
            cube[name].attrs
        )
    named = (*(each.name for each in in_units), *_beside(cube))
    also = {"coordinates": " ".join(named)} if named else {}
    results = {each.source: each for each in results_in_units(cube)}
    for key, variable in cube.data_vars.items():
        chunks = _chunks(variable)
        result = results.get(str(key))
        target = _array(file, str(key), dimensions, variable.dtype, chunks, {**variable.attrs, **also})
        beside: Any = None
        if result is not None:
            attributes = {**result.attributes, **of_variable_in_units(variable.attrs), **also}
            beside = _array(file, result.name, dimensions, np.dtype("f8"), chunks, attributes)
        for slab in slabs(variable.shape, chunks, BUDGET):
            values = variable[slab].values
            target[slab] = values
            if result is not None:
                beside[slab] = result.of(values)


def _array(
    file: Any,
    name: str,
    dimensions: tuple[str, ...],
    dtype: np.dtype[Any],
    chunks: tuple[int, ...],
    attributes: Any,
) -> Any:
    target = file.create_variable(
        name, dimensions, dtype=dtype, chunks=chunks, compression="gzip", compression_opts=1, shuffle=True
    )
    target.attrs.update(attributes)
    return target


def _chunks(variable: xr.DataArray) -> tuple[int, ...]:
    # of a cube that was cut, the encoding still tells the chunks of the whole
    stored = variable.encoding.get("chunks", variable.shape)
    return tuple(min(step, extent) for step, extent in zip(stored, variable.shape, strict=True))


def csv_lines(cube: xr.Dataset) -> Iterator[str]:
    """Give a cube as CSV: one row a point in C order, the coordinates, then the variables, each also in units.

    Numbers have the 17 digits that bring every float64 back; a missing value is `nan`, codes are integers.

    Parameters
    ----------
    cube : Dataset
        A study's cube, `Store.cube`.

    Yields
    ------
    str
        The header line, then pieces of whole lines.
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


def column_attributes(cube: xr.Dataset) -> dict[str, tuple[np.dtype[Any], dict[str, Any]]]:
    """Give type and attributes of every column of a cube's table, in their order."""
    found = {name: (cube[name].dtype, dict(cube[name].attrs)) for name in dimensions_of(cube)}
    found |= {each.name: (np.dtype("f8"), dict(each.attributes)) for each in coordinates_in_units(cube)}
    found |= {
        str(name): (cube[name].dtype, dict(cube[name].attrs)) for name in (*_beside(cube), *cube.data_vars)
    }
    return found | {each.name: (np.dtype("f8"), dict(each.attributes)) for each in results_in_units(cube)}


def columns(cube: xr.Dataset) -> Iterator[dict[str, np.ndarray]]:
    """Give a cube as pieces of a table: one row a point in C order.

    Parameters
    ----------
    cube : Dataset
        A study's cube, or a part of one, with at least one variable.

    Yields
    ------
    dict of ndarray, each (n,)
        The coordinates, those in units, the variables, those in units: as `column_attributes`.
    """
    names = [str(name) for name in cube.data_vars]
    first = cube[names[0]]
    dimensions = dimensions_of(cube)
    coordinates, results = coordinates_in_units(cube), results_in_units(cube)
    for slab in rows(first.shape, _chunks(first), BUDGET):
        piece = cube.isel(dict(zip(dimensions, slab, strict=True)))
        axes = np.meshgrid(*(piece[name].values for name in dimensions), indexing="ij", copy=False)
        table = dict(zip(dimensions, axes, strict=True))
        table |= {each.name: each.of(table[each.source]) for each in coordinates}
        table |= {name: _spread(piece, name, dimensions) for name in _beside(cube)}
        table |= {name: piece[name].values for name in names}
        table |= {each.name: each.of(table[each.source]) for each in results}
        yield {name: column.reshape(-1) for name, column in table.items()}


def _spread(piece: xr.Dataset, name: str, dimensions: tuple[str, ...]) -> np.ndarray:
    """Give a coordinate of some dimensions over all of them."""
    spread, _ = xr.broadcast(piece[name], piece["status"])
    return np.asarray(spread.transpose(*dimensions).values)
