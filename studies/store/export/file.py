"""A cube as one file, in any of the formats."""

import os
from pathlib import Path

import xarray as xr

from damperlab.studies.store.export.export import csv_lines, write_netcdf
from damperlab.studies.store.export.parquet import parquet_pieces
from damperlab.studies.vocabulary import ExportFormat


def write_file(cube: xr.Dataset, path: Path, written_as: ExportFormat) -> None:
    """Write a cube; the file appears under its name when it is whole.

    Parameters
    ----------
    cube : Dataset
        A study's cube.
    path : Path
        The file, replaced if it is there.
    written_as : str
        In which format.
    """
    if written_as == "netcdf":
        write_netcdf(cube, path)
        return
    partial = path.with_name(f"{path.name}.{os.getpid()}.partial")
    try:
        with partial.open("wb") as file:
            if written_as == "csv":
                file.writelines(line.encode() for line in csv_lines(cube))
            else:
                file.writelines(parquet_pieces(cube))
        partial.replace(path)
    finally:
        partial.unlink(missing_ok=True)
