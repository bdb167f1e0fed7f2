"""Defers slow answers for clients that send the header ``Prefer: respond-async`` (RFC 7240).

The service computes a deferred answer after the request has ended, and keeps the answer for some minutes.
"""

import asyncio
import logging
import time
import uuid
from dataclasses import dataclass, field
from typing import Annotated, Literal

from starlette.datastructures import Headers
from starlette.requests import Request
from starlette.types import ASGIApp, Message, Receive, Scope, Send
from typing_extensions import TypedDict

from damperlab.service.answer_types import gives
from damperlab.service.documents import Document
from damperlab.service.problems import Problem, defect
from damperlab.studies.faults import Fault, printable
from damperlab.studies.shapes import Says

PATHS = ("/api/v1/simulate", "/api/v1/earthquake-comparisons", "/api/v1/fits")
"""Paths of the requests whose answers may be deferred."""
WAIT_SECONDS = 5.0
"""Default time after which an answer is deferred [s]."""
LONGEST_WAIT_SECONDS = 60.0
ASK_AGAIN_SECONDS = 1
KEPT_SECONDS = 600.0
"""Time for which a completed answer is kept [s]."""
KEPT = 256
"""Largest number of deferred answers, completed and pending."""
KEPT_BYTES = 256 << 20
"""Largest number of bytes of all completed answers."""

_log = logging.getLogger("damperlab.work")


class PromiseDocument(TypedDict):
    """Address of a deferred answer."""

    state: Literal["computing"]
    seconds: Annotated[float, Says(minimum=0, description="Time since the request.")]
    answer: Annotated[str, Says(description="Path of the answer.")]


PROMISED = gives(
    PromiseDocument,
    "The answer is being computed, and can be fetched at this address.",
    Location="Address of the answer.",
)
"""OpenAPI description of the response to a request whose answer is deferred (RFC 7240)."""


@dataclass
class Promise:
    """One pending or completed answer.

    Parameters
    ----------
    owner : str
        Name of the caller who may fetch the answer.
    """

    owner: str
    id: str = field(default_factory=lambda: uuid.uuid4().hex)
    began: float = field(default_factory=time.monotonic)
    ended: float | None = None
    given_up: asyncio.Event = field(default_factory=asyncio.Event)
    task: "asyncio.Task[None] | None" = None
    status: int = 0
    headers: list[tuple[bytes, bytes]] = field(default_factory=list)
    body: bytes = b""

    @property
    def address(self) -> str:
        """Path at which the answer can be fetched."""
        return f"/api/v1/answers/{self.id}"


class Promises:
    """The deferred answers of a service. All calls must come from one event loop."""

    def __init__(self) -> None:
        self._promises: dict[str, Promise] = {}

    def keep(self, promise: Promise) -> bool:
        """Add a deferred answer, and return True. Return False if the limit of pending answers is reached."""
        self._forget_old()
        if len(self._promises) >= KEPT:
            return False
        self._promises[promise.id] = promise
        return True

    def find(self, promise_id: str, owner: str) -> Promise:
        """Return the deferred answer with the given id.

        Raises
        ------
        Problem
            404 if this caller has no deferred answer with this id.
        """
        self._forget_old()
        promise = self._promises.get(promise_id)
        if promise is None or promise.owner != owner:
            fault = Fault(
                "answer",
                printable(promise_id),
                f"the id of one of your deferred answers, at most {KEPT_SECONDS / 60:g} minutes after its completion",
                "send the request again",
                "There is no such answer for you: it was cancelled or fetched too late, or the service was "
                "restarted.",
            )
            raise Problem(404, "no-such-answer", "There is no such answer.", (fault,))
        return promise

    def give_up(self, promise: Promise) -> None:
        """Stop computing an answer, and delete it."""
        promise.given_up.set()
        self._promises.pop(promise.id, None)

    def _forget_old(self) -> None:
        now = time.monotonic()
        there = sorted((each for each in self._promises.values() if each.ended is not None), key=_ended)
        held = sum(len(each.body) for each in there)
        for promise in there:
            old = now - _ended(promise) > KEPT_SECONDS
            if not old and len(self._promises) < KEPT and held <= KEPT_BYTES:
                break
            held -= len(promise.body)
            del self._promises[promise.id]


def _ended(promise: Promise) -> float:
    assert promise.ended is not None
    return promise.ended


class Later:
    """ASGI middleware that defers slow answers. The client gets an address from which to fetch the answer later.

    If the client leaves before the answer is deferred, the computation is ended.

    Parameters
    ----------
    app : ASGI application
        The application that computes the answers.
    promises : Promises
        The deferred answers of the service.
    """

    def __init__(self, app: ASGIApp, promises: Promises) -> None:
        self.app = app
        self.promises = promises

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve one request."""
        concerned = scope["type"] == "http" and scope["method"] == "POST" and scope["path"] in PATHS
        wait = wait_seconds(Headers(scope=scope)) if concerned else None
        if wait is None:
            await self.app(scope, receive, send)
            return
        promise = Promise(scope["caller"].name)
        sent = asyncio.Event()  # the complete body has arrived
        promise.task = asyncio.create_task(self._answer(promise, sent, scope, receive))
        leaving = asyncio.create_task(_left(sent, receive))
        try:
            await sent.wait()
            await asyncio.wait((promise.task, leaving), timeout=wait, return_when=asyncio.FIRST_COMPLETED)
            if not promise.task.done() and not leaving.done() and self.promises.keep(promise):
                await promised(promise)(scope, receive, send)
                return
            if not promise.task.done():
                # the client has left, or the limit of deferred answers is reached
                await asyncio.wait((promise.task, leaving), return_when=asyncio.FIRST_COMPLETED)
            leaving.cancel()
            if promise.task.done():
                await _send(promise, send)
            else:
                promise.given_up.set()
                await promise.task
        finally:
            leaving.cancel()

    async def _answer(self, promise: Promise, sent: asyncio.Event, scope: Scope, receive: Receive) -> None:
        """Compute the answer to a request, and store it in `promise`."""

        async def receive_body() -> Message:
            if not sent.is_set():
                message = await receive()
                if message["type"] == "http.disconnect" or not message.get("more_body", False):
                    sent.set()
                return message
            await promise.given_up.wait()
            return {"type": "http.disconnect"}

        body = bytearray()

        async def note(message: Message) -> None:
            if message["type"] == "http.response.start":
                promise.status, promise.headers = message["status"], [*message["headers"]]
            else:
                body.extend(message.get("body", b""))

        try:
            await self.app(scope, receive_body, note)
        except Exception:
            _log.exception("request [%s] met a defect", scope.get("request_id"))
            body.clear()
            await defect(Request(scope))(scope, receive_body, note)
        finally:
            sent.set()
            promise.body, promise.ended = bytes(body), time.monotonic()


async def _left(sent: asyncio.Event, receive: Receive) -> None:
    """Wait until the client has left.

    Read messages only after the event `sent`, which is set when the body of the request is complete.
    """
    await sent.wait()
    while (await receive())["type"] != "http.disconnect":
        pass


def promised(promise: Promise) -> Document:
    """Return a response with the address of the deferred answer."""
    seconds = time.monotonic() - promise.began
    return Document(
        PromiseDocument(state="computing", seconds=seconds, answer=promise.address),
        202,
        {
            "Location": promise.address,
            "Retry-After": str(ASK_AGAIN_SECONDS),
            "Preference-Applied": "respond-async",
        },
    )


async def _send(promise: Promise, send: Send) -> None:
    await send({"type": "http.response.start", "status": promise.status, "headers": promise.headers})
    await send({"type": "http.response.body", "body": promise.body})


def wait_seconds(headers: Headers) -> float | None:
    """Return the time after which the answer of a request is deferred [s]; None if the client does not allow this.

    A malformed preference is ignored, because preferences are never refused (RFC 7240, section 2).
    """
    wait, later = WAIT_SECONDS, False
    for token in ",".join(headers.getlist("prefer")).split(","):
        name, _, value = token.partition(";")[0].strip().lower().partition("=")
        value = value.strip('" ')
        if name.strip() == "respond-async":
            later = True
        elif name.strip() == "wait" and value.isascii() and value.isdigit() and len(value) < 6:
            wait = min(float(value), LONGEST_WAIT_SECONDS)
    return wait if later else None
