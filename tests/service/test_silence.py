"""Many requests that wait at once ask the catalogue whether it answers, and none is lost where it does."""

import asyncio
import time
from types import SimpleNamespace
from typing import Any

import pytest

from damperlab.service.edge import silence


def test_requests_that_wait_at_once_are_all_served(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(silence, "PATIENCE_SECONDS", 0.002)
    catalogue = SimpleNamespace(is_file=False, greet=lambda: time.sleep(0.001))
    state = SimpleNamespace(service=SimpleNamespace(store=SimpleNamespace(catalogue=catalogue)))
    scope = {"type": "http", "path": "/api/v1/studies", "app": SimpleNamespace(state=state)}

    async def app(scope: Any, receive: Any, send: Any) -> None:
        await asyncio.sleep(0.2)
        await send({"type": "http.response.start", "status": 200, "headers": []})

    async def served() -> list[int]:
        statuses: list[int] = []

        async def send(message: Any) -> None:
            statuses.append(message["status"])

        async def receive() -> Any:
            raise AssertionError("nothing is read")

        async def one(place: int) -> None:
            await asyncio.sleep(0.0003 * place)
            await edge(scope, receive, send)

        edge = silence.Silence(app)
        await asyncio.gather(*map(one, range(200)))
        return statuses

    assert asyncio.run(served()) == [200] * 200
