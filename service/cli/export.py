"""The command export: a stored cube as one file for other programs."""

import csv
import os
from collections.abc import Iterator
from enum import StrEnum
from math import prod
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from service.cli.options import DataDir, StudyId
from service.cli.output import make_parent, note, working
from service.cli.store import open_store
from studies.variables import DIMENSIONS

if TYPE_CHECKING:
    import xarray as xr

SLAB_POINTS = 500_000
"""Points held in memory at a time while rows are written."""


class Format(StrEnum):
    """What a cube can be exported to."""

    netcdf = "netcdf"
    csv = "csv"


def export(
    study: StudyId,
    file_format: Annotated[Format, typer.Option("--format", help="netCDF-4, or one row of text for each point.")],
    output: Annotated[Path, typer.Option("--output", "-o", metavar="FILE", help="The file to write.")],
    data_dir: DataDir = None,
) -> None:
    """Write a study's results to a file."""
    store = open_store(data_dir)
    record = store.find(study)
    cube = store.cube(record.id)
    # Written beside it and renamed: an interrupted export leaves no half file under the name that was asked for.
    partial = make_parent(output).with_name(f".{output.name}.{os.getpid()}.partial")
    try:
        with working(f"Writing {output}"):
            if file_format is Format.csv:
                write_csv(cube, partial)
            else:
                cube.to_netcdf(partial, engine="h5netcdf")
        partial.replace(output)
    finally:
        partial.unlink(missing_ok=True)
    missing = record.points_total - record.points_done
    unfinished = f"; {missing} are not computed yet (status -1)" if missing else ""
    note(f"Wrote {record.points_total} points of {record.name} to {output}{unfinished}.")


def write_csv(cube: "xr.Dataset", path: Path) -> None:
    """Write one row a point, last dimension fastest: the six coordinates, then the variables.

    Parameters
    ----------
    cube : Dataset
        As the store opens it. Numbers are spelled so that they read back bit for bit.
    path : Path
        Replaced if it is there.
    """
    import numpy as np

    with path.open("w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file)
        rows.writerow([*DIMENSIONS, *map(str, cube.data_vars)])
        for slab in slabs(cube):
            shape = tuple(slab.sizes[name] for name in DIMENSIONS)
            grid = np.meshgrid(*(slab[name].values for name in DIMENSIONS), indexing="ij", copy=False)
            columns = [*grid, *(slab[name].values.reshape(shape) for name in slab.data_vars)]
            rows.writerows(zip(*(column.ravel().tolist() for column in columns), strict=True))


def slabs(cube: "xr.Dataset", points: int = SLAB_POINTS) -> Iterator["xr.Dataset"]:
    """Cut a cube into pieces that follow each other in the order of its points.

    Parameters
    ----------
    cube : Dataset
        With the six dimensions.
    points : int
        Most points of a piece, unless one row of chunks along the last dimension holds more.
    """
    shape = tuple(cube.sizes[name] for name in DIMENSIONS)
    # Whole chunks at a time along the first dimension that allows it: each chunk is then read once.
    chunk = next(iter(cube.data_vars.values())).encoding.get("chunks", shape)
    split = 0
    while split < len(shape) - 1 and chunk[split] * prod(shape[split + 1 :]) > points:
        split += 1
    yield from _cut(cube, DIMENSIONS[:split], DIMENSIONS[split], chunk[split])


def _cut(cube: "xr.Dataset", leading: tuple[str, ...], last: str, step: int) -> Iterator["xr.Dataset"]:
    if leading:
        for index in range(cube.sizes[leading[0]]):
            yield from _cut(cube.isel({leading[0]: slice(index, index + 1)}), leading[1:], last, step)
        return
    for start in range(0, cube.sizes[last], step):
        yield cube.isel({last: slice(start, start + step)})
