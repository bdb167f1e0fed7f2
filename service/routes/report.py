"""A study as one document."""

import re

from fastapi import APIRouter
from starlette.responses import HTMLResponse

from damperlab.service.problems import documented
from damperlab.service.routes.queries import router as queries
from damperlab.service.state import TheService, TheStudy
from damperlab.service.study_report import study_report

router = APIRouter(prefix=queries.prefix, tags=["queries"], dependencies=queries.dependencies)

POLICY = (
    "default-src 'none'; style-src 'unsafe-inline'; img-src data:; base-uri 'none'; form-action 'none'; "
    "frame-ancestors 'none'"
)
"""The document loads nothing, and runs nothing: its style and its figures are in it."""


@router.get(
    "/report",
    response_class=HTMLResponse,
    responses={
        200: {"description": "The document", "content": {"text/html": {"schema": {"type": "string"}}}},
        **documented(404, 409, 422, 429, 503),
    },
    summary="The study as a document to keep or to print",
)
def ask_report(service: TheService, study: TheStudy) -> HTMLResponse:
    """Write maps, designs, a tuned mass damper beside the best, accuracy, cost and versions into one page of HTML."""
    stem = re.sub(r"[^A-Za-z0-9._-]+", "-", study.name).strip("-.") or "study"
    headers = {
        "Content-Security-Policy": POLICY,
        "Content-Disposition": f'inline; filename="{stem}-{study.id}.html"',
    }
    return HTMLResponse(study_report(study, service.store.cube(study.id)), headers=headers)
