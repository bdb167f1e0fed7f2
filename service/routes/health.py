"""Whether the process lives, and whether it can serve."""

from fastapi import APIRouter

from damperlab.service.answer_schemas import gives
from damperlab.service.documents import Document
from damperlab.service.problems import Problem, documented
from damperlab.service.readiness import ANSWER_SECONDS
from damperlab.service.state import TheService

router = APIRouter(prefix="/health", tags=["health"])


@router.get("/live", response_class=Document, responses={200: gives("Live")}, summary="The process answers")
async def live() -> Document:
    """Answer from the event loop itself: whatever computes, this does not wait."""
    return Document({"status": "live"})


@router.get(
    "/ready",
    response_class=Document,
    responses={200: gives("Ready"), **documented(503)},
    summary="Studies can be taken, queried and run",
)
async def ready(service: TheService) -> Document:
    """Ask the store one question, and say how the cluster is; within two seconds, also while the store hangs."""
    if service.closing.is_set():
        raise Problem(503, "closing", "The service is shutting down.")
    try:
        fault = await service.readiness.fault()
    except TimeoutError:
        raise Problem(
            503, "store-unavailable", f"The service's data has not answered within {ANSWER_SECONDS:g} s."
        ) from None
    if fault is not None:
        raise Problem(503, "store-unavailable", "The service cannot use its data.", (fault.fault,))
    dispatcher = service.dispatcher
    return Document(
        {
            "status": "ready",
            "cluster": dispatcher.cluster.state,
            "cluster_message": dispatcher.trouble,
            "running": dispatcher.running,
        }
    )
