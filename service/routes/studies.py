"""Routes of studies: submit, list, show, follow, cancel, resume, delete."""

from collections.abc import AsyncIterator
from typing import Annotated, Any

from anyio.to_thread import run_sync
from fastapi import Depends, Header, Path, Query
from fastapi.sse import EventSourceResponse, ServerSentEvent
from pydantic import BaseModel, ConfigDict, Field
from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.responses import Response

from damperlab.service.answer_types import gives
from damperlab.service.batches import SubmittedBefore, SubmittedDocument, estimate_list, submit_list
from damperlab.service.body import JSON_TYPES, YAML_TYPES, DeleteQuery, media_type, read_body
from damperlab.service.documents import Document
from damperlab.service.estimates import estimate_document
from damperlab.service.events import event_id, progress
from damperlab.service.examples import STUDY_BODY
from damperlab.service.problems import Problem, documented
from damperlab.service.routes.strict import strict_router
from damperlab.service.security.caller import Caller, TheCaller, require_own
from damperlab.service.settings import Settings
from damperlab.service.state import Service, TheExactStudy, TheService, TheStudy
from damperlab.service.work.apart import computed, store_of
from damperlab.studies.definition import parse_study
from damperlab.studies.faults import Fault, StudyFaults
from damperlab.studies.plan import make_plan
from damperlab.studies.store.differences import DifferencesDocument, differences_of
from damperlab.studies.store.faults import StoreFault
from damperlab.studies.store.life_cycle.lookup import Wanted
from damperlab.studies.store.record import TRASH_DAYS, Record, RecordDocument, RecordPage, RecordsDocument
from damperlab.studies.store.store import Store
from damperlab.studies.text import Format, load_text
from damperlab.studies.vocabulary import PRIORITIES, State
from damperlab.worker.dispatch.cost_model import seconds_per_point
from damperlab.worker.provenance import provenance

router = strict_router("/api/v1/studies", "studies")


class SubmitQuery(BaseModel):
    """Parameters of a submission."""

    model_config = ConfigDict(extra="forbid")

    dry_run: bool = Field(False, description="Estimate the cost of the study, and store nothing.")
    reuse: bool = Field(
        True,
        description="Reuse points already computed by earlier studies with the same solver and settings.",
    )
    priority: int = Field(
        0,
        ge=PRIORITIES[0],
        le=PRIORITIES[1],
        description="The waiting study with the highest priority starts first. Below 0 it starts after "
        "those of others; above 0 it needs a key of scope admin. An existing study keeps its "
        "priority.",
    )


class ListQuery(BaseModel):
    """Parameters of the list of studies."""

    model_config = ConfigDict(extra="forbid")

    limit: int = Field(50, ge=1, le=200, description="Largest number of studies on one page.")
    cursor: str | None = Field(None, max_length=100, description="`cursor` of the previous page.")
    state: State | None = None
    name: str | None = Field(None, max_length=200, description="Only studies whose name contains this text.")
    tag: str | None = Field(None, max_length=200, description="Only studies with this tag.")
    axis: str | None = Field(None, max_length=200, description="Only studies that have this dimension.")
    low: float | None = Field(
        None, alias="from", description="Only studies whose largest value of `axis` is at least this."
    )
    high: float | None = Field(
        None, alias="to", description="Only studies whose smallest value of `axis` is at most this."
    )
    designs: bool = Field(
        False,
        description="Also list the studies of designs and refinements; a filter by name, tag or a state "
        "other than done includes them anyway.",
    )

    trash: bool = Field(False, description="List deleted studies that can be restored.")


class DifferencesQuery(BaseModel):
    """Parameters of a comparison of versions."""

    model_config = ConfigDict(extra="forbid")

    older: str | None = Field(
        None, max_length=200, description="Id of the other version; by default the previous one."
    )


@router.post(
    "",
    status_code=201,
    response_class=Document,
    responses={
        200: gives(SubmittedBefore, "The existing study, or the answer to a dry run"),
        201: gives(
            SubmittedDocument, "Stored and queued", Location="Address of the study, if a single one was sent."
        ),
        **documented(403, 413, 415, 422, 429, 503, 507),
    },
    openapi_extra={"requestBody": STUDY_BODY},
    summary="Submit a study",
)
async def submit(
    request: Request,
    service: TheService,
    query: Annotated[SubmitQuery, Query()],
    caller: TheCaller,
) -> Document:
    """Submit a study as JSON or YAML.

    If the same definition was submitted before, the answer is 200 with the existing study.

    A list of up to 200 studies is stored completely or not at all. The answer to a list has `studies`, which holds the
    records without definitions, in the order of the list. `created` in a record says whether the study is new.
    """
    _require_leave(caller, query.priority)
    kind = media_type(request, (*JSON_TYPES, *YAML_TYPES))
    body = await read_body(request, service.settings.body_limit_bytes)
    written_in: Format = "json" if kind in JSON_TYPES else "yaml"
    if query.dry_run:
        return await service.work.run(request, _estimated, service.settings, body, written_in)
    return await run_sync(_submit, service, body, written_in, query, limiter=service.submissions)


def _require_leave(caller: Caller, priority: int) -> None:
    """Raise `Problem` if the priority is above 0 and the key does not have scope admin."""
    if priority > 0 and "admin" not in caller.scopes:
        fault = Fault(
            "priority",
            str(priority),
            f"{PRIORITIES[0]} to 0 with a key of scope submit",
            "leave it out, or use a key of scope admin",
            f"A study with a priority above 0 starts before those of others; your key ({caller.owner}) does "
            "not allow this.",
        )
        raise Problem(403, "scope-lacking", "The key does not allow this priority.", (fault,))


def _estimated(settings: Settings, body: bytes, kind: Format) -> Document:
    document = load_text(body, kind, guarded=True)
    store = store_of(settings)
    if isinstance(document, list):
        return estimate_list(store, settings.records, document)
    study = parse_study(document, settings.records)
    return Document(estimate_document(study, make_plan(study, seconds_per_point), store))


def _submit(service: Service, body: bytes, kind: Format, query: SubmitQuery) -> Document:
    document = load_text(body, kind, guarded=True)
    if isinstance(document, list):
        reuse = query.reuse and service.settings.reuse
        return submit_list(service, document, reuse=reuse, priority=query.priority)
    study = parse_study(document, service.settings.records)
    plan = make_plan(study, seconds_per_point)
    reuse = query.reuse and service.settings.reuse
    record, created = service.store.submit(study, plan, provenance(), reuse=reuse, priority=query.priority)
    service.dispatcher.wake()
    return Document(record.document(), 201 if created else 200, {"Location": f"{router.prefix}/{record.id}"})


@router.get(
    "",
    response_class=Document,
    responses={200: gives(RecordPage), **documented(422, 503)},
    summary="A page of studies, newest first",
)
def list_studies(service: TheService, query: Annotated[ListQuery, Query()]) -> Document:
    """List the records of studies. The route of a single study also gives the definition.

    A filter by the range of an axis examines only part of a large catalogue for each page. So a page may be short or
    empty although `cursor` leads to further studies.
    """
    try:
        wanted = Wanted(
            state=query.state,
            name=query.name,
            tag=query.tag,
            axis=query.axis,
            low=query.low,
            high=query.high,
            designs=query.designs,
            trash=query.trash,
        )
        page = service.store.page(query.limit, query.cursor, wanted)
    except StoreFault as error:
        if error.fault.field in ("cursor", "tag", "axis", "from", "to"):
            raise StudyFaults((error.fault,)) from error
        raise
    return Document({"studies": [record.summary() for record in page.records], "cursor": page.cursor})


@router.get(
    "/{study_id}",
    response_class=Document,
    responses={200: gives(RecordDocument), **documented(404)},
    summary="A study's record",
)
async def show(study: TheStudy) -> Document:
    """Give the progress of the study, and the data needed to compute it again."""
    return Document(study.document())


async def _unless_seen(
    study: TheStudy,
    last_event_id: Annotated[str | None, Header(description="Sent by browsers that connect again.")] = None,
) -> str | None:
    if study.ended and last_event_id == event_id(study):
        # A browser reconnects when a stream ends; status 204 tells the browser that nothing more follows.
        raise HTTPException(204)
    return last_event_id


@router.get(
    "/{study_id}/events",
    response_class=EventSourceResponse,
    responses={
        204: {"description": "The study has ended, and the client has received this"},
        **documented(404, 429),
    },
    summary="Progress until the end, as server-sent events",
)
async def events(
    service: TheService, study: TheStudy, last_seen: Annotated[str | None, Depends(_unless_seen)]
) -> AsyncIterator[ServerSentEvent]:
    """Send the event `progress` at every change, and `end` when the study has ended."""
    async for event in progress(service, study, last_seen):
        yield event


@router.post(
    "/{study_id}/cancel",
    response_class=Document,
    responses={200: gives(RecordDocument), **documented(404, 409)},
    summary="Stop a study",
)
def cancel(service: TheService, study: TheExactStudy) -> Document:
    """Cancel a queued or running study. Computed points are kept, and `resume` computes the missing points."""
    record = service.dispatcher.cancel(study)
    if record.state != "cancelled":
        raise Problem(409, "study-ended", f"The study is {record.state}: there is nothing left to cancel.")
    return Document(record.document())


@router.post(
    "/{study_id}/resume",
    response_class=Document,
    responses={200: gives(RecordDocument), **documented(404, 409, 429)},
    summary="Resume a study",
)
def resume(service: TheService, study: TheExactStudy) -> Document:
    """Queue a cancelled or failed study again. Only the missing blocks are computed."""
    record = service.dispatcher.resume(study)
    if record.state == "done":
        raise Problem(409, "study-ended", "The study is done: there is nothing left to compute.")
    return Document(record.document())


@router.post(
    "/{study_id}/retry",
    response_class=Document,
    responses={200: gives(RecordDocument), **documented(404, 409, 429, 503)},
    summary="Compute failed blocks again",
)
def retry(service: TheService, study: TheExactStudy) -> Document:
    """Queue the failed blocks. Points that failed numerically are not queued, because they would fail again."""
    return Document(service.dispatcher.retry(study).document())


@router.post(
    "/{study_id}/recompute",
    status_code=201,
    response_class=Document,
    responses={
        200: gives(RecordDocument, "The present solver's version, which is already stored or queued"),
        201: gives(
            RecordDocument, "The new version; the older results are kept", Location="Address of the version."
        ),
        **documented(404, 409, 429, 503, 507),
    },
    summary="Recompute an outdated study, and keep its results",
)
def recompute(service: TheService, study: TheExactStudy) -> Document:
    """Queue a new version of a study. The older version is kept until it is deleted."""
    record, created = service.store.recompute(study.id, provenance())
    service.dispatcher.wake()
    return Document(record.document(), 201 if created else 200, {"Location": f"{router.prefix}/{record.id}"})


@router.get(
    "/{study_id}/versions",
    response_class=Document,
    responses={200: gives(RecordsDocument), **documented(404)},
    summary="Every version of a study, oldest first",
)
def versions(service: TheService, study: TheStudy) -> Document:
    """List the records of all versions of a study, without the definition, which is the same for all versions."""
    return Document({"studies": [record.summary() for record in service.store.versions(study.id)]})


@router.get(
    "/{study_id}/differences",
    response_class=Document,
    responses={200: gives(DifferencesDocument), **documented(404, 409, 422, 429, 503)},
    summary="How a version differs from an older one",
)
async def differences(
    request: Request, service: TheService, study: TheStudy, query: Annotated[DifferencesQuery, Query()]
) -> Document:
    """Give the number of points in which two versions differ, and the largest difference of each variable."""
    found = await computed(request, service, study, _differences, query.older)
    # not cached: after a deletion, another study may be the previous version of this unchanged study
    return Document(found, headers={} if query.older else {"Cache-Control": "no-store"})


def _differences(store: Store, study: Record, older: str | None) -> dict[str, Any]:
    return differences_of(store, study, store.find(older) if older else None).document()


@router.delete(
    "/{study_id}",
    status_code=204,
    responses=documented(404, 409),
    summary="Delete a study and its cube",
)
def delete(service: TheService, study: TheExactStudy, query: Annotated[DeleteQuery, Query()]) -> Response:
    """Delete a study that is not running."""
    service.dispatcher.delete(study, 86_400.0 * TRASH_DAYS if query.trash else 0.0)
    return Response(status_code=204)


@router.post(
    "/{study_id}/undelete",
    response_class=Document,
    responses={200: gives(RecordDocument), **documented(404, 409, 503)},
    summary="Restore a study from the trash",
)
def undelete(
    service: TheService,
    caller: TheCaller,
    study_id: Annotated[str, Path(description="Id or name of a deleted study.")],
) -> Document:
    """Restore a study that was deleted with `trash`, with all its results."""
    trashed = service.store.trashed(study_id)
    require_own(caller, trashed)
    record = service.store.undelete(trashed.id)
    service.dispatcher.wake()
    return Document(record.document())
