"""Cache of compressed answers about studies. A cached answer is used until a study in the request changes."""

import asyncio
from collections import OrderedDict

from anyio.to_thread import run_sync
from starlette.datastructures import Headers, QueryParams
from starlette.requests import Request
from starlette.responses import Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from damperlab.service.edge.conditional import has_seen
from damperlab.service.problems import store_problem
from damperlab.service.questions.every import EVERY
from damperlab.service.state import Service
from damperlab.service.work.shared import Shared
from damperlab.studies.store.faults import StoreFault, StudyNotFound
from damperlab.studies.store.record import Record

STUDIES = "/api/v1/studies"
KEPT = 512
"""Largest number of cached answers."""
KEPT_BYTES = 1 << 20
"""Largest number of bytes of one cached answer."""
READS = {question.route: question.studies for question in EVERY} | {"report": (), "differences": ("older",)}
"""Last path segments of requests that read cubes, each with the query parameters that name further studies."""
OTHERS_KEPT = 32
"""Largest number of further studies that the query of a cached answer may name."""
PASSING = ("definition", "phase", "phase_done", "phase_total", "seconds_left", "owner")
"""Fields of a study's record whose changes leave cached answers valid."""

Key = tuple[object, ...]
Answer = tuple[int, list[tuple[bytes, bytes]], bytes]


class Kept:
    """ASGI middleware that answers repeated requests from the cache. Simultaneous equal requests are computed once.

    Parameters
    ----------
    app : ASGI application
        The application that computes an answer, compresses it and adds the ETag.
    """

    def __init__(self, app: ASGIApp) -> None:
        self.app = app
        self._studies: Shared[Record] | None = None
        self._kept: OrderedDict[Key, Answer] = OrderedDict()
        # for each request that is being computed: a future that tells whether an answer was sent
        self._under_way: dict[Key, asyncio.Future[bool]] = {}

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve one request."""
        asked = _asked(scope["path"]) if scope["type"] == "http" and scope["method"] == "GET" else None
        if asked is None:
            await self.app(scope, receive, send)
            return
        study_id, what = asked
        if self._studies is None:
            service: Service = scope["app"].state.service
            self._studies = Shared(service.store.find)
        query = scope["query_string"]
        named = _others(query, READS[what])
        try:
            study = scope["study"] = await self._studies.ask(study_id)
            others = [await self._studies.ask(name) for name in named[:OTHERS_KEPT]]
        except StudyNotFound:
            others = None
        except StoreFault as fault:
            # without the record it is unknown whether the cube is large, so the application is not called
            within = Request({**scope, "path_params": {"study_id": study_id}})
            problem_document = await run_sync(store_problem, within, fault)
            await problem_document(scope, receive, send)
            return
        if others is None or len(named) > OTHERS_KEPT:
            await self.app(scope, receive, send)  # the application's answer explains the error
            return
        headers = Headers(scope=scope)
        packed = "gzip" in headers.get("accept-encoding", "")
        key = (*map(_seen, (study, *others)), scope["path"], query, packed)
        answered = False
        while key not in self._kept and not answered and (under_way := self._under_way.get(key)) is not None:
            await asyncio.wait([under_way])
            # False if the client left before the answer was sent; one of the waiting requests then computes the answer
            answered = under_way.result()
        if key in self._kept:
            self._kept.move_to_end(key)
            await _send(self._kept[key], headers, scope, receive, send)
        elif key in self._under_way:
            await self.app(scope, receive, send)  # the first answer is not cached, so it is computed again
        else:
            await self._compute(key, scope, receive, send)

    async def _compute(self, key: Key, scope: Scope, receive: Receive, send: Send) -> None:
        mine = self._under_way[key] = asyncio.get_running_loop().create_future()
        unconditional = [(name, value) for name, value in scope["headers"] if name != b"if-none-match"]
        start: Message | None = None

        async def send_and_keep(message: Message) -> None:
            nonlocal start
            if message["type"] == "http.response.start" and message["status"] == 200:
                start = message
                return
            if start is None or message.get("more_body", False):
                # the answer is not cached, so equal requests need not wait for this client
                self._done(key, mine, answered=True)
                if start is not None:
                    await send(start)
                    start = None
                await send(message)
                return
            answer = start["status"], [*start["headers"]], bytes(message.get("body", b""))
            if len(answer[2]) <= KEPT_BYTES and (b"cache-control", b"no-store") not in answer[1]:
                self._kept[key] = answer
                if len(self._kept) > KEPT:
                    self._kept.popitem(last=False)
            self._done(key, mine, answered=True)
            await _send(answer, Headers(scope=scope), scope, receive, send)

        try:
            await self.app({**scope, "headers": unconditional}, receive, send_and_keep)
        finally:
            self._done(key, mine, answered=False)

    def _done(self, key: Key, mine: asyncio.Future[bool], *, answered: bool) -> None:
        if not mine.done():
            del self._under_way[key]
            mine.set_result(answered)


def _asked(path: str) -> tuple[str, str] | None:
    """Return the study's id and the last part of a path; None if the answer does not come from a cube."""
    *first, study, what = path.split("/")
    return (study, what) if "/".join(first) == STUDIES and study and what in READS else None


def _others(query: bytes, keys: tuple[str, ...]) -> list[str]:
    """Return the values of the query parameters in `keys`; each value names a further study."""
    named = [value for name, value in QueryParams(query).multi_items() if name in keys]
    return list(filter(None, (each.strip() for value in named for each in value.split(","))))


def _seen(study: Record) -> Key:
    """Return the values of a study's record on which an answer may depend."""
    values = ((name, value) for name, value in vars(study).items() if name not in PASSING)
    return tuple(tuple(value.items()) if isinstance(value, dict) else value for _, value in values)


async def _send(answer: Answer, headers: Headers, scope: Scope, receive: Receive, send: Send) -> None:
    status, raw_headers, body = answer
    response = Response(body, status)
    response.raw_headers = [*raw_headers]
    tag = response.headers.get("etag")
    if tag is not None and has_seen(headers, tag):
        response = Response(status_code=304)
        left = (b"content-length", b"content-type", b"content-encoding")
        response.raw_headers = [(name, value) for name, value in raw_headers if name.lower() not in left]
    await response(scope, receive, send)
