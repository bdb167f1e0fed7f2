"""Compresses answers for clients that accept gzip."""

import re

from starlette.datastructures import Headers
from starlette.middleware.gzip import GZipMiddleware
from starlette.types import Receive, Scope, Send

_REFUSED = re.compile(r"gzip\s*;\s*q\s*=\s*0(\.0*)?")


class Compressed(GZipMiddleware):
    """ASGI middleware: compresses answers for clients that accept gzip.

    A weight of 0 refuses an encoding (RFC 9110, section 12.5.3). Starlette's middleware ignores weights, so
    this class removes the Accept-Encoding header if the header refuses gzip.
    """

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve one request."""
        if scope["type"] == "http" and _refuses(Headers(scope=scope).get("accept-encoding", "")):
            scope["headers"] = [each for each in scope["headers"] if each[0] != b"accept-encoding"]
        await super().__call__(scope, receive, send)


def _refuses(accepted: str) -> bool:
    return any(_REFUSED.fullmatch(each.strip().lower()) for each in accepted.split(","))
