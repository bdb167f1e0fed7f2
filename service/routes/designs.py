"""Routes of designs and their reports: submit, list, show, cancel, resume, delete, restore."""

from contextlib import suppress
from typing import Annotated

from anyio.to_thread import run_sync
from fastapi import Path, Query
from pydantic import BaseModel, ConfigDict, Field
from starlette.requests import Request
from starlette.responses import HTMLResponse, Response
from typing_extensions import TypeAliasType, TypedDict

from damperlab.service.answer_types import declare, gives
from damperlab.service.body import JSON_TYPES, YAML_TYPES, DeleteQuery, media_type, read_body
from damperlab.service.design_budget import DesignSize, size_document
from damperlab.service.documents import Document
from damperlab.service.examples import SPECIFICATION_BODY
from damperlab.service.problems import Problem, documented
from damperlab.service.routes.report import DOCUMENT, ReportQuery, document, stem
from damperlab.service.routes.strict import strict_router
from damperlab.service.security.caller import TheCaller, require_owner
from damperlab.service.state import Service, TheDesign, TheExactDesign, TheService
from damperlab.service.work.functions import specified
from damperlab.studies.design.answer import DesignAnswer
from damperlab.studies.design.kept import DesignSummary, Kept, KeptDocument
from damperlab.studies.shapes import Count, Says
from damperlab.studies.specification.specification import Specification
from damperlab.studies.store.faults import StudyNotFound
from damperlab.studies.text import Format
from damperlab.studies.vocabulary import State

router = strict_router("/api/v1/designs", "designs")


class DesignPage(TypedDict):
    """A page of designs."""

    designs: list[DesignSummary]
    cursor: str | None


class DesignDocument(KeptDocument):
    """A design with the progress of its studies and its answer."""

    studies_done: Count
    points_of_round: Annotated[Count, Says(description="Computed points of the round's studies.")]
    answer: DesignAnswer | None


declare(DesignAnswer, DesignSummary)
DesignOrBudget = TypeAliasType("DesignOrBudget", DesignDocument | DesignSize)


class AskQuery(BaseModel):
    """Parameters of the request for a design."""

    model_config = ConfigDict(extra="forbid")

    dry_run: bool = Field(
        False, description="Give the number of points that the budget allows; store and compute nothing."
    )


class DesignsQuery(BaseModel):
    """Parameters of the list of designs."""

    model_config = ConfigDict(extra="forbid")

    limit: int = Field(50, ge=1, le=200, description="Largest number of designs on one page.")
    cursor: str | None = Field(
        None, pattern="^[0-9]{20}-[0-9a-f]{12}$", description="`cursor` of the previous page."
    )
    state: State | None = None
    name: str | None = Field(None, max_length=200, description="Only designs whose name contains this text.")
    trash: bool = Field(False, description="List deleted designs that can be restored.")


@router.post(
    "",
    status_code=201,
    response_class=Document,
    responses={
        200: gives(DesignOrBudget, "The existing design, or the answer to a dry run"),
        201: gives(DesignDocument, "The new design, stored and queued", Location="Address of the design."),
        **documented(413, 415, 422, 429, 503, 507),
    },
    openapi_extra={"requestBody": SPECIFICATION_BODY},
    summary="Ask for a design",
)
async def ask(request: Request, service: TheService, query: Annotated[AskQuery, Query()]) -> Document:
    """Submit a specification as JSON or YAML.

    If the specification was submitted before, the answer is 200 with the existing design. An existing design that was
    cancelled or has failed must be resumed with the route `resume`.
    """
    kind = media_type(request, (*JSON_TYPES, *YAML_TYPES))
    body = await read_body(request, service.settings.body_limit_bytes)
    written_in: Format = "json" if kind in JSON_TYPES else "yaml"
    asked, budget, unusual = await service.work.run(
        request, specified, body, written_in, service.settings.records
    )
    if query.dry_run:
        return Document(size_document(asked, budget, unusual))
    return await run_sync(_keep, service, asked, budget, limiter=service.submissions)


def _keep(service: Service, asked: Specification, budget: int) -> Document:
    kept, new = service.designer.shelf.put(asked, budget)
    service.designer.wake()
    return Document(shown(service, kept), 201 if new else 200, {"Location": f"{router.prefix}/{kept.id}"})


@router.get(
    "",
    response_class=Document,
    responses={200: gives(DesignPage), **documented(422, 503)},
    summary="A page of designs, newest first",
)
def list_designs(service: TheService, query: Annotated[DesignsQuery, Query()]) -> Document:
    """List designs. The route of a single design also gives its specification and its answer."""
    fitting = [
        each
        for each in service.designer.shelf.every(query.trash)
        if (query.cursor is None or each.place < query.cursor)
        and query.state in (None, each.state)
        and (query.name or "").lower() in each.name.lower()
    ]
    page = fitting[: query.limit]
    last = page[-1].place if len(fitting) > len(page) else None
    return Document(DesignPage(designs=[each.summary() for each in page], cursor=last))


@router.get(
    "/{design_id}",
    response_class=Document,
    responses={200: gives(DesignDocument), **documented(404, 503)},
    summary="A design: its progress and its answer",
)
def show(service: TheService, design: TheDesign) -> Document:
    """Give the progress of a design. Once the design is done, `answer` is the output of `damperlab design --json`."""
    return Document(shown(service, design))


@router.get(
    "/{design_id}/report",
    response_class=HTMLResponse,
    responses={200: DOCUMENT, **documented(404, 409, 422, 429, 503)},
    summary="The answer as a document to sign or to print",
)
async def ask_report(
    request: Request, service: TheService, design: TheDesign, query: Annotated[ReportQuery, Query()]
) -> Response:
    """Give the report of a design.

    The report contains the values for the drawing with tolerances, the response compared with other dampers, and the
    reasons for the choice.
    """
    if design.state != "done":
        raise Problem(
            409,
            "design-not-done",
            f"The design is {design.state}; a report exists only once it has an answer.",
        )
    text = (await run_sync(service.designer.shelf.report, design.id)).decode()
    return await document(request, service, query, text, f"{stem(design.name, 'design')}-{design.id}")


@router.post(
    "/{design_id}/cancel",
    response_class=Document,
    responses={200: gives(DesignDocument), **documented(404, 409, 503)},
    summary="Stop a design",
)
def cancel(service: TheService, design: TheExactDesign) -> Document:
    """Cancel a design and its unfinished studies. Computed points are kept; `resume` continues the design."""
    kept = service.designer.cancel(design)
    if kept.state != "cancelled":
        raise Problem(409, "design-ended", f"The design is {kept.state}: there is nothing left to cancel.")
    return Document(shown(service, kept))


@router.post(
    "/{design_id}/resume",
    response_class=Document,
    responses={200: gives(DesignDocument), **documented(404, 409, 503)},
    summary="Resume a design",
)
def resume(service: TheService, design: TheExactDesign) -> Document:
    """Resume a design that was cancelled or has failed. Studies that are complete are not computed again."""
    kept = service.designer.resume(design)
    if kept.state == "done":
        raise Problem(409, "design-ended", "The design is done: there is nothing left to compute.")
    return Document(shown(service, kept))


@router.delete(
    "/{design_id}",
    status_code=204,
    responses=documented(404, 409, 503),
    summary="Delete a design and its answer",
)
def delete(service: TheService, design: TheExactDesign, query: Annotated[DeleteQuery, Query()]) -> Response:
    """Delete a design that has ended. The studies of the design are kept."""
    service.designer.shelf.delete(design, query.trash)
    return Response(status_code=204)


@router.post(
    "/{design_id}/undelete",
    response_class=Document,
    responses={200: gives(DesignDocument), **documented(404, 503)},
    summary="Restore a design from the trash",
)
def undelete(
    service: TheService,
    caller: TheCaller,
    design_id: Annotated[str, Path(max_length=200, description="A design's whole id.")],
) -> Document:
    """Restore a design and its answer, if the design was deleted with `trash`."""
    shelf = service.designer.shelf
    require_owner(caller, shelf.trashed(design_id).owner, "design")
    return Document(shown(service, shelf.undelete(design_id)))


def shown(service: Service, kept: Kept) -> DesignDocument:
    """Return the document of a design, with the progress of its studies and with its answer."""
    done = points = 0
    waited_for = () if kept.round is None or kept.ended else kept.round.studies
    for study_id in waited_for:
        with suppress(StudyNotFound):
            record = service.store.find(study_id)
            done += record.state == "done"
            points += record.points_done
    return {
        **kept.document(),
        "studies_done": done,
        "points_of_round": points,
        "answer": service.designer.shelf.answer(kept.id) if kept.state == "done" else None,
    }
