"""One design point now."""

from typing import Annotated

from anyio.to_thread import run_sync
from fastapi import APIRouter, Query
from starlette.requests import Request

from damperlab.service.answers import readiness_document
from damperlab.service.body import JSON_TYPES, ComputeQuery, media_type, read_body
from damperlab.service.documents import Document
from damperlab.service.examples import SIMULATE_BODY
from damperlab.service.problems import documented
from damperlab.service.simulation import compute, read_simulation, scenes_asked
from damperlab.service.state import Service, TheService
from damperlab.studies.text import load_text

router = APIRouter(prefix="/api/v1", tags=["simulate"])


@router.post(
    "/simulate",
    response_class=Document,
    responses=documented(413, 415, 422),
    openapi_extra={"requestBody": SIMULATE_BODY},
    summary="Compute one design point now",
)
async def ask_simulation(
    request: Request, service: TheService, query: Annotated[ComputeQuery, Query()]
) -> Document:
    """Compute a point from rest to its steady response, or for exactly `cycles` excitation cycles."""
    media_type(request, JSON_TYPES)
    body = await read_body(request, service.settings.body_limit_bytes)
    if query.dry_run:
        return await run_sync(_answer, service, body, True)
    return await run_sync(_answer, service, body, False, limiter=service.simulations)


def _answer(service: Service, body: bytes, dry_run: bool) -> Document:
    settings = service.settings
    asked = read_simulation(
        load_text(body, "json"), settings.simulate_cycles_limit, settings.simulate_history_limit
    )
    wanted = scenes_asked(asked, settings.simulate_cycles_limit)
    if dry_run:
        return Document(readiness_document(wanted))
    service.kernels.require(wanted)
    return Document(compute(asked, settings.simulate_cycles_limit))
