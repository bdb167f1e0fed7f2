"""Export of a cube, piece by piece, to a netCDF file, or to a table as CSV or Parquet. The table has a row per point.

The cube need not fit into memory.
"""

import json
import os
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from damperlab.studies.conventions import of_variable_in_units
from damperlab.studies.store.export.slabs import BUDGET, rows, slabs
from damperlab.studies.store.provenance import published
from damperlab.studies.units import coordinates_in_units, results_in_units
from damperlab.studies.variables import BEFORE
from damperlab.studies.vocabulary import ExportFormat

if TYPE_CHECKING:
    import xarray as xr

_FORMATS = {"f": "%.17g", "i": "%d", "U": "%s"}

ROWS_AT_ONCE = 2**13
"""Number of rows in one piece of CSV text, which has about four megabytes."""


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


def dimensions_of(cube: "xr.Dataset") -> tuple[str, ...]:
    """Return the names of a cube's dimensions, in the order of the variables' axes."""
    first = next(iter(cube.data_vars.values()), None)
    return tuple(map(str, cube.sizes if first is None else first.dims))


def coordinates_beside(cube: "xr.Dataset") -> tuple[str, ...]:
    """Return the names of coordinates that are not dimensions: those with several axes, or in `BEFORE`."""
    of_cavity = [name for name in BEFORE if name not in cube.sizes]
    return tuple(str(name) for name in cube.coords if cube[name].ndim > 1 or name in of_cavity)


def chunks_of(variable: "xr.DataArray") -> tuple[int, ...]:
    """Return the extent of a stored chunk of a variable, at most the extent of the variable."""
    # if the variable is a part of a cube, its encoding still states the chunks of the complete cube
    stored = variable.encoding.get("chunks", variable.shape)
    return tuple(min(step, extent) for step, extent in zip(stored, variable.shape, strict=True))


def csv_lines(cube: "xr.Dataset") -> Iterator[str]:
    """Yield the table of a cube (see `columns`) as CSV text: the header, then groups of complete lines.

    Floating-point numbers have 17 digits, which reproduce every float64. A missing value is `nan`. Codes are integers.
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


def parquet_pieces(cube: "xr.Dataset") -> Iterator[bytes]:
    """Yield the pieces of a Parquet file with the table of a cube; see `columns`.

    The metadata contain the attributes of the cube, and the unit and the description of every column.
    """
    # imported here, because importing pyarrow takes a fifth of a second
    import pyarrow
    import pyarrow.parquet

    schema = pyarrow.schema(
        [
            pyarrow.field(
                name,
                pyarrow.from_numpy_dtype(dtype),
                metadata={key: _text(value) for key, value in attributes.items()},
            )
            for name, (dtype, attributes) in column_attributes(cube).items()
        ],
        metadata={str(key): _text(value) for key, value in cube.attrs.items()},
    )
    sink = BytesIO()
    with pyarrow.parquet.ParquetWriter(
        pyarrow.PythonFile(sink, mode="w"), schema, compression="zstd"
    ) as writer:
        for piece in columns(cube):
            writer.write_table(pyarrow.table(piece, schema=schema))
            yield _taken(sink)
    yield _taken(sink)


def _taken(sink: BytesIO) -> bytes:
    """Remove the bytes that were written since the last call, and return them."""
    piece = sink.getvalue()
    sink.seek(0)
    sink.truncate()
    return piece


def _text(value: object) -> str:
    if isinstance(value, str):
        return value
    return json.dumps(value.tolist() if hasattr(value, "tolist") else value)


def column_attributes(cube: "xr.Dataset") -> dict[str, tuple[np.dtype[Any], dict[str, Any]]]:
    """Return the type and the attributes of every column of a cube's table, in the order of the columns."""
    found = {name: (cube[name].dtype, dict(cube[name].attrs)) for name in dimensions_of(cube)}
    found |= {each.name: (np.dtype("f8"), dict(each.attributes)) for each in coordinates_in_units(cube)}
    found |= {
        str(name): (cube[name].dtype, dict(cube[name].attrs))
        for name in (*coordinates_beside(cube), *cube.data_vars)
    }
    return found | {each.name: (np.dtype("f8"), dict(each.attributes)) for each in results_in_units(cube)}


def columns(cube: "xr.Dataset") -> Iterator[dict[str, np.ndarray]]:
    """Yield the table of a cube, piece by piece, with one row per point in C order.

    The cube must have at least one variable.

    Yields
    ------
    dict of ndarray, each (n,)
        Columns of one piece: coordinates, coordinates in physical units, variables, and variables in physical units, in
        the order of `column_attributes`.
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
    """Broadcast a coordinate to all dimensions of the cube."""
    import xarray as xr

    spread, _ = xr.broadcast(piece[name], piece["status"])
    return np.asarray(spread.transpose(*dimensions).values)
