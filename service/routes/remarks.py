"""Routes that change the tags, the note and the name of a study, or the name of a design."""

from collections.abc import Sequence
from typing import Any

from anyio.to_thread import run_sync
from starlette.requests import Request

from damperlab.service.answer_types import gives
from damperlab.service.body import JSON_TYPES, media_type, read_body
from damperlab.service.documents import Document
from damperlab.service.problems import documented
from damperlab.service.routes.designs import DesignDocument, shown
from damperlab.service.routes.designs import router as designs
from damperlab.service.routes.strict import strict_router
from damperlab.service.state import Service, TheExactDesign, TheExactStudy, TheService
from damperlab.studies.definition import MAX_NAME
from damperlab.studies.remarks import KNOWN, MOST_NOTE, MOST_TAGS, TAG, Remarks, read_remarks
from damperlab.studies.store.record import RecordDocument
from damperlab.studies.text import load_text

router = strict_router()

_TAGS = {"type": "array", "maxItems": MOST_TAGS, "items": {"type": "string", "pattern": f"^{TAG.pattern}$"}}
_PROPERTIES: dict[str, dict[str, Any]] = {
    "tags": _TAGS | {"description": "All tags from now on; the list may be empty."},
    "note": {"type": "string", "maxLength": MOST_NOTE, "description": "Empty for none."},
    "name": {
        "type": "string",
        "minLength": 1,
        "maxLength": MAX_NAME,
        "description": "The new name; the definition is unchanged.",
    },
}
_EXAMPLES = {
    "both": {
        "summary": "Tags and a note",
        "value": {"tags": ["rig-2", "steel"], "note": "Measured on the shaker in May."},
    },
    "none": {"summary": "Remove all tags, keep the note", "value": {"tags": []}},
}
_NAME_ALONE = ("name",)


def _body(known: Sequence[str], examples: dict[str, Any]) -> dict[str, Any]:
    schema = {
        "type": "object",
        "additionalProperties": False,
        "minProperties": 1,
        "properties": {name: _PROPERTIES[name] for name in known},
    }
    return {
        "requestBody": {
            "required": True,
            "content": {"application/json": {"schema": schema, "examples": examples}},
        }
    }


async def _read(request: Request, service: Service, known: Sequence[str]) -> Remarks:
    media_type(request, JSON_TYPES)
    body = await read_body(request, service.settings.body_limit_bytes)
    return read_remarks(load_text(body, "json"), known)


@router.patch(
    "/api/v1/studies/{study_id}",
    response_class=Document,
    responses={200: gives(RecordDocument), **documented(404, 413, 415, 422, 503)},
    openapi_extra=_body(KNOWN, _EXAMPLES),
    summary="Tag or rename a study, or write a note to it",
    tags=["studies"],
)
async def remark(request: Request, service: TheService, study: TheExactStudy) -> Document:
    """Store tags, a note or a new name with a study. The definition and the results of the study are unchanged."""
    remarks = await _read(request, service, KNOWN)
    record = await run_sync(service.dispatcher.remark, study.id, remarks)
    return Document(record.document())


@router.patch(
    f"{designs.prefix}/{{design_id}}",
    response_class=Document,
    responses={200: gives(DesignDocument), **documented(404, 413, 415, 422, 503)},
    openapi_extra=_body(
        _NAME_ALONE, {"name": {"summary": "Another name", "value": {"name": "pump, second draft"}}}
    ),
    summary="Rename a design",
    tags=["designs"],
)
async def rename(request: Request, service: TheService, design: TheExactDesign) -> Document:
    """Store a new name with a design. The name in the specification is unchanged."""
    remarks = await _read(request, service, _NAME_ALONE)
    return await run_sync(_rename, service, design.id, remarks.name or "")


def _rename(service: Service, design_id: str, name: str) -> Document:
    service.designer.shelf.rename(design_id, name)
    return Document(shown(service, service.designer.shelf.get(design_id)))
