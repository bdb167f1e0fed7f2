"""The whole cube as a download, written and sent piece by piece."""

import re
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, BinaryIO

from fastapi import APIRouter, Query
from pydantic import BaseModel, ConfigDict, Field
from starlette.responses import StreamingResponse

from damperlab.service.problems import documented
from damperlab.service.state import Service, TheService, TheStudy
from damperlab.studies.store.export import csv_lines, write_netcdf
from damperlab.studies.store.parquet import parquet_pieces
from damperlab.studies.store.record import Record
from damperlab.studies.vocabulary import ExportFormat

NETCDF = "application/x-netcdf"
PARQUET = "application/vnd.apache.parquet"
PIECE_BYTES = 1 << 20
COMPLETE = "X-Complete"

router = APIRouter(prefix="/api/v1/studies/{study_id}", tags=["queries"])


class ExportQuery(BaseModel):
    """Parameters of an export."""

    model_config = ConfigDict(extra="forbid")

    format: ExportFormat = Field(
        "netcdf", description="netCDF-4, or a table with one row for each point: as text, or as Parquet."
    )


@router.get(
    "/export",
    response_class=StreamingResponse,
    responses={
        200: {
            "content": {NETCDF: {}, "text/csv": {}, PARQUET: {}},
            "headers": {
                COMPLETE: {"description": "Share of the points that are there.", "schema": {"type": "number"}}
            },
        },
        **documented(404, 422, 503),
    },
    summary="The cube as a file",
)
def export(service: TheService, study: TheStudy, query: Annotated[ExportQuery, Query()]) -> StreamingResponse:
    """Send the cube as it is now; points that are not computed yet have status -1."""
    response = _export(service, study, query)
    # the record was read first: there may be more in the file, and not less
    response.headers[COMPLETE] = f"{study.points_done / study.points_total:.6g}"
    return response


def _export(service: Service, study: Record, query: ExportQuery) -> StreamingResponse:
    cube = service.store.cube(study.id)
    stem = re.sub(r"[^A-Za-z0-9._-]+", "-", study.name).strip("-.") or "study"
    if query.format == "csv":
        return _download(csv_lines(cube), "text/csv; charset=utf-8", f"{stem}-{study.id}.csv")
    if query.format == "parquet":
        return _download(parquet_pieces(cube), PARQUET, f"{stem}-{study.id}.parquet")
    # HDF5 is written with seeks, so a whole file comes first; beside the cubes, where there is room for it.
    with tempfile.TemporaryDirectory(dir=service.settings.data_dir, prefix="export-") as folder:
        path = Path(folder) / "cube.nc"
        write_netcdf(cube, path)
        size = path.stat().st_size
        # The folder goes now and the bytes with the last handle: a client that leaves half-way leaves no file.
        file = path.open("rb")
    response = _download(_pieces(file), NETCDF, f"{stem}-{study.id}.nc")
    response.headers["Content-Length"] = str(size)
    return response


def _pieces(file: BinaryIO) -> Iterator[bytes]:
    with file:
        while piece := file.read(PIECE_BYTES):
            yield piece


def _download(content: Iterator[str] | Iterator[bytes], media_type: str, name: str) -> StreamingResponse:
    headers = {"Content-Disposition": f'attachment; filename="{name}"'}
    return StreamingResponse(content, headers=headers, media_type=media_type)
