"""Access log with one line per request. The id of a request appears in the log, the response and problem documents."""

import logging
import re
import time
import uuid

from starlette.datastructures import Headers, MutableHeaders
from starlette.requests import Request
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from damperlab.service.problems import defect
from damperlab.service.traffic import NO_ROUTE, Traffic

_log = logging.getLogger("damperlab.access")
_SAFE = re.compile(r"[A-Za-z0-9._-]{1,64}")


class AccessLog:
    """ASGI middleware that gives each request an id, and logs the status and the duration of the request.

    An id that the client sends in the header X-Request-ID is used if it contains only safe characters.
    """

    def __init__(self, app: ASGIApp, traffic: Traffic) -> None:
        self.app = app
        self.traffic = traffic

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve one request."""
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return
        asked = Headers(scope=scope).get("x-request-id", "")
        request_id = asked if _SAFE.fullmatch(asked) else uuid.uuid4().hex
        scope["request_id"] = request_id
        started = time.perf_counter()
        status = 0

        async def send_with_id(message: Message) -> None:
            nonlocal status
            if message["type"] == "http.response.start":
                status = message["status"]
                MutableHeaders(scope=message)["X-Request-ID"] = request_id
            await send(message)

        try:
            await self.app(scope, receive, send_with_id)
        except Exception:
            _log.exception("request [%s] met a defect", request_id)
            if status:
                raise  # the server aborts the response, because the beginning was sent already
            await defect(Request(scope))(scope, receive, send_with_id)
        finally:
            seconds = time.perf_counter() - started
            route = getattr(scope.get("route"), "path", NO_ROUTE)
            self.traffic.add(scope["method"], status, seconds, route)
            _log.info(
                "%s %s %s in %.1f ms [%s]",
                scope["method"],
                # The path is logged percent-encoded, as it was sent, so that a client cannot add lines to the log.
                scope.get("raw_path", b"").decode("ascii", errors="backslashreplace"),
                status or "unanswered",
                1e3 * seconds,
                request_id,
            )
