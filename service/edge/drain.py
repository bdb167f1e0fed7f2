"""Drops the unread rest of a request body before the answer is sent (RFC 9112, section 9.6)."""

from anyio import move_on_after
from starlette.datastructures import Headers
from starlette.types import ASGIApp, Message, Receive, Scope, Send

DROPPED_BYTES = 64 * 1024 * 1024
"""Largest number of bytes that are dropped. If more bytes are unread, the client may lose the answer."""
DROP_SECONDS = 20.0


class Drain:
    """ASGI middleware: reads and drops the rest of a request body before the answer begins.

    If a server closes a connection before it has read all bytes of the client, the client may lose the answer.
    """

    def __init__(self, app: ASGIApp) -> None:
        self.app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve one request."""
        if scope["type"] != "http" or not _has_body(headers := Headers(scope=scope)):
            await self.app(scope, receive, send)
            return
        # a client that expects "100 Continue" sends no body until that answer arrives
        waits = headers.get("expect", "").lower() == "100-continue"
        ended = False

        async def receive_noted() -> Message:
            nonlocal ended, waits
            message = await receive()
            waits = False
            ended = message["type"] != "http.request" or not message.get("more_body", False)
            return message

        async def send_after(message: Message) -> None:
            if message["type"] == "http.response.start" and not ended and not waits:
                dropped = 0
                with move_on_after(DROP_SECONDS):
                    while not ended and dropped <= DROPPED_BYTES:
                        dropped += len((await receive_noted()).get("body", b""))
            await send(message)

        await self.app(scope, receive_noted, send_after)


def _has_body(headers: Headers) -> bool:
    return "transfer-encoding" in headers or headers.get("content-length", "0") != "0"
