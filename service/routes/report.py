"""Route of the report, which presents a study as one document."""

import re
from typing import Annotated, Any

from fastapi import Query
from pydantic import BaseModel, ConfigDict, Field
from starlette.requests import Request
from starlette.responses import HTMLResponse, Response

from damperlab.service.printing import printed
from damperlab.service.problems import documented
from damperlab.service.questions.question import Subject
from damperlab.service.routes.questions import router as questions
from damperlab.service.routes.strict import strict_router
from damperlab.service.state import Service, TheService, TheStudy
from damperlab.service.work.apart import computed
from damperlab.studies.store.record import Record
from damperlab.studies.store.store import Store
from damperlab.studies.vocabulary import DocumentFormat

router = strict_router(questions.prefix, "queries")

POLICY = (
    "default-src 'none'; style-src 'unsafe-inline'; img-src data:; base-uri 'none'; form-action 'none'; "
    "frame-ancestors 'none'"
)
"""Content security policy of the document, which loads nothing and has no scripts."""


PDF = "application/pdf"


class ReportQuery(BaseModel):
    """Parameters of a report."""

    model_config = ConfigDict(extra="forbid")

    format: DocumentFormat = Field(
        "html",
        description="One HTML page without external files, or A4 pages as PDF. The service may lack the "
        "libraries for PDF.",
    )


DOCUMENT: dict[str, Any] = {
    "description": "The document",
    "content": {
        "text/html": {"schema": {"type": "string"}},
        PDF: {"schema": {"type": "string", "format": "binary"}},
    },
}


async def document(request: Request, service: Service, query: ReportQuery, text: str, name: str) -> Response:
    """Answer with a page of HTML, or print the page as PDF. `name` is the name of the file without suffix."""
    headers = {"Content-Disposition": f'inline; filename="{name}.{query.format}"'}
    if query.format == "pdf":
        return Response(await service.work.run(request, printed, text), media_type=PDF, headers=headers)
    return HTMLResponse(text, headers=headers | {"Content-Security-Policy": POLICY})


def stem(name: str, otherwise: str) -> str:
    """Convert free text into a file name without suffix; `otherwise` replaces a text without usable characters."""
    return re.sub(r"[^A-Za-z0-9._-]+", "-", name).strip("-.") or otherwise


@router.get(
    "/report",
    response_class=HTMLResponse,
    responses={200: DOCUMENT, **documented(404, 409, 422, 429, 503)},
    summary="The study as a document to keep or to print",
)
async def ask_report(
    request: Request, service: TheService, study: TheStudy, query: Annotated[ReportQuery, Query()]
) -> Response:
    """Write maps, designs, a comparison with a tuned mass damper, accuracy, cost and versions into one document."""
    text = await computed(request, service, study, _report)
    return await document(request, service, query, text, f"{stem(study.name, 'study')}-{study.id}")


def _report(store: Store, study: Record) -> str:
    from damperlab.service.study_report import study_report

    return study_report(Subject(study, store, "report"))
