"""Deferred answers, which the service computes after the request has ended and keeps for some minutes."""

import asyncio
import time
import uuid
from dataclasses import dataclass, field
from typing import Annotated, Literal

from typing_extensions import TypedDict

from damperlab.service.answer_types import gives
from damperlab.service.problems import Problem
from damperlab.studies.faults import Fault, printable
from damperlab.studies.shapes import Says

KEPT_SECONDS = 600.0
"""Time for which a completed answer is kept [s]."""
KEPT = 256
"""Largest number of deferred answers, completed and pending."""
KEPT_BYTES = 256 << 20
"""Largest number of bytes of all completed answers."""


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
        """Add a deferred answer, and return True. Return False if `KEPT` answers are pending."""
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
