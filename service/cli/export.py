"""The command export: a stored cube as one file for other programs."""

import os
from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from damperlab.service.cli.options import DataDir, StudyId
from damperlab.service.cli.output import make_parent, note, working
from damperlab.service.cli.store import label, open_store


class Format(StrEnum):
    """What a cube can be exported to."""

    netcdf = "netcdf"
    csv = "csv"
    parquet = "parquet"


def export(
    study: StudyId,
    file_format: Annotated[
        Format, typer.Option("--format", help="netCDF-4, or one row for each point: text, or Parquet.")
    ],
    output: Annotated[Path, typer.Option("--output", "-o", metavar="FILE", help="The file to write.")],
    data_dir: DataDir = None,
) -> None:
    """Write a study's results to a file."""
    from damperlab.studies.store.export import csv_lines, write_netcdf
    from damperlab.studies.store.parquet import parquet_pieces

    store = open_store(data_dir)
    record = store.find(study)
    cube = store.cube(record.id)
    make_parent(output)
    with working(f"Writing {output}"):
        if file_format is Format.netcdf:
            write_netcdf(cube, output)
        else:
            # Renamed when it is whole: an interrupted export leaves no half file under the name asked for.
            partial = output.with_name(f"{output.name}.{os.getpid()}.partial")
            try:
                with partial.open("wb") as file:
                    if file_format is Format.csv:
                        file.writelines(line.encode() for line in csv_lines(cube))
                    else:
                        file.writelines(parquet_pieces(cube))
                partial.replace(output)
            finally:
                partial.unlink(missing_ok=True)
    missing = record.points_total - record.points_done
    unfinished = f"; {missing} of them are not computed yet (status -1)" if missing else ""
    note(f"Wrote {record.points_total} points of {label(record)} to {output}{unfinished}.")
