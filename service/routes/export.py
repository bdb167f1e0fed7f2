"""Route that sends the complete cube as a file, piece by piece."""

from hashlib import blake2b
from os import SEEK_END
from pathlib import Path
from typing import Annotated, BinaryIO

from fastapi import Query
from pydantic import BaseModel, ConfigDict, Field
from starlette.requests import Request
from starlette.responses import Response, StreamingResponse

from damperlab.service.edge.conditional import has_seen, part_asked
from damperlab.service.problems import documented
from damperlab.service.routes.report import stem
from damperlab.service.routes.strict import strict_router
from damperlab.service.state import TheService, TheStudy
from damperlab.service.work.apart import pieces, written
from damperlab.studies.store.export.export import without_names, write_file
from damperlab.studies.store.record import Record
from damperlab.studies.store.store import Store
from damperlab.studies.vocabulary import ExportFormat
from damperlab.worker.provenance import code_version

NETCDF = "application/x-netcdf"
PARQUET = "application/vnd.apache.parquet"
FILES: dict[ExportFormat, tuple[str, str]] = {
    "netcdf": (".nc", NETCDF),
    "csv": (".csv", "text/csv; charset=utf-8"),
    "parquet": (".parquet", PARQUET),
}
"""Suffix and media type of each format."""
COMPLETE = "X-Complete"
CACHING = "private, no-cache"
"""Value of `Cache-Control`: the client may cache an export, but must revalidate the export each time."""

router = strict_router("/api/v1/studies/{study_id}", "queries")


class ExportQuery(BaseModel):
    """Parameters of an export."""

    model_config = ConfigDict(extra="forbid")

    format: ExportFormat = Field(
        "netcdf", description="netCDF-4, or a table with one row for each point: as text, or as Parquet."
    )
    names: bool = Field(
        False,
        description="Keep the names of the user, the host and the key's owner in the file's provenance. "
        "By default they are removed.",
    )


@router.get(
    "/export",
    response_class=StreamingResponse,
    responses={
        200: {
            "content": {NETCDF: {}, "text/csv": {}, PARQUET: {}},
            "headers": {
                "ETag": {
                    "description": "Tag of the content, for a study that has ended.",
                    "schema": {"type": "string"},
                },
                COMPLETE: {
                    "description": "Share of the points that have been computed.",
                    "schema": {"type": "number"},
                },
            },
        },
        206: {"description": "The part that Range asked for", "content": {NETCDF: {}}},
        304: {"description": "The client has this content already"},
        416: {"description": "The range lies outside the content"},
        **documented(404, 422, 429, 503),
    },
    summary="The cube as a file",
)
async def export(
    request: Request, service: TheService, study: TheStudy, query: Annotated[ExportQuery, Query()]
) -> Response:
    """Send the present cube. Points that are not computed yet have status -1. Range applies only to netCDF."""
    tag = _tag(study, query)
    if tag is not None and has_seen(request.headers, tag):
        return Response(status_code=304, headers={"ETag": tag, "Cache-Control": CACHING})
    _, file = await written(request, service, study, _write, query.format, query.names, export=True)
    response = _download(request, study, query.format, tag, file)
    # the record was read before the cube, so the file may hold more points than the header says, but not fewer
    response.headers[COMPLETE] = f"{study.points_done / study.points_total:.6g}"
    response.headers["Cache-Control"] = CACHING
    if tag is not None:
        response.headers["ETag"] = tag
    return response


def _write(store: Store, study: Record, place: Path, written_as: ExportFormat, names: bool) -> None:
    """Write the complete cube before anything is sent, so that damage is detected."""
    cube = store.cube(study.id)
    write_file(cube if names else without_names(cube), place, written_as)


def _download(
    request: Request, study: Record, written_as: ExportFormat, tag: str | None, file: BinaryIO
) -> Response:
    """Send a file, or the part of the file that the header Range requests."""
    size = file.seek(0, SEEK_END)
    part = part_asked(request, size, tag) if tag is not None and written_as == "netcdf" else None
    start, stop = part or (0, size)
    if part is not None and start == stop:
        file.close()
        return Response(status_code=416, headers={"Content-Range": f"bytes */{size}"})
    suffix, media_type = FILES[written_as]
    name = f"{stem(study.name, 'study')}-{study.id}{suffix}"
    headers = {
        "Content-Disposition": f'attachment; filename="{name}"',
        "Content-Length": str(stop - start),
    }
    if tag is not None and written_as == "netcdf":
        headers["Accept-Ranges"] = "bytes"
    if part is not None:
        headers["Content-Range"] = f"bytes {start}-{stop - 1}/{size}"
    status = 200 if part is None else 206
    return StreamingResponse(pieces(file, start, stop), status, headers, media_type)


def _tag(study: Record, query: ExportQuery) -> str | None:
    """Return a tag that identifies the content of an export; None while the study runs, because the content grows."""
    if not study.ended:
        return None
    asked = repr((study.id, study.revision, study.created, study.points_done, query, code_version()))
    return f'"{blake2b(asked.encode(), digest_size=12).hexdigest()}"'
