"""Routes to sign in on the page: a key is exchanged for a cookie that scripts cannot read."""

from anyio.to_thread import run_sync
from starlette.requests import Request
from starlette.responses import Response
from typing_extensions import TypedDict

from damperlab.service.answer_types import gives
from damperlab.service.body import JSON_TYPES, media_type, read_body
from damperlab.service.documents import Document
from damperlab.service.problems import Problem, documented
from damperlab.service.routes.strict import strict_router
from damperlab.service.security.caller import TheCallerOrNobody
from damperlab.service.security.guard import Guard
from damperlab.service.security.sessions import COOKIE
from damperlab.studies.faults import Fault, StudyFaults
from damperlab.studies.text import load_text
from damperlab.studies.vocabulary import Scope

BODY_LIMIT_BYTES = 1024

router = strict_router("/api/v1/session", "session")


class Session(TypedDict):
    """Whether the service requires keys, and the caller's identity."""

    needed: bool
    signed_in: bool
    owner: str
    scopes: list[Scope]


_BODY = {
    "required": True,
    "content": {
        "application/json": {
            "schema": {
                "type": "object",
                "required": ["key"],
                "properties": {"key": {"type": "string"}},
                "additionalProperties": False,
            }
        }
    },
}


@router.get(
    "",
    response_class=Document,
    responses={200: gives(Session)},
    summary="The caller, and whether a key is required",
)
def show(request: Request, caller: TheCallerOrNobody) -> Document:
    """Give the owner and the scopes of the caller, and say whether the service requires keys."""
    return _document(_guard(request), caller.owner if caller else "", caller.scopes if caller else ())


@router.post(
    "",
    response_class=Document,
    responses={200: gives(Session), **documented(401, 413, 415, 422)},
    openapi_extra={"requestBody": _BODY},
    summary="Sign in with a key",
)
async def sign_in(request: Request) -> Document:
    """Begin a session of some hours. Scripts and other sites cannot read the cookie of the session."""
    guard = _guard(request)
    media_type(request, JSON_TYPES)
    document = load_text(await read_body(request, BODY_LIMIT_BYTES), "json")
    secret = document.get("key") if isinstance(document, dict) and len(document) == 1 else None
    if not isinstance(secret, str):
        raise StudyFaults(
            (
                Fault(
                    "body",
                    "no key",
                    '{"key": "dlk_…"}',
                    "send a key, and no other fields",
                    'The body must be of the form {"key": "dlk_…"}.',
                ),
            )
        )
    key = await run_sync(guard.of_key, secret) if secret.isascii() else None
    if key is None:
        fault = Fault(
            "key",
            "a key that is not valid",
            "a key of this service",
            "copy the complete key, which begins with dlk_",
            "The key is not a valid key of this service.",
        )
        raise Problem(
            401, "no-key", "This is not a key of this service, or it has expired or been revoked.", (fault,)
        )
    value, seconds = guard.sessions.begin(key)
    answer = _document(guard, key.owner, key.scopes)
    answer.set_cookie(
        COOKIE,
        value,
        max_age=seconds,
        httponly=True,
        samesite="strict",
        secure=request.scope["scheme"] == "https",
    )
    return answer


@router.delete("", status_code=204, summary="Sign out")
async def sign_out(request: Request) -> Response:
    """End the session and delete its cookie."""
    _guard(request).end_session(request.headers)
    answer = Response(status_code=204)
    answer.delete_cookie(COOKIE, httponly=True, samesite="strict", secure=request.scope["scheme"] == "https")
    return answer


def _guard(request: Request) -> Guard:
    guard: Guard = request.app.state.guard
    return guard


def _document(guard: Guard, owner: str, scopes: tuple[Scope, ...]) -> Document:
    found: Session = {
        "needed": guard.needs_keys,
        "signed_in": bool(scopes),
        "owner": owner,
        "scopes": list(scopes),
    }
    return Document(found, headers={"Cache-Control": "no-store"})
