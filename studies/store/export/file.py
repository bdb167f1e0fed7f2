"""A cube as one file, in any of the formats."""

from pathlib import Path

import xarray as xr

from damperlab.studies.store.export.export import csv_lines, write_netcdf
from damperlab.studies.store.export.parquet import parquet_pieces
from damperlab.studies.vocabulary import ExportFormat


def write_file(cube: xr.Dataset, path: Path, written_as: ExportFormat) -> None:
    """Write a cube."""
    if written_as == "netcdf":
        write_netcdf(cube, path)
        return
    with path.open("wb") as file:
        if written_as == "csv":
            file.writelines(line.encode() for line in csv_lines(cube))
        else:
            file.writelines(parquet_pieces(cube))
