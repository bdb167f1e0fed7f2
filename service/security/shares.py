"""Limits on the number of event streams and exports that one caller may have open."""

from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager

from starlette.requests import Request
from starlette.types import ASGIApp, Receive, Scope, Send

from damperlab.service.problems import RETRY_SECONDS, Problem, respond
from damperlab.service.security.caller import counted_under
from damperlab.studies.faults import Fault


class Shares:
    """ASGI middleware: refuses requests beyond a caller's limit.

    Parameters
    ----------
    app : ASGI application
        The application that serves the allowed requests.
    most : dict of int
        Largest number of open requests of one caller, by the last part of the request's path.
    """

    def __init__(self, app: ASGIApp, most: dict[str, int]) -> None:
        self.app = app
        self._most = most
        self._open: Counter[tuple[str, str]] = Counter()

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve one request, or refuse it."""
        kind = scope["path"].rpartition("/")[2] if scope["type"] == "http" else ""
        if kind not in self._most or scope.get("caller") is None:
            await self.app(scope, receive, send)
            return
        try:
            with self._one(kind, counted_under(scope)):
                await self.app(scope, receive, send)
        except _TooMany:
            await respond(Request(scope), _too_many(kind, self._most[kind]))(scope, receive, send)

    @contextmanager
    def _one(self, kind: str, who: str) -> Iterator[None]:
        if self._open[kind, who] >= self._most[kind]:
            raise _TooMany
        self._open[kind, who] += 1
        try:
            yield
        finally:
            self._open[kind, who] -= 1
            if not self._open[kind, who]:
                del self._open[kind, who]


class _TooMany(Exception):
    """The caller's limit of open requests is reached."""


def _too_many(kind: str, most: int) -> Problem:
    told = f"You have {most} requests for {kind} open, the most that one caller may have."
    advice = f"close some, or try again in {RETRY_SECONDS} s"
    fault = Fault("requests", f"more than {most} open", f"at most {most} open for {kind}", advice, told)
    headers = {"Retry-After": str(RETRY_SECONDS)}
    return Problem(429, "too-many-open", "Too many of your requests are open.", (fault,), headers)
