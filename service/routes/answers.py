"""Routes at which deferred answers are fetched or cancelled."""

from typing import Annotated

from fastapi import Depends, Path
from starlette.requests import Request
from starlette.responses import Response
from typing_extensions import TypeAliasType

from damperlab.service.answer_types import gives
from damperlab.service.documents import Document
from damperlab.service.earthquakes import ComparedDocument
from damperlab.service.estimates import Readiness
from damperlab.service.fit_report import FittedDocument
from damperlab.service.history_report import FittedHistoryDocument
from damperlab.service.problems import documented
from damperlab.service.routes.strict import strict_router
from damperlab.service.security.caller import TheCaller
from damperlab.service.simulation import SimulatedDocument
from damperlab.service.work.later import PROMISED, Promise, Promises, promised

router = strict_router("/api/v1/answers", "answers")

PromisedAnswer = TypeAliasType(
    "PromisedAnswer",
    SimulatedDocument | Readiness | ComparedDocument | FittedDocument | FittedHistoryDocument,
)


async def _promises(request: Request) -> Promises:
    promises = request.app.state.promises
    assert isinstance(promises, Promises)
    return promises


async def _promise(
    promises: Annotated[Promises, Depends(_promises)],
    caller: TheCaller,
    answer_id: Annotated[str, Path(description="Id in the address of the deferred answer.")],
) -> Promise:
    return promises.find(answer_id, caller.name)


ThePromise = Annotated[Promise, Depends(_promise)]


@router.get(
    "/{answer_id}",
    response_class=Document,
    responses={
        200: gives(PromisedAnswer),
        202: PROMISED,
        **documented(404, 413, 415, 422, 429, 503),
    },
    summary="Fetch a deferred answer",
)
async def fetch(promise: ThePromise) -> Response:
    """Give the deferred answer with its own status, or status 202 while the answer is being computed.

    An answer is deferred if the request allows this (`Prefer: respond-async, wait=5`) and the answer takes longer than
    the given wait. The answer is kept for ten minutes, for the caller who sent the request.
    """
    if promise.ended is None:
        return promised(promise)
    answer = Response(promise.body, promise.status)
    answer.raw_headers = [*promise.headers]
    return answer


@router.delete(
    "/{answer_id}",
    status_code=204,
    response_class=Response,
    responses=documented(404),
    summary="Cancel a deferred answer",
)
async def give_up(promise: ThePromise, promises: Annotated[Promises, Depends(_promises)]) -> Response:
    """Stop the computation of a deferred answer. If the answer is complete already, delete it."""
    promises.give_up(promise)
    return Response(status_code=204)
