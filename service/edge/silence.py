"""Refuses requests with status 503 within a second while the database of the catalogue does not answer."""

import asyncio

from anyio import CapacityLimiter
from anyio.to_thread import run_sync
from starlette.requests import Request
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from damperlab.service.problems import RETRY_SECONDS, Problem, respond
from damperlab.studies.store.catalogue.catalogue import Catalogue
from damperlab.studies.store.faults import StoreFault

PATIENCE_SECONDS = 0.5
"""Waiting time of a request after which the catalogue is tested [s]."""
SILENCE_SECONDS = 0.4
"""Longest time that the catalogue may take to answer the test [s]."""


class Silence:
    """ASGI middleware that answers 503 to a waiting request if the catalogue does not answer.

    The thread of a refused request continues, and its answer is dropped. A catalogue in a SQLite file is not tested.
    """

    def __init__(self, app: ASGIApp) -> None:
        self.app = app
        self._asking: asyncio.Task[bool] | None = None
        self._left: set[asyncio.Future[None]] = set()

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve one request, or refuse it."""
        if (
            scope["type"] != "http"
            or not scope["path"].startswith("/api/")
            or scope["app"].state.service.store.catalogue.is_file
        ):
            await self.app(scope, receive, send)
            return
        begun = refused = False

        async def send_noted(message: Message) -> None:
            nonlocal begun
            if not refused:
                begun = True
                await send(message)

        served = asyncio.ensure_future(self.app(scope, receive, send_noted))
        try:
            while not begun and not (await asyncio.wait([served], timeout=PATIENCE_SECONDS))[0]:
                refused = not await self._answers(scope["app"].state.service.store.catalogue) and not begun
                if refused:
                    self._left.add(served)
                    served.add_done_callback(self._forget)
                    await respond(Request(scope), _problem())(scope, receive, send)
                    return
            await served
        except asyncio.CancelledError:
            served.cancel()
            raise

    async def _answers(self, catalogue: Catalogue) -> bool:
        """Return whether the catalogue answers; all waiting requests share one test."""
        if self._asking is None or self._asking.done():
            self._asking = asyncio.create_task(_ask(catalogue))
        asking = self._asking  # by the end of this test, another request may have started a new test
        done, _ = await asyncio.wait([asking], timeout=SILENCE_SECONDS)
        return bool(done) and asking.result()

    def _forget(self, served: "asyncio.Future[None]") -> None:
        self._left.discard(served)
        if not served.cancelled():
            served.exception()  # mark the exception as retrieved, because no request waits for this answer any more


async def _ask(catalogue: Catalogue) -> bool:
    try:
        # use a separate thread, because all threads of the requests may be waiting
        await run_sync(catalogue.greet, abandon_on_cancel=True, limiter=CapacityLimiter(1))
    except StoreFault:
        return False
    return True


def _problem() -> Problem:
    told = "The catalogue does not answer. Try again in a moment; stored data are safe."
    return Problem(503, "store-unavailable", told, headers={"Retry-After": str(RETRY_SECONDS)})
