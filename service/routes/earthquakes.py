"""Routes of ground-motion records, and of the comparison of dampers under a record."""

from typing import Annotated, Any, Literal

from anyio.to_thread import run_sync
from fastapi import Path, Query
from pydantic import BaseModel, ConfigDict, Field
from starlette.requests import Request
from starlette.responses import Response
from typing_extensions import TypeAliasType, TypedDict

from damperlab.service.answer_types import gives
from damperlab.service.body import JSON_TYPES, ComputeQuery, media_type, read_body
from damperlab.service.documents import Document
from damperlab.service.earthquakes import ComparedDocument
from damperlab.service.estimates import Readiness, readiness_document
from damperlab.service.examples import COMPARISON_BODY, RECORD_BODY
from damperlab.service.problems import documented
from damperlab.service.routes.strict import strict_router
from damperlab.service.security.caller import TheCaller, require_owner
from damperlab.service.state import Service, TheService
from damperlab.service.work.functions import Look, comparison_body, looked_at, uploaded
from damperlab.service.work.later import PROMISED
from damperlab.studies.faults import Fault, StudyFaults, describe, unknown_key
from damperlab.studies.ground.files import Layout
from damperlab.studies.ground.generated import GENERATED, WRITTEN, recipe_in
from damperlab.studies.ground.motion import GroundMotion, GroundMotionDocument, MotionOfId
from damperlab.studies.ground.question import Earthquake, read_earthquake
from damperlab.studies.guard import MAX_KEYS
from damperlab.studies.text import load_text
from damperlab.studies.vocabulary import AccelerationUnits
from damperlab.studies.written_units import ACCELERATIONS
from damperlab.worker.scenes import SPECTRUM, Scene

router = strict_router("/api/v1", "earthquakes")


class GroundMotions(TypedDict):
    """The available records."""

    records: list[GroundMotionDocument]


class GroundMotionShown(GroundMotionDocument, Look):
    """A record with its samples and its response spectrum."""


ComparedOrReadiness = TypeAliasType("ComparedOrReadiness", ComparedDocument | Readiness)

TEXT_TYPES = ("text/plain", "text/csv", "application/octet-stream")


class RecordQuery(BaseModel):
    """Format of an uploaded record."""

    model_config = ConfigDict(extra="forbid")

    format: Literal["at2", "csv"] | None = Field(
        None,
        description="File format: at2 of the PEER database, or csv with two columns, time and acceleration. "
        "By default csv for text/csv, otherwise at2.",
    )
    units: AccelerationUnits | str | None = Field(
        None,
        description=f"Unit of the acceleration, if the file does not state it: {', '.join(ACCELERATIONS)}, or "
        "another spelling of these.",
    )
    name: str = Field("", max_length=200, description="Name of the record.")


class ShownQuery(BaseModel):
    """Number of samples of a record in the answer."""

    model_config = ConfigDict(extra="forbid")

    samples: int = Field(
        2000, ge=2, le=400_000, description="Largest number of samples; thinning keeps the peaks."
    )


class ComparisonQuery(ComputeQuery):
    """Parameters of a comparison."""

    samples: int = Field(
        0,
        ge=0,
        le=50_000,
        description="Largest number of samples of the time history of each case; 0 for no histories. Thinning keeps the "
        "peaks.",
    )


@router.get(
    "/records",
    response_class=Document,
    responses={200: gives(GroundMotions), **documented(503)},
    summary="Ground-motion records",
)
async def list_records(service: TheService) -> Document:
    """List the built-in and the uploaded records, with time step, duration and peaks in SI units."""
    return await run_sync(_list, service)


def _list(service: Service) -> Document:
    return Document({"records": service.settings.records.summaries()})


@router.post(
    "/records",
    response_class=Document,
    status_code=201,
    responses={
        200: gives(GroundMotionDocument, "The same samples exist already"),
        201: gives(GroundMotionDocument, "Kept"),
        **documented(413, 415, 422, 429, 503, 507),
    },
    openapi_extra={"requestBody": RECORD_BODY},
    summary="Upload or generate a record",
)
async def add_record(
    request: Request, service: TheService, query: Annotated[RecordQuery, Query()]
) -> Document:
    """Store a record. The status is 201 if the record is new, and 200 if a record with the same samples exists."""
    kind = media_type(request, (*TEXT_TYPES, *JSON_TYPES))
    body = await read_body(request, service.settings.body_limit_bytes)
    if kind in JSON_TYPES:
        motion = await service.work.run(request, _generated, body)
    else:
        motion = await _read(service, request, body, kind, query)
    return await run_sync(_add, service, motion)


def _add(service: Service, motion: GroundMotion) -> Document:
    record_id, new = service.settings.records.put(motion)
    document: MotionOfId = {"id": record_id, **motion.summary()}
    return Document(document, 201 if new else 200)


async def _read(
    service: Service, request: Request, body: bytes, kind: str, query: RecordQuery
) -> GroundMotion:
    layout: Layout = query.format or ("csv" if kind == "text/csv" else "at2")
    if not query.name.isprintable():
        raise StudyFaults(
            [
                Fault(
                    "name",
                    describe(query.name),
                    "printable text on one line",
                    "remove the characters that cannot be printed",
                )
            ]
        )
    return await service.work.run(request, uploaded, body, layout, query.name, query.units)


def _generated(body: bytes) -> GroundMotion:
    document: Any = load_text(body, "json")
    way = recipe_in(document) if isinstance(document, dict) else ""
    if not way or len(document) > 1:
        faults = []
        if isinstance(document, dict):
            known = tuple(GENERATED)
            strange = [key for key in document if key not in known][:MAX_KEYS]
            faults = [unknown_key(str(key), key, known, document) for key in strange]
        raise StudyFaults(
            faults
            or [
                Fault(
                    "body",
                    describe(document),
                    WRITTEN,
                    "describe the record to generate, or send a file as text/plain or text/csv",
                )
            ]
        )
    return GENERATED[way](document[way])


@router.get(
    "/records/{record_id}",
    response_class=Document,
    responses={200: gives(GroundMotionShown), **documented(404, 422, 429, 503)},
    summary="A record: its samples and its response spectrum",
)
async def show_record(
    request: Request,
    service: TheService,
    query: Annotated[ShownQuery, Query()],
    record_id: Annotated[str, Path(max_length=100, description="Id of a record, or an earthquake's name.")],
) -> Document:
    """Give a record with its acceleration over time, and its response spectrum for a damping ratio of 5 %."""
    whole, motion = await run_sync(service.settings.records.get, record_id)
    await run_sync(service.kernels.require, [SPECTRUM], limiter=service.compiling)
    shown = await service.work.run(request, looked_at, motion, query.samples)
    return Document({"id": whole, **motion.summary(), **shown})


@router.delete(
    "/records/{record_id}",
    status_code=204,
    responses=documented(404, 409, 503),
    summary="Remove an uploaded record",
)
def remove_record(
    service: TheService,
    caller: TheCaller,
    record_id: Annotated[str, Path(max_length=100, description="Whole id of an uploaded record.")],
) -> Response:
    """Remove a record. Studies keep their own copies of the record."""
    shelf = service.settings.records
    require_owner(caller, shelf.owner(record_id), "record")
    shelf.remove(record_id)
    return Response(status_code=204)


@router.post(
    "/earthquake-comparisons",
    response_class=Document,
    responses={200: gives(ComparedOrReadiness), 202: PROMISED, **documented(413, 415, 422, 429, 503)},
    openapi_extra={"requestBody": COMPARISON_BODY},
    summary="Dampers under a record",
)
async def compare_dampers(
    request: Request, service: TheService, query: Annotated[ComparisonQuery, Query()]
) -> Response:
    """Compare the responses to a record with no damper, a tuned mass damper, friction, a particle, and both."""
    media_type(request, JSON_TYPES)
    body = await read_body(request, service.settings.body_limit_bytes)
    asked, wanted = await run_sync(_asked, service, body, query.samples > 0)
    if query.dry_run:
        return Document(await run_sync(readiness_document, wanted))
    await run_sync(service.kernels.require, wanted, limiter=service.compiling)
    return Response(
        await service.work.run(request, comparison_body, asked, query.samples), media_type=JSON_TYPES[0]
    )


def _asked(service: Service, body: bytes, histories: bool) -> tuple[Earthquake, list[Scene]]:
    asked = read_earthquake(load_text(body, "json", guarded=True), service.settings.records)
    from damperlab.service.histories import history_scenes
    from damperlab.worker.ground.comparison import scenes_of

    return asked, scenes_of(asked) + (history_scenes(asked) if histories else [])
