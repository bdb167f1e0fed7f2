"""HTTP requests that need less than a complete answer: conditional requests (ETag, If-None-Match), Range and HEAD."""

import re
from hashlib import blake2b

from starlette.datastructures import Headers, MutableHeaders
from starlette.requests import Request
from starlette.types import ASGIApp, Message, Receive, Scope, Send

TAGGED_BYTES = 8 * 1024 * 1024
"""Largest size of an answer that gets an ETag; hashing an answer of this size takes some milliseconds."""


class Head:
    """ASGI middleware: answers HEAD like GET but without the body, and stops computing the body."""

    def __init__(self, app: ASGIApp) -> None:
        self.app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve one request."""
        if scope["type"] != "http" or scope["method"] != "HEAD":
            await self.app(scope, receive, send)
            return
        answered = False

        async def receive_until_answered() -> Message:
            return {"type": "http.disconnect"} if answered else await receive()

        async def send_head(message: Message) -> None:
            nonlocal answered
            if message["type"] == "http.response.start":
                answered = True
                await send(message)
                await send({"type": "http.response.body", "body": b"", "more_body": False})

        await self.app({**scope, "method": "GET"}, receive_until_answered, send_head)


class Tagged:
    """ASGI middleware: adds an ETag to JSON answers, and answers 304 if the client already has the same content."""

    def __init__(self, app: ASGIApp) -> None:
        self.app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve one request."""
        if scope["type"] != "http" or scope["method"] != "GET":
            await self.app(scope, receive, send)
            return
        held: Message | None = None

        async def send_tagged(message: Message) -> None:
            nonlocal held
            if message["type"] == "http.response.start" and _taggable(message):
                held = message
                return
            if held is not None:
                start, held = held, None
                body = message.get("body", b"")
                if not message.get("more_body", False) and len(body) <= TAGGED_BYTES:
                    # the tag is weak, because the bytes of a document differ with and without compression
                    tag = f'W/"{blake2b(body, digest_size=12).hexdigest()}"'
                    headers = MutableHeaders(scope=start)
                    headers["ETag"] = tag
                    headers.setdefault("Cache-Control", "private, no-cache")
                    if has_seen(Headers(scope=scope), tag):
                        start["status"] = 304
                        del headers["content-length"], headers["content-type"]
                        message = {"type": "http.response.body", "body": b"", "more_body": False}
                await send(start)
            await send(message)

        await self.app(scope, receive, send_tagged)


def _taggable(start: Message) -> bool:
    headers = Headers(raw=start["headers"])
    kind = headers.get("content-type", "")
    return (
        start["status"] == 200
        and "etag" not in headers
        and headers.get("cache-control") != "no-store"
        and kind.startswith("application/json")
    )


def has_seen(headers: Headers, tag: str) -> bool:
    """Whether If-None-Match contains the ETag, or is ``*``."""
    seen = headers.get("if-none-match", "").strip()
    bare = tag.removeprefix("W/")
    return seen == "*" or bare in [each.strip().removeprefix("W/") for each in seen.split(",")]


def part_asked(request: Request, size: int, tag: str) -> tuple[int, int] | None:
    """Return the start and the end of the part that the Range header requests.

    Parameters
    ----------
    request : Request
        The request. If the If-Range header differs from `tag`, the Range header is ignored.
    size : int
        Number of bytes of the complete content.
    tag : str
        Strong ETag of the content.

    Returns
    -------
    tuple of int, optional
        Start and end index of the part; both indices are equal if the part lies outside the content. None if
        the complete content must be sent, because the Range header is missing, has several parts or uses
        another unit than bytes.
    """
    wanted = request.headers.get("range")
    if wanted is None or request.headers.get("if-range", tag) != tag:
        return None
    found = re.fullmatch(r"bytes=([0-9]{0,15})-([0-9]{0,15})", wanted.strip())
    if found is None or not (found[1] or found[2]):
        return None
    if found[1]:
        start, stop = int(found[1]), min(int(found[2] or size), size - 1) + 1
    else:
        start, stop = max(0, size - int(found[2])), size
    return (start, stop) if start < stop else (0, 0)
