"""Questions to large cubes: computed where they can be ended and stop nobody."""

import asyncio
import re
from collections.abc import AsyncIterator, Callable
from functools import lru_cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, BinaryIO, TypeVar, TypeVarTuple, cast

from anyio import CancelScope, CapacityLimiter
from anyio.to_thread import run_sync
from fastapi import Depends, FastAPI
from starlette.requests import ClientDisconnect, Request
from starlette.responses import Response, StreamingResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from damperlab.service.edge.conditional import TAGGED_BYTES
from damperlab.service.parameters import once
from damperlab.service.problems import Problem, install, respond, store_problem
from damperlab.service.routes import export, queries, refine, report, studies, tmd
from damperlab.service.settings import Settings
from damperlab.service.state import Service
from damperlab.service.work.own_store import store_of
from damperlab.service.work.processes import Work
from damperlab.studies.store.faults import StoreFault, cannot_use
from damperlab.studies.store.record import Record

LIGHT = ("axes", "cancel", "events", "recompute", "resume", "retry", "versions", "zarr")
"""What the service itself answers about a study: from the catalogue, or one chunk of its cube. All else goes apart."""
QUESTION = re.compile(rf"/api/v1/studies/([^/]+)/(?!(?:{'|'.join(LIGHT)})$)([^/]+)")
"""A question to a study: its name, and what is asked."""
EXPORT = "export"
EXPORT_POINTS = 1_000_000
"""Points of an export for which a request has its processor time once more."""
_SENT_ON = ("accept", "x-request-id", "if-none-match", "if-range", "range")

PART_BYTES = 1 << 20
"""Of a long answer, which is sent as its client reads it."""

Result = TypeVar("Result")
Arguments = TypeVarTuple("Arguments")
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
        is_export = scope["path"].endswith(f"/{EXPORT}")
        # an export may be larger than what holds temporary files
        where = service.settings.data_dir if is_export else None
        shares = 1 + study.points_total // EXPORT_POINTS if is_export else 1
        work = service.exports if is_export else service.work
        try:
            status, headers, body = await self._ask(work, service.settings, request, where, shares)
        except Problem as problem:
            await respond(request, problem)(scope, receive, send)
            return
        except StoreFault as fault:
            within = Request({**scope, "path_params": {"study_id": study.id}})
            problem_document = await run_sync(store_problem, within, fault)
            await problem_document(scope, receive, send)
            return
        except ClientDisconnect:
            return
        if isinstance(body, bytes):
            response = Response(body, status)
            response.raw_headers = [*headers]
            await response(scope, receive, send)
            return
        with body:
            response = StreamingResponse(_parts(body), status)
            response.raw_headers = [*headers]
            await response(scope, receive, send)

    @staticmethod
    async def _ask(
        work: Work, settings: Settings, request: Request, where: Path | None, shares: int
    ) -> tuple[int, list[tuple[bytes, bytes]], bytes | BinaryIO]:
        """Have it answered; a long body lies in a file without a name, which goes with its last handle."""
        scope = request.scope
        sent_on = [(name, value) for name, value in scope["headers"] if name.decode("latin-1") in _SENT_ON]
        asked = {
            **{name: scope[name] for name in ("path", "raw_path", "query_string", "request_id", "caller")},
            "headers": sent_on,
        }
        folder = await run_sync(_folder, where)
        try:
            place = Path(folder.name) / "body"
            status, headers, body = await work.run(request, answer, settings, asked, place, shares=shares)
            return status, headers, body if body is not None else await run_sync(_open, place)
        finally:
            # the process may have been killed, which leaves all that it had written
            with CancelScope(shield=True):
                await run_sync(folder.cleanup)


def prepare() -> None:
    """Import what computing needs beside the questions."""
    import damperlab.service.work.functions  # noqa: F401


def _folder(where: Path | None) -> TemporaryDirectory[str]:
    try:
        return TemporaryDirectory(dir=where, prefix="export-", ignore_cleanup_errors=True)
    except OSError as error:
        raise cannot_use(str(where or "the folder of temporary files"), error) from error


def _open(place: Path) -> BinaryIO:
    try:
        return place.open("rb")
    except OSError as error:
        raise cannot_use(str(place.parent), error) from error


async def _parts(file: BinaryIO) -> AsyncIterator[bytes]:
    while part := await run_sync(file.read, PART_BYTES):
        yield part


class _Body:
    """A body as it is written: in memory, and once it is long in the file `place`."""

    def __init__(self, place: Path) -> None:
        self.held = bytearray()
        self.fault: StoreFault | None = None
        self._place = place
        self._file: BinaryIO | None = None

    def write(self, part: bytes, more: bool) -> None:
        """Take a part."""
        if self._file is None and (len(self.held) + len(part) <= TAGGED_BYTES or not part):
            self.held += part
            return
        try:
            if self._file is None:
                self._file = self._place.open("wb", buffering=0)
                self._file.write(self.held)
            self._file.write(part)
        except OSError as error:
            if more or self._file is None or self._file.tell() > len(self.held) + len(part):
                self.fault = cannot_use(str(self._place.parent), error)
                raise self.fault from error
            # one part that was held in memory anyway
            self._file = None
            self.held += part

    def take(self) -> bytes | None:
        """Give it; None where it lies in the file."""
        if self._file is None:
            return bytes(self.held)
        self._file.close()
        return None


class _Here:
    """Stands for `Work` where a request has its process already."""

    @staticmethod
    async def run(
        request: Request, function: Callable[[*Arguments], Result], *arguments: *Arguments
    ) -> Result:
        """Call a function."""
        return function(*arguments)


def answer(settings: Settings, asked: dict[str, Any], place: Path) -> Answer:
    """Answer a question in this process, as the service would; a long answer is left in the file `place`.

    Whatever else is written goes to the folder of that file.
    """
    body = _Body(place)
    try:
        asked = {**asked, "folder": place.parent}
        status, headers = asyncio.run(_answer(_application(settings), asked, body))
        return status, headers, body.take()
    except OSError as error:
        raise cannot_use(str(place.parent), error) from error
    except RuntimeError as error:
        # a fault that is met after the answer has begun: nothing of it is sent yet, so the client is told
        fault = body.fault or error.__cause__
        if isinstance(fault, StoreFault):
            raise fault from None
        raise


@lru_cache(maxsize=1)
def _application(settings: Settings) -> FastAPI:
    app = FastAPI(docs_url=None, redoc_url=None, openapi_url=None)
    install(app)
    for route in (queries, tmd, report, refine, studies, export):
        app.include_router(route.router, dependencies=[Depends(once)])
    nothing = cast(Any, None)  # no question runs a study, or compiles
    app.state.service = Service(
        settings,
        store_of(settings),
        nothing,
        cast(Any, _Here()),
        nothing,
        CapacityLimiter(1),
        CapacityLimiter(1),
        nothing,
        nothing,
        nothing,
    )
    return app


async def _answer(app: FastAPI, asked: dict[str, Any], body: _Body) -> tuple[int, list[tuple[bytes, bytes]]]:
    status, headers = 500, []

    async def receive() -> Message:
        return {"type": "http.request", "body": b"", "more_body": False}

    async def send(message: Message) -> None:
        nonlocal status, headers
        if message["type"] == "http.response.start":
            status, headers = message["status"], list(message["headers"])
        else:
            body.write(message.get("body", b""), message.get("more_body", False))

    scope = {
        "type": "http",
        # by which no answer asks again and again whether its client is still there
        "asgi": {"version": "3.0", "spec_version": "2.4"},
        "http_version": "1.1",
        "method": "GET",
        "scheme": "http",
        "root_path": "",
        "server": None,
        "client": None,
        **asked,
    }
    await app(scope, receive, send)
    return status, headers
