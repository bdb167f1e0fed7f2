"""Studies that take their time: followed, cancelled, resumed, and never in the way of other requests."""

import json
import threading
from collections.abc import Iterator
from typing import Any

import httpx
import pytest

STUDIES = "/api/v1/studies"


@pytest.fixture
def long(client: httpx.Client, helpers: Any) -> Iterator[dict[str, Any]]:
    """A study that has begun and will not end by itself within a test."""
    record = client.post(STUDIES, json=helpers.long_study("long")).raise_for_status().json()
    yield helpers.wait_for(client, record["id"], lambda record: record["blocks_done"] > 0)
    client.post(f"{STUDIES}/{record['id']}/cancel")
    client.delete(f"{STUDIES}/{record['id']}").raise_for_status()


def _events(lines: Iterator[str]) -> Iterator[dict[str, str]]:
    """Read server-sent events: fields up to an empty line; comments are left out."""
    event: dict[str, str] = {}
    for line in lines:
        if line and not line.startswith(":"):
            name, _, value = line.partition(": ")
            event[name] = value
        elif not line and event:
            yield event
            event = {}


def test_progress_is_sent_until_a_cancel_ends_the_study(client: httpx.Client, long: dict[str, Any]) -> None:
    address = f"{STUDIES}/{long['id']}"
    seen: list[dict[str, Any]] = []
    with client.stream("GET", f"{address}/events") as stream:
        assert stream.headers["content-type"].startswith("text/event-stream")
        for event in _events(stream.iter_lines()):
            seen.append(event)
            if len(seen) == 2:
                cancelled = httpx.post(
                    f"{client.base_url}{address}/cancel".replace("//api", "/api"), timeout=60
                )
                assert cancelled.json()["state"] == "cancelled"
    # The server has closed the stream by itself, after its last event.
    assert [event["event"] for event in seen[:2]] == ["progress", "progress"]
    assert seen[-1]["event"] == "end"
    assert json.loads(seen[-1]["data"])["state"] == "cancelled"
    done = [json.loads(event["data"])["points_done"] for event in seen]
    assert done == sorted(done)


def test_client_that_connects_again_is_not_told_what_it_knows(
    client: httpx.Client, curve: dict[str, Any]
) -> None:
    address = f"{STUDIES}/{curve['id']}/events"
    first = list(_events(iter(client.get(address).text.split("\n"))))
    assert [event["event"] for event in first] == ["end"]
    again = client.get(address, headers={"last-event-id": first[0]["id"]})
    assert (again.status_code, again.content) == (204, b"")
    # One that missed the end is told it.
    assert client.get(address, headers={"last-event-id": "0-0-running"}).status_code == 200


def test_running_study_answers_with_what_is_there(client: httpx.Client, long: dict[str, Any]) -> None:
    params = {"x": "frequency_ratio", "y": "friction_ratio"}
    answer = client.get(f"{STUDIES}/{long['id']}/resonance-map", params=params).raise_for_status().json()
    values = [value for row in answer["values"] for value in row]
    known = sum(value is not None for value in values)
    assert 0 < known < len(values)
    assert answer["complete"] == pytest.approx(known / len(values))
    export = client.get(f"{STUDIES}/{long['id']}/export", params={"format": "csv"}).raise_for_status()
    lines = export.text.splitlines()
    status = lines[0].split(",").index("status")
    there = sum(line.split(",")[status] != "-1" for line in lines[1:])
    # the file may hold blocks that were done after the head of the answer was written, never fewer
    assert 0 < float(export.headers["x-complete"]) <= there / (len(lines) - 1) + 1e-6
    assert there < len(lines) - 1


def test_running_study_is_not_deleted(client: httpx.Client, long: dict[str, Any]) -> None:
    answer = client.delete(f"{STUDIES}/{long['id']}")
    assert answer.status_code == 409
    assert "cancel" in answer.json()["errors"][0]["advice"]


def test_study_can_be_deleted_once_it_is_done(client: httpx.Client, helpers: Any) -> None:
    """At once, while its run still puts things away; and submitted again, it is computed again."""
    study = helpers.CURVE | {"name": "short-lived", "damping_ratio": 0.0077}
    for _ in range(4):
        answer = client.post(STUDIES, json=study)
        assert answer.status_code == 201
        address = f"{STUDIES}/{answer.json()['id']}"
        while not helpers.ended(record := client.get(address).json()):
            pass
        assert (record["state"], record["points_done"]) == ("done", 11)
        deleted = client.delete(address)
        assert deleted.status_code == 204, deleted.text
        assert client.get(address).status_code == 404


def test_resumed_study_keeps_its_blocks(client: httpx.Client, long: dict[str, Any], helpers: Any) -> None:
    address = f"{STUDIES}/{long['id']}"
    client.post(f"{address}/cancel").raise_for_status()
    stopped = helpers.wait_for(client, long["id"], lambda record: record["owner"] is None)
    assert stopped["state"] == "cancelled"
    assert client.post(f"{address}/resume").json()["state"] in ("queued", "running")
    going = helpers.wait_for(client, long["id"], lambda r: r["blocks_done"] > stopped["blocks_done"])
    assert going["state"] == "running"
    assert going["started"] == stopped["started"]


@pytest.mark.night
def test_service_answers_while_it_computes(client: httpx.Client, service: Any) -> None:
    """A simulation of seconds is under way; meanwhile other requests are answered."""
    point = {"frequency_ratio": 1, "clearance_ratio": 10, "friction_ratio": 0.3, "method": "rk4"}
    client.post("/api/v1/simulate", json=point | {"cycles": 1}).raise_for_status()
    heavy: list[httpx.Response] = []

    def ask() -> None:
        heavy.append(
            httpx.post(f"{service.url}/api/v1/simulate", json=point | {"cycles": 100_000}, timeout=1800)
        )

    thread = threading.Thread(target=ask)
    thread.start()
    answered = 0
    while thread.is_alive():
        assert client.get("/health/live").json() == {"status": "live"}
        assert client.get(STUDIES, params={"limit": "1"}).status_code == 200
        answered += not heavy
    thread.join()
    assert heavy[0].status_code == 200, heavy[0].text
    # The simulation goes through a hundred million steps or more: many small requests fit beside it.
    assert answered > 10
