"""Clients that take their time, too many of them, and requests that meet a defect."""

import asyncio
import contextlib
import logging
import socket
import struct
import time
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import httpx
import pytest
import uvicorn
from tests.service.conftest import wait_until
from tests.service.security.raw import host_of

from damperlab.service.access import AccessLog
from damperlab.service.app import _Server, create_app
from damperlab.service.edge.connection import Connection
from damperlab.service.settings import Settings
from damperlab.service.traffic import Traffic


def _rest(connection: socket.socket) -> bytes:
    """Everything until the service ends the connection; it must, or the time-out of the socket fails the test."""
    received = b""
    with contextlib.suppress(ConnectionResetError):
        while part := connection.recv(65536):
            received += part
    return received


def test_heads_and_bodies_that_do_not_come_end_with_408(own_service: Callable[..., Any]) -> None:
    running = own_service(
        DAMPERLAB_HEAD_TIMEOUT_SECONDS="1",
        DAMPERLAB_BODY_TIMEOUT_SECONDS="2",
        DAMPERLAB_CONNECTIONS_LIMIT="60",
    )
    address = urlsplit(running.url)
    place = (address.hostname, address.port)
    host = host_of(running.url)
    begun = [
        b"",
        b"GET /health/live HTTP/1.1\r\nHost: " + host + b"\r\nX: ",
        b"POST /api/v1/simulate HTTP/1.1\r\nHost: %s\r\nContent-Type: application/json\r\n"
        b"Content-Length: 100\r\n\r\n{" % host,
    ]
    with contextlib.ExitStack() as stack:

        def connected() -> socket.socket:
            return stack.enter_context(socket.create_connection(place, timeout=60))

        slow = [(connected(), head) for _ in range(10) for head in begun]
        for connection, head in slow:
            connection.sendall(head)
        for connection, _ in slow:
            answer = _rest(connection)
            assert answer.startswith(b"HTTP/1.1 408 "), answer
            assert b"application/problem+json" in answer
        # a body of which a little comes all the time has no longer
        trickling = connected()
        trickling.sendall(begun[2])
        trickling.settimeout(0.2)
        answer = b""
        for _ in range(98):
            with contextlib.suppress(TimeoutError):
                answer += trickling.recv(65536)
            if answer:
                break
            trickling.sendall(b" ")
        assert answer.startswith(b"HTTP/1.1 408 "), answer
    with contextlib.ExitStack() as stack:
        refused = [_rest(each)[:12] for each in [connected() for _ in range(80)]]
        assert refused.count(b"HTTP/1.1 503") >= 20
        assert set(refused) == {b"HTTP/1.1 503", b"HTTP/1.1 408"}
    with running.client() as client:
        wait_until(lambda: client.get("/metrics").status_code == 200)
        told = client.get("/metrics").text
    assert all(f'method="other",status="{status}"' in told for status in (408, 503))


class _ResetAtTheEnd:
    """A transport whose client resets once it has the answer, before our half is closed."""

    def __init__(self, transport: asyncio.Transport, client: socket.socket) -> None:
        self._transport = transport
        self._client = client

    def __getattr__(self, name: str) -> Any:
        return getattr(self._transport, name)

    def write_eof(self) -> None:
        self._client.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        self._client.close()
        self._transport.write_eof()


@asynccontextmanager
async def _connected(application: Any) -> AsyncIterator[tuple[_Server, Connection, socket.socket]]:
    """Give a server, its connection to one client, and that client's end."""
    made: list[Connection] = []
    config = uvicorn.Config(application, http=Connection, ws="none", log_config=None)
    config.load()
    server = _Server(config)

    def connection() -> Connection:
        made.append(Connection(config=config, server_state=server.server_state, app_state={}))
        return made[-1]

    listening = await asyncio.get_running_loop().create_server(connection, "127.0.0.1", 0)
    with socket.create_connection(listening.sockets[0].getsockname()) as client:
        async with asyncio.timeout(60):
            while not made or made[0].transport is None:
                await asyncio.sleep(0.01)
        yield server, made[0], client
    listening.close()


def test_a_client_that_resets_while_it_is_refused_ends_nothing(tmp_path: Path) -> None:
    """The loop learns of the reset only after the connection was found overdue."""

    async def ask() -> None:
        async with _connected(create_app(Settings(data_dir=tmp_path))) as (_, connection, client):
            connection.transport = _ResetAtTheEnd(connection.transport, client)
            connection.overdue(time.monotonic() + 1000)
            assert connection.transport.is_closing()

    asyncio.run(ask())


def test_a_head_that_arrived_while_the_loop_was_busy_is_no_late_head(tmp_path: Path) -> None:
    async def ask() -> None:
        application = create_app(Settings(data_dir=tmp_path, head_timeout_seconds=0.2))
        async with _connected(application) as (server, connection, client):
            client.sendall(b"GET / HTTP/1.1\r\nHost: h\r\n\r\n")
            time.sleep(0.3)
            await server.on_tick(0)
            assert connection._lingers_until is None
            assert connection.cycle is not None

    asyncio.run(ask())


async def _failing(scope: Any, receive: Any, send: Any) -> None:
    raise RuntimeError("a defect for the test")


def test_a_defect_is_answered_counted_and_logged_with_its_trace(caplog: pytest.LogCaptureFixture) -> None:
    import anyio

    traffic = Traffic()

    async def ask() -> httpx.Response:
        transport = httpx.ASGITransport(app=AccessLog(_failing, traffic))
        async with httpx.AsyncClient(transport=transport, base_url="http://localhost") as client:
            return await client.get("/", headers={"x-request-id": "the-one"})

    with caplog.at_level(logging.ERROR, "damperlab.access"):
        answer = anyio.run(ask)
    assert answer.status_code == 500
    assert answer.json()["request_id"] == answer.headers["x-request-id"] == "the-one"
    assert traffic.read()[0] == {("GET", 500): 1}
    assert "the-one" in caplog.text
    assert "a defect for the test" in caplog.text


def test_idle_connections_of_one_address_keep_nobody_out(own_service: Callable[..., Any]) -> None:
    most = 5
    running = own_service(DAMPERLAB_CONNECTIONS_LIMIT="20", DAMPERLAB_ADDRESS_CONNECTIONS_LIMIT=str(most))
    address = urlsplit(running.url)
    place = (address.hostname, address.port)
    with contextlib.ExitStack() as stack:
        idle = [stack.enter_context(socket.create_connection(place, timeout=60)) for _ in range(30)]
        for each in idle[:-most]:
            assert _rest(each) == b""  # the oldest are closed
        for _ in range(2):
            with running.client() as client:
                assert client.get("/health/live").status_code == 200
