"""Responses to errors: problem documents (RFC 9457) with the value found, the allowed values, and a remedy."""

import re
from collections.abc import Iterable, Mapping, Sequence
from http import HTTPStatus
from typing import Any

from fastapi import FastAPI
from fastapi.exceptions import RequestValidationError
from starlette.exceptions import HTTPException
from starlette.requests import ClientDisconnect, Request
from starlette.responses import Response

from damperlab.service.documents import Document
from damperlab.studies.answers.query_fault import QueryFault
from damperlab.studies.design.shelf import DesignBusy, DesignDamaged, DesignNotFound, DesignsFull
from damperlab.studies.faults import NOTHING, PARTS, Fault, StudyFaults, listing, nearest, path, printable
from damperlab.studies.ground.shelf import RecordDamaged, RecordKept, RecordNotFound, ShelfFull
from damperlab.studies.pydantic_faults import value_fault
from damperlab.studies.store.faults import (
    BlockDamaged,
    CatalogueDamaged,
    NothingToDo,
    QuotaReached,
    RevisionGone,
    StoreFault,
    StudyBusy,
    StudyNotFound,
    TooManyUnfinished,
    cannot_use,
)

MEDIA_TYPE = "application/problem+json"
RETRY_SECONDS = 10
"""Time after which a client may repeat a request that failed for a temporary reason [s]."""

MOST_FAULTS = 10
"""Largest number of invalid parameters in a problem document. Each parameter is compared with all known names."""

PROBLEM_SCHEMA: dict[str, Any] = {
    "type": "object",
    "required": ["type", "title", "status", "detail"],
    "properties": {
        "type": {"type": "string"},
        "title": {"type": "string"},
        "status": {"type": "integer"},
        "detail": {"type": "string"},
        "instance": {"type": "string"},
        "request_id": {"type": "string"},
        "errors": {
            "type": "array",
            "items": {
                "type": "object",
                "required": list(PARTS),
                "properties": {name: {"type": "string"} for name in PARTS},
            },
        },
    },
}


def documented(*statuses: int) -> dict[int | str, dict[str, Any]]:
    """Return the ``responses`` of a route for OpenAPI: a problem document for each of the given statuses."""
    content = {MEDIA_TYPE: {"schema": {"$ref": "#/components/schemas/Problem"}}}
    return {status: {"description": HTTPStatus(status).phrase, "content": content} for status in statuses}


class Problem(Exception):
    """Exception for a request that cannot be served.

    Parameters
    ----------
    status : int
        HTTP status, 400 or above.
    kind : str
        Short name of the kind of problem, for programs. The ``type`` of the document is
        ``urn:damperlab:problem:<kind>``.
    detail : str
        One or two sentences that state what happened, and the remedy.
    faults : iterable of Fault
        Faults of the request, one for each invalid value.
    headers : mapping, optional
        Additional headers of the response.
    """

    def __init__(
        self,
        status: int,
        kind: str,
        detail: str,
        faults: Iterable[Fault] = (),
        headers: Mapping[str, str] | None = None,
    ) -> None:
        super().__init__(detail)
        self.status = status
        self.kind = kind
        self.detail = detail
        self.faults = tuple(faults)
        self.headers = dict(headers or {})

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle all attributes, because a problem is sent between processes."""
        return type(self), (self.status, self.kind, self.detail, self.faults, self.headers)


def lacking(names: Iterable[str], allowed: Iterable[str]) -> Problem:
    """Return the exception for a request that lacks parameters for some dimensions.

    Parameters
    ----------
    names : iterable of str
        Missing parameters.
    allowed : iterable of str
        Dimensions of the study.
    """
    faults = [Fault(name, NOTHING, f"one of {listing(allowed)}", "add it") for name in names]
    return Problem(422, "invalid-parameters", "The address of the request has faults.", faults)


def install(app: FastAPI) -> None:
    """Make an application answer every error with a problem document, including errors of FastAPI."""
    app.add_exception_handler(Problem, _problem)
    app.add_exception_handler(StudyFaults, _faults)
    app.add_exception_handler(QueryFault, _query)
    app.add_exception_handler(StoreFault, store_problem)
    app.add_exception_handler(OSError, _disk)
    app.add_exception_handler(RequestValidationError, _bad_parameters)
    app.add_exception_handler(HTTPException, _http)
    app.add_exception_handler(ClientDisconnect, _gone)
    app.add_exception_handler(Exception, _bug)


def invalid(entries: Sequence[Mapping[str, Any]], known: Sequence[str] = ()) -> tuple[Fault, ...]:
    """Convert validation errors of pydantic to faults.

    Parameters
    ----------
    entries : sequence of mappings
        Errors from ``ValidationError.errors()``. Only the first `MOST_FAULTS` errors are converted.
    known : sequence of str
        Names of the allowed parameters.
    """
    return tuple(_fault(entry, known) for entry in entries[:MOST_FAULTS])


def _fault(entry: Mapping[str, Any], known: Sequence[str]) -> Fault:
    place = entry["loc"][1:] if entry["loc"][:1] in (("query",), ("path",), ("header",)) else entry["loc"]
    field = path(place) or "body"
    match entry["type"]:
        case "extra_forbidden":
            meant = nearest(str(place[-1]), known)
            advice = f"did you mean {meant}?" if meant else "leave it out"
            told = f"{{field}} is not a parameter of this question{f'; its parameters are {listing(known)}' if known else ''}."
            return Fault(field, "an unknown name", listing(known) or "no parameters at all", advice, told)
        case "missing":
            return Fault(field, NOTHING, "a value", "add it", "{field} is missing.")
    return value_fault(field, entry)


def respond(request: Request, problem: Problem) -> Response:
    """Return a response that contains the problem document (RFC 9457)."""
    phrase = HTTPStatus(problem.status).phrase
    document: dict[str, object] = {
        "type": f"urn:damperlab:problem:{problem.kind}",
        "title": phrase,
        "status": problem.status,
        "detail": problem.detail,
        "instance": request.url.path,
        "request_id": request.scope.get("request_id"),
    }
    if problem.faults:
        document["errors"] = [fault.document() for fault in problem.faults]
    return Document(document, problem.status, problem.headers, MEDIA_TYPE)


def _problem(request: Request, error: Exception) -> Response:
    assert isinstance(error, Problem)
    return respond(request, error)


def _faults(request: Request, error: Exception) -> Response:
    assert isinstance(error, StudyFaults)
    count = len(error.faults)
    detail = f"The request has {count} fault{'s' if count != 1 else ''}; nothing was stored."
    return respond(request, Problem(422, "invalid", detail, error.faults))


def _query(request: Request, error: Exception) -> Response:
    assert isinstance(error, QueryFault)
    return respond(
        request, Problem(422, "invalid-parameters", "The study cannot answer this.", (error.fault,))
    )


STORE_UNAVAILABLE = "store-unavailable"
_STORE_PROBLEMS: dict[type[StoreFault], tuple[int, str, str]] = {
    StudyNotFound: (404, "study-not-found", "There is no such study."),
    StudyBusy: (409, "study-busy", "A process works on the study."),
    RevisionGone: (
        410,
        "revision-gone",
        "This revision is no longer available: the study has changed since.",
    ),
    NothingToDo: (409, "nothing-to-do", "The request would change nothing."),
    TooManyUnfinished: (429, "too-many-studies", "Too many studies wait or run."),
    QuotaReached: (507, "quota-reached", "The study would exceed a quota."),
    RecordDamaged: (503, "record-damaged", "A record cannot be read."),
    RecordNotFound: (404, "record-not-found", "There is no such record."),
    RecordKept: (409, "record-kept", "This record cannot be removed."),
    ShelfFull: (507, "records-full", "No more records can be stored."),
    DesignDamaged: (503, "design-damaged", "A design cannot be read."),
    DesignNotFound: (404, "design-not-found", "There is no such design."),
    DesignBusy: (409, "design-busy", "The design has not ended."),
    DesignsFull: (507, "designs-full", "No more designs can be stored."),
    CatalogueDamaged: (503, "catalogue-damaged", "The catalogue is damaged."),
    BlockDamaged: (503, "block-damaged", "Stored results cannot be read."),
}
"""Status, kind and detail of the problem for each exception of the store. The first class that matches is used."""
_TRY_AGAIN = ("too-many-studies", STORE_UNAVAILABLE)


def store_problem(request: Request, error: Exception) -> Response:
    """Return the response to a request during which the store raised an exception."""
    assert isinstance(error, StoreFault)
    error = _deleted_meanwhile(request) or error
    status, kind, detail = next(
        (told for known, told in _STORE_PROBLEMS.items() if isinstance(error, known)),
        # all other exceptions are faults of the service, for example a full disk
        (503, STORE_UNAVAILABLE, "The service cannot use its data."),
    )
    again = {"Retry-After": str(RETRY_SECONDS)} if kind in _TRY_AGAIN else {}
    return respond(request, Problem(status, kind, detail, (error.fault,), again))


def _deleted_meanwhile(request: Request) -> StudyNotFound | None:
    """Return the exception for a missing study if the study of a request was deleted meanwhile; None otherwise."""
    study_id = request.path_params.get("study_id")
    if study_id is None:
        return None
    try:
        request.app.state.service.store.find(study_id)
    except StudyNotFound as gone:
        return gone
    except StoreFault:
        pass  # it is unknown whether the study was deleted
    return None


def _bad_parameters(request: Request, error: Exception) -> Response:
    assert isinstance(error, RequestValidationError)
    faults = invalid(error.errors(), _parameters(request))
    return respond(
        request, Problem(422, "invalid-parameters", "The address of the request has faults.", faults)
    )


def _parameters(request: Request) -> list[str]:
    """Return the names of the query parameters that the route of a request takes."""
    path = getattr(request.scope.get("route"), "path", "")
    operations = request.app.openapi()["paths"].get(path, {})
    parameters = operations.get(request.method.lower(), {}).get("parameters", [])
    return [parameter["name"] for parameter in parameters if parameter["in"] == "query"]


def _http(request: Request, error: Exception) -> Response:
    assert isinstance(error, HTTPException)
    if error.status_code < 400:
        return Response(status_code=error.status_code, headers=error.headers)
    phrase = HTTPStatus(error.status_code).phrase
    detail = {
        404: f"There is nothing at {printable(request.url.path)}; /openapi.json lists all addresses.",
        405: f"{request.method} is not possible here; the Allow header lists the possible methods.",
    }.get(error.status_code, str(error.detail))
    kind = phrase.lower().replace(" ", "-")
    headers = {"Allow": ", ".join(_methods(request))} if error.status_code == 405 else error.headers
    return respond(request, Problem(error.status_code, kind, detail, headers=headers))


def _methods(request: Request) -> list[str]:
    """Return all methods of a path. FastAPI itself gives only the methods of the first matching route."""
    found = {
        method.upper()
        for path, operations in request.app.openapi()["paths"].items()
        if re.fullmatch(re.sub(r"\{\w+\}", "[^/]+", path), request.url.path)
        for method in operations
    }
    return sorted(found | {"HEAD"} if "GET" in found else found) or ["GET", "HEAD"]


def _gone(request: Request, error: Exception) -> Response:
    # this response is not sent, because the client has closed the connection
    return Response(status_code=400)


def _disk(request: Request, error: Exception) -> Response:
    """Return the response to a request that failed on a full, missing or read-only disk. Raise all other errors."""
    assert isinstance(error, OSError)
    if error.errno is None or isinstance(error, ConnectionError | TimeoutError):
        raise error
    place = error.filename or request.app.state.service.settings.data_dir
    return store_problem(request, cannot_use(str(place), error))


def _bug(request: Request, error: Exception) -> Response:
    return defect(request)


def defect(request: Request) -> Response:
    """Return the response to a request that failed because of a defect of the service."""
    detail = "The service failed on this request because of a defect. Please report the request id."
    return respond(request, Problem(500, "defect", detail))
