"""A cube as one netCDF file or one CSV table, piece by piece, so that memory does not grow with it."""

import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import h5netcdf
import h5py  # type: ignore[import-untyped]
import numpy as np
import xarray as xr

from damperlab.studies.store.slabs import BUDGET, rows, slabs

_FORMATS = {"f": "%.17g", "i": "%d", "U": "%s"}

ROWS_AT_ONCE = 2**13
"""Rows in one piece of CSV text; about four megabytes."""


def dimensions_of(cube: xr.Dataset) -> tuple[str, ...]:
    """Give the dimensions of a cube in their order, also of one without variables."""
    first = next(iter(cube.data_vars.values()), None)
    return tuple(map(str, cube.sizes if first is None else first.dims))


def write_netcdf(cube: xr.Dataset, path: Path) -> None:
    """Write a cube as netCDF-4; the file appears under its name when it is whole.

    Parameters
    ----------
    cube : Dataset
        A study's cube, `Store.cube`.
    path : Path
        The file, replaced if it is there.

    Raises
    ------
    OSError
        If it cannot be written.
    """
    partial = path.with_name(f"{path.name}.{os.getpid()}.partial")
    try:
        with h5netcdf.File(partial, "w") as file:
            _fill(file, cube)
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
    for key, variable in cube.data_vars.items():
        chunks = _chunks(variable)
        target = file.create_variable(
            str(key),
            dimensions,
            dtype=variable.dtype,
            chunks=chunks,
            compression="gzip",
            compression_opts=1,
            shuffle=True,
        )
        target.attrs.update(variable.attrs)
        for slab in slabs(variable.shape, chunks, BUDGET):
            target[slab] = variable[slab].values


def _chunks(variable: xr.DataArray) -> tuple[int, ...]:
    # of a cube that was cut, the encoding still tells the chunks of the whole
    stored = variable.encoding.get("chunks", variable.shape)
    return tuple(min(step, extent) for step, extent in zip(stored, variable.shape, strict=True))


def csv_lines(cube: xr.Dataset) -> Iterator[str]:
    """Give a cube as CSV: one row a point in C order, the coordinates, then the variables.

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
    names = [str(name) for name in cube.data_vars]
    dimensions = dimensions_of(cube)
    yield ",".join((*dimensions, *names)) + "\n"
    if not names:
        return
    formats = [_FORMATS[cube[name].dtype.kind] for name in (*dimensions, *names)]
    line = ",".join(formats) + "\n"
    for piece in columns(cube):
        for start in range(0, piece[names[0]].size, ROWS_AT_ONCE):
            lists = [column[start : start + ROWS_AT_ONCE].tolist() for column in piece.values()]
            yield "".join(map(line.__mod__, zip(*lists, strict=True)))


def columns(cube: xr.Dataset) -> Iterator[dict[str, np.ndarray]]:
    """Give a cube as pieces of a table: one row a point in C order.

    Parameters
    ----------
    cube : Dataset
        A study's cube, or a part of one, with at least one variable.

    Yields
    ------
    dict of ndarray, each (n,)
        The coordinates, then the variables.
    """
    names = [str(name) for name in cube.data_vars]
    first = cube[names[0]]
    dimensions = dimensions_of(cube)
    for slab in rows(first.shape, _chunks(first), BUDGET):
        piece = cube.isel(dict(zip(dimensions, slab, strict=True)))
        axes = np.meshgrid(*(piece[name].values for name in dimensions), indexing="ij", copy=False)
        flat = [*axes, *(piece[name].values for name in names)]
        yield {name: column.reshape(-1) for name, column in zip((*dimensions, *names), flat, strict=True)}
