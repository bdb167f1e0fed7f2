"""Work for one request: ended at its limit, when its client leaves, and when the service ends; in turns."""

import signal
import socket
import threading
from collections.abc import Callable
from typing import Any
from urllib.parse import urlsplit

import anyio
import httpx
import psutil
import pytest
from tests.service.conftest import computing, held, wait_until
from tests.service.security.conftest import ENDLESS, QUICK, WORK_SECONDS

from damperlab.service.work.turns import TooManyWaiting, Turns

SIMULATE = "/api/v1/simulate"


def test_a_point_without_end_is_ended_at_its_limit(apart: Any) -> None:
    with apart.client() as client:
        assert client.post(SIMULATE, json=QUICK).status_code == 200
        (process,) = computing(apart)
        answer = client.post(SIMULATE, json=ENDLESS)
        assert answer.status_code == 422
        problem = answer.json()
        assert problem["type"] == "urn:damperlab:problem:work-limit"
        assert f"{WORK_SECONDS} s" in problem["errors"][0]["allowed"]
        wait_until(lambda: not psutil.pid_exists(process.pid))


@pytest.mark.usefixtures("anew")
@pytest.mark.parametrize("how", [pytest.param(signal.SIGTERM, marks=pytest.mark.night), signal.SIGKILL])
def test_a_service_that_ends_leaves_nothing_that_computes(
    own_service: Callable[..., Any], how: signal.Signals
) -> None:
    running = own_service()
    with running.client() as client:
        assert client.post(SIMULATE, json=QUICK).status_code == 200
    (process,) = computing(running)
    before = process.cpu_times().user
    address = urlsplit(running.url)
    with socket.create_connection((address.hostname, address.port)) as connection:
        body = httpx.Request("POST", running.url, json=ENDLESS).content
        head = f"POST {SIMULATE} HTTP/1.1\r\nHost: {address.netloc}\r\nContent-Type: application/json\r\n"
        connection.sendall(f"{head}Content-Length: {len(body)}\r\n\r\n".encode() + body)
        wait_until(lambda: process.cpu_times().user > before + 0.5)
        # the drain is 10 s, and nothing outlasts it
        assert running.stop(how) == (0 if how is signal.SIGTERM else -how)
    wait_until(lambda: not psutil.pid_exists(process.pid))


@pytest.mark.night
def test_a_machine_that_is_too_busy_is_not_a_request_that_asks_too_much(
    own_service: Callable[..., Any],
) -> None:
    patience = 20
    running = own_service(DAMPERLAB_WORK_WAIT_SECONDS=str(patience))
    with running.client() as client:
        wait_until(lambda: client.post(SIMULATE, json=QUICK).status_code == 200)
        idle = held(running)
        answer = client.post(SIMULATE, json=QUICK)
    assert (answer.status_code, answer.json()["type"]) == (503, "urn:damperlab:problem:too-busy")
    assert int(answer.headers["retry-after"]) > 0
    assert answer.json()["errors"][0]["allowed"] == f"an answer within {patience} s"
    wait_until(lambda: not psutil.pid_exists(idle.pid))


@pytest.mark.night
def test_time_in_which_others_have_the_processors_does_not_count(own_service: Callable[..., Any]) -> None:
    limit = 2
    running = own_service(DAMPERLAB_WORK_SECONDS=str(limit))
    with running.client() as client:
        assert client.post(SIMULATE, json=QUICK).status_code == 200
        idle = held(running)
        others = threading.Timer(5.0 * limit, idle.resume)
        others.start()
        assert client.post(SIMULATE, json=QUICK).status_code == 200
        others.join()
        assert idle.is_running()


def test_turns_go_to_whoever_has_the_fewest() -> None:
    order: list[str] = []

    async def one(turns: Turns, who: str) -> None:
        async with turns.turn(who):
            order.append(who)
            await anyio.sleep(0)

    async def given_back() -> None:
        turns = Turns(1, 10)
        async with anyio.create_task_group() as group, turns.turn("first"):
            for who in ("a", "a", "a", "b", "c"):
                group.start_soon(one, turns, who)
            await anyio.wait_all_tasks_blocked()
            assert order == []
        assert order == ["a", "b", "c", "a", "a"]

    anyio.run(given_back)


def test_a_waiting_request_that_is_given_up_loses_no_turn() -> None:
    async def main() -> None:
        turns = Turns(1, 2)
        async with turns.turn("first"):
            for _ in range(5):
                with anyio.move_on_after(0.01):
                    async with turns.turn("a"):
                        raise AssertionError("there is no turn to have")
            async with anyio.create_task_group() as group:

                async def wait() -> None:
                    async with turns.turn("a"):
                        raise AssertionError("there is no turn to have")

                group.start_soon(wait)
                group.start_soon(wait)
                await anyio.wait_all_tasks_blocked()
                with pytest.raises(TooManyWaiting):
                    async with turns.turn("a"):
                        pass
                group.cancel_scope.cancel()
        with anyio.fail_after(60):
            for who in ("a", "b"):
                async with turns.turn(who):
                    pass

    anyio.run(main)
