"""Whether the process lives, and whether it can serve."""

from fastapi import APIRouter

from damperlab.service.documents import Document
from damperlab.service.problems import Problem
from damperlab.service.state import TheService
from damperlab.studies.store.faults import StoreFault

router = APIRouter(prefix="/health", tags=["health"])


@router.get("/live", response_class=Document, summary="The process answers")
async def live() -> Document:
    """Answer from the event loop itself: whatever computes, this does not wait."""
    return Document({"status": "live"})


@router.get("/ready", response_class=Document, summary="Studies can be taken, queried and run")
def ready(service: TheService) -> Document:
    """Ask the store one question, and say how the cluster is."""
    if service.closing.is_set():
        raise Problem(503, "closing", "The service is shutting down.")
    try:
        service.store.page(limit=1)
    except StoreFault as error:
        raise Problem(503, "store-unavailable", "The service cannot use its data.", (error.fault,)) from error
    dispatcher = service.dispatcher
    return Document(
        {
            "status": "ready",
            "cluster": dispatcher.cluster.state,
            "cluster_message": dispatcher.trouble,
            "running": dispatcher.running,
        }
    )
