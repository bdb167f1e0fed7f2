"""The whole cube as a download, written and sent piece by piece."""

import re
import tempfile
from collections.abc import Iterator
from hashlib import blake2b
from itertools import chain, islice
from pathlib import Path
from typing import Annotated, BinaryIO

from fastapi import APIRouter, Query
from pydantic import BaseModel, ConfigDict, Field
from starlette.requests import Request
from starlette.responses import Response, StreamingResponse

from damperlab.service.edge.conditional import has_seen, part_asked
from damperlab.service.problems import documented
from damperlab.service.state import Service, TheService, TheStudy
from damperlab.studies.store.export.export import csv_lines, without_names, write_netcdf
from damperlab.studies.store.export.parquet import parquet_pieces
from damperlab.studies.store.faults import cannot_use
from damperlab.studies.store.record import Record
from damperlab.studies.vocabulary import ExportFormat
from damperlab.worker.provenance import code_version

NETCDF = "application/x-netcdf"
PARQUET = "application/vnd.apache.parquet"
PIECE_BYTES = 1 << 20
COMPLETE = "X-Complete"
CACHING = "private, no-cache"
"""A client may keep an export, and asks each time whether it is still the one."""

router = APIRouter(prefix="/api/v1/studies/{study_id}", tags=["queries"])


class ExportQuery(BaseModel):
    """Parameters of an export."""

    model_config = ConfigDict(extra="forbid")

    format: ExportFormat = Field(
        "netcdf", description="netCDF-4, or a table with one row for each point: as text, or as Parquet."
    )
    names: bool = Field(
        False, description="Keep the names of user, host and owner of the key in the file's provenance."
    )


@router.get(
    "/export",
    response_class=StreamingResponse,
    responses={
        200: {
            "content": {NETCDF: {}, "text/csv": {}, PARQUET: {}},
            "headers": {
                "ETag": {"description": "Of a study that has ended.", "schema": {"type": "string"}},
                COMPLETE: {
                    "description": "Share of the points that have been computed.",
                    "schema": {"type": "number"},
                },
            },
        },
        206: {"description": "The part that Range asked for", "content": {NETCDF: {}}},
        304: {"description": "The client has it already"},
        416: {"description": "The range lies outside"},
        **documented(404, 422, 429, 503),
    },
    summary="The cube as a file",
)
def export(
    request: Request, service: TheService, study: TheStudy, query: Annotated[ExportQuery, Query()]
) -> Response:
    """Send the cube as it is now; points that are not computed yet have status -1. Range is for netCDF."""
    tag = _tag(study, query)
    if tag is not None and has_seen(request.headers, tag):
        return Response(status_code=304, headers={"ETag": tag, "Cache-Control": CACHING})
    response = _export(request, service, study, query, tag)
    # the record was read first: there may be more in the file, and not less
    response.headers[COMPLETE] = f"{study.points_done / study.points_total:.6g}"
    response.headers["Cache-Control"] = CACHING
    if tag is not None:
        response.headers["ETag"] = tag
    return response


def _tag(study: Record, query: ExportQuery) -> str | None:
    """Name the bytes of an export; None while the study goes on, whose next export may hold more."""
    if not study.ended:
        return None
    asked = repr((study.id, study.revision, study.created, study.points_done, query, code_version()))
    return f'"{blake2b(asked.encode(), digest_size=12).hexdigest()}"'


def _export(
    request: Request, service: Service, study: Record, query: ExportQuery, tag: str | None
) -> Response:
    cube = service.store.cube(study.id)
    cube = cube if query.names else without_names(cube)
    stem = re.sub(r"[^A-Za-z0-9._-]+", "-", study.name).strip("-.") or "study"
    if query.format == "csv":
        return _download(csv_lines(cube), "text/csv; charset=utf-8", f"{stem}-{study.id}.csv")
    if query.format == "parquet":
        return _download(parquet_pieces(cube), PARQUET, f"{stem}-{study.id}.parquet")
    # HDF5 is written with seeks, so a whole file comes first; beside the cubes, where there is room for it.
    where = request.scope.get("folder", service.settings.data_dir)
    try:
        with tempfile.TemporaryDirectory(dir=where, prefix="export-") as folder:
            path = Path(folder) / "cube.nc"
            write_netcdf(cube, path)
            size = path.stat().st_size
            # The folder goes now and the bytes with the last handle: a client that leaves half-way leaves no file.
            file = path.open("rb")
    except OSError as error:
        raise cannot_use(str(where), error) from error
    part = None if tag is None else part_asked(request, size, tag)
    start, stop = part or (0, size)
    if start == stop:
        file.close()
        return Response(status_code=416, headers={"Content-Range": f"bytes */{size}"})
    response = _download(_pieces(file, start, stop), NETCDF, f"{stem}-{study.id}.nc")
    response.headers["Content-Length"] = str(stop - start)
    if tag is not None:
        response.headers["Accept-Ranges"] = "bytes"
    if part is not None:
        response.status_code = 206
        response.headers["Content-Range"] = f"bytes {start}-{stop - 1}/{size}"
    return response


def _pieces(file: BinaryIO, start: int, stop: int) -> Iterator[bytes]:
    with file:
        file.seek(start)
        while piece := file.read(min(PIECE_BYTES, stop - start)):
            start += len(piece)
            yield piece


def _download(content: Iterator[str | bytes], media_type: str, name: str) -> StreamingResponse:
    headers = {"Content-Disposition": f'attachment; filename="{name}"'}
    # the head and the first points are read before the status is sent: damage among them is a problem document, and
    # whatever is found later ends the connection, so that the file is known to be cut short
    first = list(islice(content, 2))
    return StreamingResponse(chain(first, content), headers=headers, media_type=media_type)
