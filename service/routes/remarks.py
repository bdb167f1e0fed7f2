"""Tags, notes and other names of studies."""

from anyio.to_thread import run_sync
from fastapi import APIRouter
from starlette.requests import Request

from damperlab.service.answer_schemas import gives
from damperlab.service.body import JSON_TYPES, media_type, read_body
from damperlab.service.documents import Document
from damperlab.service.problems import documented
from damperlab.service.state import TheExactStudy, TheService
from damperlab.studies.definition import MAX_NAME
from damperlab.studies.remarks import MOST_NOTE, MOST_TAGS, TAG, read_remarks
from damperlab.studies.text import load_text

router = APIRouter(prefix="/api/v1/studies", tags=["studies"])

_TAGS = {"type": "array", "maxItems": MOST_TAGS, "items": {"type": "string", "pattern": f"^{TAG.pattern}$"}}
_BODY = {
    "required": True,
    "content": {
        "application/json": {
            "schema": {
                "type": "object",
                "additionalProperties": False,
                "minProperties": 1,
                "properties": {
                    "tags": _TAGS | {"description": "All tags from now on; the list may be empty."},
                    "note": {"type": "string", "maxLength": MOST_NOTE, "description": "Empty for none."},
                    "name": {
                        "type": "string",
                        "maxLength": MAX_NAME,
                        "description": "What it is called from now on; its definition stays as it is.",
                    },
                },
            },
            "examples": {
                "both": {
                    "summary": "Tags and a note",
                    "value": {"tags": ["rig-2", "steel"], "note": "Measured on the shaker in May."},
                },
                "none": {"summary": "No tag any more, the note as it is", "value": {"tags": []}},
            },
        }
    },
}


@router.patch(
    "/{study_id}",
    response_class=Document,
    responses={200: gives("Record"), **documented(404, 413, 415, 422, 503)},
    openapi_extra={"requestBody": _BODY},
    summary="Tag a study, write a note to it, or call it something else",
)
async def remark(request: Request, service: TheService, study: TheExactStudy) -> Document:
    """Keep tags, a note and another name with a study. They are no part of what it asks, and change nothing computed."""
    media_type(request, JSON_TYPES)
    body = await read_body(request, service.settings.body_limit_bytes)
    remarks = read_remarks(load_text(body, "json"))
    record = await run_sync(service.dispatcher.remark, study.id, remarks)
    return Document(record.document())
