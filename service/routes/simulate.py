"""Route that computes one design point during the request."""

from typing import Annotated

from anyio.to_thread import run_sync
from fastapi import Query
from starlette.requests import Request
from starlette.responses import Response
from typing_extensions import TypeAliasType

from damperlab.service.answer_types import gives
from damperlab.service.body import JSON_TYPES, ComputeQuery, media_type, read_body
from damperlab.service.documents import Document
from damperlab.service.estimates import Readiness, readiness_document
from damperlab.service.examples import SIMULATE_BODY
from damperlab.service.problems import documented
from damperlab.service.routes.strict import strict_router
from damperlab.service.simulation import SimulatedDocument, scenes_asked
from damperlab.service.simulation_request import Asked, read_simulation
from damperlab.service.state import Service, TheService
from damperlab.service.work.functions import simulation_body
from damperlab.service.work.later import PROMISED
from damperlab.studies.text import load_text
from damperlab.worker.scenes import Scene

router = strict_router("/api/v1", "simulate")

SimulatedOrReadiness = TypeAliasType("SimulatedOrReadiness", SimulatedDocument | Readiness)


@router.post(
    "/simulate",
    response_class=Document,
    responses={200: gives(SimulatedOrReadiness), 202: PROMISED, **documented(413, 415, 422, 429, 503)},
    openapi_extra={"requestBody": SIMULATE_BODY},
    summary="Compute one design point now",
)
async def ask_simulation(
    request: Request, service: TheService, query: Annotated[ComputeQuery, Query()]
) -> Response:
    """Compute a design point from rest until its response is steady, or for exactly `cycles` excitation cycles."""
    media_type(request, JSON_TYPES)
    body = await read_body(request, service.settings.body_limit_bytes)
    asked, wanted = await run_sync(_read, service, body)
    if query.dry_run:
        return Document(await run_sync(readiness_document, wanted))
    await run_sync(service.kernels.require, wanted, limiter=service.compiling)
    limit = service.settings.simulate_cycles_limit
    return Response(await service.work.run(request, simulation_body, asked, limit), media_type=JSON_TYPES[0])


def _read(service: Service, body: bytes) -> tuple[Asked, list[Scene]]:
    settings = service.settings
    asked = read_simulation(
        load_text(body, "json", guarded=True), settings.simulate_cycles_limit, settings.simulate_history_limit
    )
    return asked, scenes_asked(asked, settings.simulate_cycles_limit)
