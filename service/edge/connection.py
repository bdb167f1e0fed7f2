"""HTTP connection that limits waiting times, answers malformed requests, and loses no answer at shutdown."""

import logging
import sys
import time
import uuid
from http import HTTPStatus
from typing import TYPE_CHECKING, Any

import h11
from uvicorn.protocols.http.h11_impl import H11Protocol

from damperlab.service.documents import Document
from damperlab.service.edge.policy import POLICY_HEADERS
from damperlab.service.problems import MEDIA_TYPE
from damperlab.service.security.address import counted_address

if TYPE_CHECKING:
    import asyncio

    from damperlab.service.settings import Settings
    from damperlab.service.traffic import Traffic

LINGER_SECONDS = 3.0
"""Time for which the service reads from a connection after an error, so that the client receives the answer [s]."""
LEAVE_SECONDS = 5.0
"""Longest time for an answer after the client has closed its half of the connection [s]."""
STUCK_SECONDS = 60.0
"""Longest time for which a client may leave an answer unread [s]."""

_log = logging.getLogger("damperlab.edge")


class Connection(H11Protocol):
    """Connection of uvicorn with time limits for slow clients.

    The server calls `overdue` about once a second. If the head or body of a request does not arrive in time, the answer
    is 408. If the client does not read an answer in time, the connection is closed.
    """

    _head_since: float | None = None
    _body_since: float | None = None
    _heard: float = 0.0
    _stuck_since: float | None = None
    _lingers_until: float | None = None
    _address: str = ""

    @property
    def _settings(self) -> "Settings":
        settings: Settings = self._state.settings
        return settings

    @property
    def _state(self) -> Any:
        return self.config.app.state  # type: ignore[union-attr]

    def connection_made(self, transport: "asyncio.Transport") -> None:  # type: ignore[override]
        """Accept a connection, or refuse it if there are too many."""
        super().connection_made(transport)
        self._heard = self._head_since = time.monotonic()
        self._address = counted_address(self.client[0]) if self.client else ""
        siblings = self._state.addresses.setdefault(self._address, {})
        siblings[self] = None
        if len(siblings) > self._settings.address_connections_limit and not self._is_proxy():
            others = [each for each in siblings if each is not self and each.is_idle]
            if not others:
                self._refuse(
                    503,
                    "too-many-connections",
                    "Your address already has the largest allowed number of connections.",
                )
                return
            idle = min(others, key=lambda each: each._heard)
            idle.transport.close()  # this connection has been idle longest, and its client can connect again
            siblings.pop(idle)
            self.connections.discard(idle)
        if len(self.connections) > self._settings.connections_limit:
            self._refuse(
                503,
                "too-many-connections",
                "The service already has the largest allowed number of connections.",
            )

    @property
    def is_idle(self) -> bool:
        """Whether the connection has no request in progress."""
        return self.cycle is None or self.cycle.response_complete

    def connection_lost(self, exc: Exception | None) -> None:
        """Forget the connection."""
        super().connection_lost(exc)
        addresses = self._state.addresses
        siblings = addresses.get(self._address, {})
        siblings.pop(self, None)
        if not siblings:
            addresses.pop(self._address, None)

    def _is_proxy(self) -> bool:
        """Whether the peer is a reverse proxy, which connects for many clients."""
        believes: bool = self._state.guard.proxies.believes(self.client[0] if self.client else "")
        return believes

    def data_received(self, data: bytes) -> None:
        """Process received bytes. Bytes that arrive after the last answer are dropped."""
        now = self._heard = time.monotonic()
        if self._lingers_until is not None:
            return
        super().data_received(data)
        their = self.conn.their_state
        if their is h11.IDLE and self.conn.trailing_data[0]:
            self._head_since = now if self._head_since is None else self._head_since
        else:
            self._head_since = None
        self._body_since = (self._body_since or now) if their is h11.SEND_BODY else None

    def eof_received(self) -> bool | None:  # type: ignore[override]
        """Continue the answer for `LEAVE_SECONDS`, because the client may have closed only its half of the stream."""
        if self._lingers_until is not None or self.scheme == "https":
            return None  # TLS has no half-closed connections
        under_way = self.cycle is not None and not self.cycle.response_complete
        if under_way and not self.cycle.more_body:
            self.cycle.keep_alive = False
            self.loop.call_later(LEAVE_SECONDS, self.transport.close)
            return True
        if self.conn.their_state is h11.SEND_BODY or self.conn.trailing_data[0].strip():
            self._refuse(400, "malformed-request", "The request ended before it was complete.")
        return None

    def pause_writing(self) -> None:
        """Record when the client stopped reading."""
        super().pause_writing()
        self._stuck_since = time.monotonic()

    def resume_writing(self) -> None:
        """Record that the client reads again."""
        super().resume_writing()
        self._stuck_since = None

    def shutdown(self) -> None:
        """Close the connection after the current answer."""
        if self._lingers_until is None:
            super().shutdown()
        else:
            self.transport.abort()

    def overdue(self, now: float) -> None:
        """End the connection if it has exceeded a time limit."""
        settings = self._settings
        if self._lingers_until is not None:
            if now > self._lingers_until:
                self.transport.abort()
        elif self._stuck_since is not None and now - self._stuck_since > STUCK_SECONDS:
            self.transport.abort()
        elif self._head_since is not None and now - self._head_since > settings.head_timeout_seconds:
            detail = f"The head of the request was not complete after {settings.head_timeout_seconds:g} s."
            self._refuse(408, "request-timeout", detail)
        elif self._body_since is not None and self.conn.their_state is h11.SEND_BODY:
            since = max(self._heard, self._body_since) if self.flow.read_paused else self._body_since
            if now - since > settings.body_timeout_seconds:
                detail = (
                    f"The body of the request was not complete after {settings.body_timeout_seconds:g} s."
                )
                self._refuse(408, "request-timeout", detail)

    def send_400_response(self, msg: str) -> None:
        """Answer a request that is not valid HTTP with a problem document."""
        error = sys.exception()
        status = getattr(error, "error_status_hint", 400) or 400
        self._refuse(status, "malformed-request", f"This is not an HTTP/1.1 request: {error or msg}.")

    def _refuse(self, status: int, kind: str, detail: str) -> None:
        """Send a problem document without calling the application, then close the connection."""
        request_id = uuid.uuid4().hex
        _log.info("%s %s [%s]: %s", self.client[0] if self.client else "-", status, request_id, detail)
        traffic: Traffic = self._state.traffic
        traffic.add("other", status, 0.0)
        if self.cycle is not None and not self.cycle.response_complete:
            # end the computation of the current answer, as if the client had left
            self.cycle.disconnected = True
            self.cycle.message_event.set()
        if self.conn.our_state in (h11.IDLE, h11.SEND_RESPONSE):
            phrase = HTTPStatus(status).phrase
            document = {
                "type": f"urn:damperlab:problem:{kind}",
                "title": phrase,
                "status": status,
                "detail": detail,
                "request_id": request_id,
            }
            body = Document(document).body
            headers = [
                ("Content-Type", MEDIA_TYPE),
                ("Content-Length", str(len(body))),
                ("Connection", "close"),
                ("X-Request-ID", request_id),
                *POLICY_HEADERS.items(),
            ]
            events = (
                h11.Response(status_code=status, headers=headers, reason=phrase.encode()),
                h11.Data(data=bytes(body)),
                h11.EndOfMessage(),
            )
            self.transport.write(b"".join(self.conn.send(event) or b"" for event in events))
        self._linger()

    def _linger(self) -> None:
        """Close the service's half of the connection, and read for `LINGER_SECONDS`, so that no answer is lost."""
        self._unset_keepalive_if_required()
        self._head_since = self._body_since = None
        self._lingers_until = time.monotonic() + LINGER_SECONDS
        self.flow.resume_reading()
        if self.transport.can_write_eof():
            try:
                self.transport.write_eof()
            except OSError:  # the client has reset the connection; the loop has not reported this yet
                self.transport.abort()
