"""Questions to large cubes: computed where they can be ended and stop nobody."""

import asyncio
import re
from collections.abc import AsyncIterator
from contextlib import suppress
from functools import lru_cache
from pathlib import Path
from tempfile import NamedTemporaryFile
from typing import IO, Any, cast

from anyio import CapacityLimiter
from anyio.to_thread import run_sync
from fastapi import Depends, FastAPI
from starlette.requests import ClientDisconnect, Request
from starlette.responses import Response, StreamingResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from damperlab.service.edge.conditional import TAGGED_BYTES
from damperlab.service.parameters import once
from damperlab.service.problems import Problem, install, respond
from damperlab.service.routes import queries, refine, report, studies, tmd
from damperlab.service.settings import Settings
from damperlab.service.state import Service
from damperlab.service.work.processes import Work
from damperlab.studies.store.record import Record

QUESTION = re.compile(
    r"/api/v1/studies/([^/]+)/(?:resonance-map|frequency-response|optimal-designs|robust-designs|tmd-comparison|"
    r"work-precision|importance|report)"
)
_SENT_ON = ("accept", "x-request-id")

PART_BYTES = 1 << 20
"""Of a long answer, which is sent as its client reads it."""

Answer = tuple[int, list[tuple[bytes, bytes]], bytes | None]
"""Status, headers and body; None for a body that lies in a file."""


class Apart:
    """ASGI middleware: has questions to cubes of many points answered by a process of `Work`.

    Parameters
    ----------
    app : ASGI application
        Answers everything else.
    points : int
        Fewest points of such a cube.
    """

    def __init__(self, app: ASGIApp, points: int) -> None:
        self.app = app
        self.points = points

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve one request."""
        study: Record | None = scope.get("study")  # of a question, and nothing else
        if study is None or study.points_total < self.points:
            await self.app(scope, receive, send)
            return
        service: Service = scope["app"].state.service
        request = Request(scope, receive)
        with NamedTemporaryFile() as file:
            try:
                answer = await self._ask(service.work, service.settings, request, Path(file.name))
            except Problem as problem:
                await respond(request, problem)(scope, receive, send)
                return
            except ClientDisconnect:
                return
            status, headers, body = answer
            response = Response(body, status) if body is not None else StreamingResponse(_parts(file), status)
            response.raw_headers = [*headers]
            await response(scope, receive, send)

    @staticmethod
    async def _ask(work: Work, settings: Settings, request: Request, place: Path) -> Answer:
        scope = request.scope
        sent_on = [(name, value) for name, value in scope["headers"] if name.decode("latin-1") in _SENT_ON]
        asked = {
            **{name: scope[name] for name in ("path", "raw_path", "query_string", "request_id", "caller")},
            "headers": sent_on,
        }
        return await work.run(request, answer, settings, asked, place)


def prepare() -> None:
    """Import what computing needs beside the questions."""
    import damperlab.service.work.functions  # noqa: F401


async def _parts(file: IO[bytes]) -> AsyncIterator[bytes]:
    while part := await run_sync(file.read, PART_BYTES):
        yield part


def answer(settings: Settings, asked: dict[str, Any], place: Path) -> Answer:
    """Answer a question in this process, as the service would; a long answer is left in the file `place`."""
    status, headers, body = asyncio.run(_answer(_application(settings), asked))
    if len(body) > TAGGED_BYTES:
        with suppress(OSError):  # where there is no room the service takes it as it is
            place.write_bytes(body)
            return status, headers, None
    return status, headers, bytes(body)


@lru_cache(maxsize=1)
def _application(settings: Settings) -> FastAPI:
    app = FastAPI(docs_url=None, redoc_url=None, openapi_url=None)
    install(app)
    for route in (queries, tmd, report, refine, studies):
        app.include_router(route.router, dependencies=[Depends(once)])
    nothing = cast(Any, None)  # no question runs a study, compiles, or computes points
    store = settings.open_store(wait_seconds=settings.catalogue_wait_seconds)
    app.state.service = Service(
        settings, store, nothing, nothing, CapacityLimiter(1), CapacityLimiter(1), nothing, nothing, nothing
    )
    return app


async def _answer(app: FastAPI, asked: dict[str, Any]) -> tuple[int, list[tuple[bytes, bytes]], bytearray]:
    status, headers, body = 500, [], bytearray()

    async def receive() -> Message:
        return {"type": "http.request", "body": b"", "more_body": False}

    async def send(message: Message) -> None:
        nonlocal status, headers
        if message["type"] == "http.response.start":
            status, headers = message["status"], list(message["headers"])
        else:
            body.extend(message.get("body", b""))

    scope = {
        "type": "http",
        "asgi": {"version": "3.0", "spec_version": "2.3"},
        "http_version": "1.1",
        "method": "GET",
        "scheme": "http",
        "root_path": "",
        "server": None,
        "client": None,
        **asked,
    }
    await app(scope, receive, send)
    return status, headers, body
