"""Route that estimates parameters of a prototype from its measured frequency response or time history."""

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
from damperlab.service.examples import FIT_BODY
from damperlab.service.fit_report import FittedDocument
from damperlab.service.history_report import FittedHistoryDocument
from damperlab.service.problems import documented
from damperlab.service.routes.strict import strict_router
from damperlab.service.state import TheService
from damperlab.service.work.functions import fit_asked, fit_body
from damperlab.service.work.later import PROMISED

router = strict_router("/api/v1", "fits")

FittedOrReadiness = TypeAliasType("FittedOrReadiness", FittedDocument | FittedHistoryDocument | Readiness)


@router.post(
    "/fits",
    response_class=Document,
    responses={200: gives(FittedOrReadiness), 202: PROMISED, **documented(413, 415, 422, 429, 503)},
    openapi_extra={"requestBody": FIT_BODY},
    summary="Estimate parameters from a measured response or time history",
)
async def ask_fit(request: Request, service: TheService, query: Annotated[ComputeQuery, Query()]) -> Response:
    """Give the output of `damperlab fit --json`. Use the command line for fits beyond the time limit."""
    media_type(request, JSON_TYPES)
    body = await read_body(request, service.settings.body_limit_bytes)
    asked, wanted = await service.work.run(request, fit_asked, body)
    if query.dry_run:
        return Document(await run_sync(readiness_document, wanted))
    await run_sync(service.kernels.require, wanted, limiter=service.compiling)
    return Response(await service.work.run(request, fit_body, asked), media_type=JSON_TYPES[0])
