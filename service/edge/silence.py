"""Refuses requests within a second while the catalogue does not answer, instead of holding them."""

import asyncio

from anyio import CapacityLimiter
from anyio.to_thread import run_sync
from starlette.requests import Request
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from damperlab.service.problems import RETRY_SECONDS, Problem, respond
from damperlab.studies.store.catalogue.catalogue import Catalogue
from damperlab.studies.store.faults import StoreFault

PATIENCE_SECONDS = 0.5
"""Time of a pending request after which the catalogue is tested."""
SILENCE_SECONDS = 0.4
"""Longest time for the catalogue to answer the test."""


class Silence:
    """ASGI middleware: answers 503 to a request that has no answer yet while the catalogue does not answer.

    The thread of such a request cannot be ended; it continues, and its answer is dropped. A catalogue in a file has no
    server that could be silent. Delays then come from this machine, and refusing would only add to its work.
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
        """Test once for all waiting requests."""
        if self._asking is None or self._asking.done():
            self._asking = asyncio.create_task(_ask(catalogue))
        asking = self._asking  # when this test ends, another caller may have started one
        done, _ = await asyncio.wait([asking], timeout=SILENCE_SECONDS)
        return bool(done) and asking.result()

    def _forget(self, served: "asyncio.Future[None]") -> None:
        self._left.discard(served)
        if not served.cancelled():
            served.exception()  # nobody waits for this answer any more


async def _ask(catalogue: Catalogue) -> bool:
    try:
        # separate from the threads of the requests, which may all be waiting
        await run_sync(catalogue.greet, abandon_on_cancel=True, limiter=CapacityLimiter(1))
    except StoreFault:
        return False
    return True


def _problem() -> Problem:
    told = "The catalogue does not answer. Try again in a moment; stored data are safe."
    return Problem(503, "store-unavailable", told, headers={"Retry-After": str(RETRY_SECONDS)})
