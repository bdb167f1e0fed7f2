"""Checks the head of a request. The head must be short, and must state the length of the body in only one way."""

import re

from starlette.requests import Request
from starlette.types import ASGIApp, Receive, Scope, Send

from damperlab.service.problems import Problem, respond
from damperlab.service.security.sessions import COOKIE
from damperlab.studies.faults import Fault

HEAD_LIMIT_BYTES = 32 * 1024
"""Largest size of the request line and all header lines together."""
CONTENT_TYPE_LIMIT_BYTES = 1024
_SESSION = re.compile(rf"(?:^|; ?)({COOKIE}=[0-9a-f.]{{1,200}})(?=;|$)".encode())
PARAMETERS_LIMIT = 500
"""Largest number of query parameters of a request, more than any route of the service has."""


class ShortHead:
    """ASGI middleware that refuses a long head, and a head that states the length of the body twice."""

    def __init__(self, app: ASGIApp) -> None:
        self.app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve one request, or refuse it."""
        problem = (_framed_twice(scope) or _too_long(scope)) if scope["type"] == "http" else None
        if problem is None:
            if scope["type"] == "http":
                scope["headers"] = _without_cookies(scope["headers"])
            await self.app(scope, receive, send)
        else:
            await respond(Request(scope), problem)(scope, receive, send)


def _without_cookies(headers: list[tuple[bytes, bytes]]) -> list[tuple[bytes, bytes]]:
    """Keep only the session's cookie, because parsing a malicious Cookie header may take seconds (CVE-2024-7592)."""
    kept = [(name, value) for name, value in headers if name != b"cookie"]
    cookies = [_SESSION.search(value) for name, value in headers if name == b"cookie"]
    return kept + [(b"cookie", found[1]) for found in cookies if found]


def _framed_twice(scope: Scope) -> Problem | None:
    names = {name for name, _ in scope["headers"]}
    if not names.issuperset((b"content-length", b"transfer-encoding")):
        return None
    fault = Fault(
        "Content-Length",
        "one together with Transfer-Encoding",
        "one of the two",
        "leave it out",
        "`Content-Length` and `Transfer-Encoding` exclude each other (RFC 9112, 6.1).",
    )
    # if a proxy uses the other of the two headers, it may read a part of the body as a second request
    return Problem(
        400,
        "malformed-request",
        "The head of the request states twice where its body ends.",
        (fault,),
        {"Connection": "close"},
    )


def _too_long(scope: Scope) -> Problem | None:
    size = len(scope.get("raw_path", b"")) + len(scope["query_string"])
    parameters = scope["query_string"].count(b"&") + 1
    if parameters > PARAMETERS_LIMIT:
        return _problem("query", parameters, PARAMETERS_LIMIT, "parameters")
    for name, value in scope["headers"]:
        size += len(name) + len(value) + 4
        if name == b"content-type" and len(value) > CONTENT_TYPE_LIMIT_BYTES:
            return _problem("Content-Type", len(value), CONTENT_TYPE_LIMIT_BYTES)
    return _problem("headers", size, HEAD_LIMIT_BYTES) if size > HEAD_LIMIT_BYTES else None


def _problem(field: str, size: int, limit: int, what: str = "bytes") -> Problem:
    fault = Fault(
        field,
        f"{size} {what}",
        f"at most {limit} {what}",
        "send a shorter one",
        f"`{field}` has {size:,} {what}; at most {limit:,} are allowed.",
    )
    return Problem(
        431, "head-too-long", "The head of the request is longer than the service reads.", (fault,)
    )
