"""Export of a cube, piece by piece, to a netCDF, CSV or Parquet file. The cube need not fit into memory."""

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from damperlab.studies.conventions import of_variable_in_units
from damperlab.studies.store.export.slabs import BUDGET, slabs
from damperlab.studies.store.export.table import (
    chunks_of,
    coordinates_beside,
    csv_lines,
    dimensions_of,
    parquet_pieces,
)
from damperlab.studies.store.provenance import published
from damperlab.studies.units import coordinates_in_units, results_in_units
from damperlab.studies.vocabulary import ExportFormat

if TYPE_CHECKING:
    import xarray as xr


def without_names(cube: "xr.Dataset") -> "xr.Dataset":
    """Return a cube whose provenance names no user, host or key owner, so that an export can be published."""
    return cube.assign_attrs(provenance=published(cube.attrs.get("provenance", "{}")))


def write_file(cube: "xr.Dataset", path: Path, written_as: ExportFormat) -> None:
    """Write a study's cube to a file, and replace an existing file.

    The new file has another name until it is complete.

    Raises
    ------
    OSError
        If the file cannot be written.
    """
    partial = path.with_name(f"{path.name}.{os.getpid()}.partial")
    try:
        if written_as == "netcdf":
            import h5netcdf

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


def _fill(file: Any, cube: "xr.Dataset") -> None:
    import h5py  # type: ignore[import-untyped]

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
    for name in coordinates_beside(cube):
        file.create_variable(name, cube[name].dims, "f8", data=cube[name].values).attrs.update(
            cube[name].attrs
        )
    named = (*(each.name for each in in_units), *coordinates_beside(cube))
    also = {"coordinates": " ".join(named)} if named else {}
    results = {each.source: each for each in results_in_units(cube)}
    for key, variable in cube.data_vars.items():
        chunks = chunks_of(variable)
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
    packed = {"chunks": chunks, "compression": "gzip", "compression_opts": 1, "shuffle": True}
    missing = np.nan if dtype.kind == "f" else None
    target = file.create_variable(name, dimensions, dtype=dtype, fillvalue=missing, **packed)
    target.attrs.update(attributes)
    return target
