"""Routes that report whether the process is alive, and whether it can accept studies."""

from typing import Literal

from fastapi import Request
from typing_extensions import TypedDict

from damperlab.service.answer_types import gives
from damperlab.service.cluster import ClusterState
from damperlab.service.documents import Document
from damperlab.service.problems import Problem, documented
from damperlab.service.routes.strict import strict_router
from damperlab.service.state import Service

router = strict_router("/health", "health")


class Live(TypedDict):
    """Answer of a process that is alive."""

    status: Literal["live"]


class Ready(TypedDict):
    """Answer of a process that accepts studies, with the state of the cluster."""

    status: Literal["ready"]
    cluster: ClusterState
    cluster_message: str | None
    running: list[str]


@router.get("/live", response_class=Document, responses={200: gives(Live)}, summary="The process answers")
async def live() -> Document:
    """Return the answer from the event loop, so that computations do not delay the answer."""
    return Document(Live(status="live"))


@router.get(
    "/ready",
    response_class=Document,
    responses={200: gives(Ready), **documented(503)},
    summary="Studies can be submitted, queried and run",
)
async def ready(request: Request) -> Document:
    """Say whether the last check of store, folders and threads found a problem, and give the state of the cluster."""
    # This function waits neither for a store or a lock, nor for a pool of threads that other requests may occupy.
    service: Service = request.app.state.service
    if service.closing.is_set():
        raise Problem(503, "closing", "The service is shutting down.")
    problem = service.readiness.problem()
    if problem is not None:
        raise problem
    dispatcher = service.dispatcher
    return Document(
        Ready(
            status="ready",
            cluster=dispatcher.cluster.state,
            cluster_message=dispatcher.trouble,
            running=dispatcher.running,
        )
    )
