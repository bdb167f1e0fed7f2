"""Studies that take their time: followed, cancelled, resumed, never in the way of requests; and services that stop or die."""

import json
import signal
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import httpx
import pytest
from tests.filling import enter
from tests.service.conftest import CURVE, ended, lasting_study, long_study, wait_for

from damperlab.studies.reading import parse_study_text
from damperlab.studies.store.store import Store

STUDIES = "/api/v1/studies"


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


def test_a_running_study_is_followed_asked_cancelled_and_resumed(client: httpx.Client) -> None:
    record = client.post(STUDIES, json=lasting_study("long")).raise_for_status().json()
    address = f"{STUDIES}/{record['id']}"
    wait_for(client, record["id"], lambda now: now["blocks_done"] > 0)
    try:
        refused = client.delete(address)
        assert refused.status_code == 409
        assert "cancel" in refused.json()["errors"][0]["advice"]
        asked = {"x": "frequency_ratio", "y": "friction_ratio", "most": 1000}
        answer = client.get(f"{address}/resonance-map", params=asked).raise_for_status().json()
        assert 0 < answer["complete"] < 1
        assert any(value is None for row in answer["values"] for value in row)

        seen: list[dict[str, Any]] = []
        with client.stream("GET", f"{address}/events") as stream:
            assert stream.headers["content-type"].startswith("text/event-stream")
            for event in _events(stream.iter_lines()):
                seen.append(event)
                if len(seen) == 2:
                    assert client.post(f"{address}/cancel").json()["state"] == "cancelled"
        # the server has closed the stream by itself, after its last event
        assert [event["event"] for event in seen[:2]] == ["progress", "progress"]
        assert seen[-1]["event"] == "end"
        told = [json.loads(event["data"]) for event in seen]
        assert told[-1]["state"] == "cancelled"
        done = [each["points_done"] for each in told]
        assert done == sorted(done)

        stopped = wait_for(client, record["id"], lambda now: now["owner"] is None)
        assert client.post(f"{address}/resume").json()["state"] in ("queued", "running")
        more = wait_for(client, record["id"], lambda now: now["blocks_done"] > stopped["blocks_done"])
        assert (more["state"], more["started"]) == ("running", stopped["started"])
    finally:
        client.post(f"{address}/cancel")
        client.delete(address).raise_for_status()


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


def test_study_can_be_deleted_once_it_is_done(client: httpx.Client) -> None:
    """At once, while its run still puts things away; and submitted again, it is computed again."""
    study = CURVE | {"name": "short-lived", "damping_ratio": 0.0077}
    for _ in range(2):
        answer = client.post(STUDIES, json=study)
        assert answer.status_code == 201
        address = f"{STUDIES}/{answer.json()['id']}"
        while not ended(record := client.get(address).json()):
            pass
        assert (record["state"], record["points_done"]) == ("done", 11)
        assert client.delete(address[:-1]).status_code == 404  # the whole id is asked for
        deleted = client.delete(address)
        assert deleted.status_code == 204, deleted.text
        assert client.get(address).status_code == 404


def test_next_start_goes_on_where_a_stopped_and_a_killed_service_were(
    own_service: Callable[..., Any], tmp_path: Path
) -> None:
    first = own_service(DAMPERLAB_STUDIES_AT_ONCE="1")
    with first.client() as client:
        running = client.post(STUDIES, json=long_study("first")).raise_for_status().json()["id"]
        waiting = client.post(STUDIES, json=CURVE).raise_for_status().json()["id"]
        wait_for(client, running, lambda record: record["blocks_done"] > 0)
        assert client.get("/health/ready").json()["running"] == [running]
        with client.stream("GET", f"{STUDIES}/{running}/events") as stream:
            assert first.stop(signal.SIGTERM) == 0
            # The stream ends with the service, in good order.
            assert "event: progress" in stream.read().decode()
    store = Store.open(tmp_path / "data")
    kept = store.find(running)
    assert (kept.state, kept.owner) == ("queued", None)
    assert 0 < kept.blocks_done < kept.blocks_total
    assert store.find(waiting).state == "queued"
    # what a process leaves that was killed: a running study, and a claim that nobody renews
    study = parse_study_text('{"particle": false, "axes": {"frequency_ratio": [0.5, 1]}}', "json")
    left = enter(store, study, study.shape).id
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("damperlab.studies.store.life_cycle.claims.CLAIM_SECONDS", 0.5)
        assert store.claim(left, "a process that died")
    store.set_state(left, "running")
    store.close()

    second = own_service(DAMPERLAB_STUDIES_AT_ONCE="2")
    with second.client() as client:
        more = wait_for(client, running, lambda record: record["blocks_done"] > kept.blocks_done)
        assert more["state"] == "running"
        client.post(f"{STUDIES}/{running}/cancel").raise_for_status()
        for each in (waiting, left):
            assert wait_for(client, each, ended)["state"] == "done"
    second.stop(signal.SIGINT)
    assert second.process.returncode == 0


@pytest.mark.parametrize("problem", ["port", "data"])
def test_service_that_cannot_start_says_why(
    own_service: Callable[..., Any], service: Any, tmp_path: Path, problem: str
) -> None:
    if problem == "port":
        environment = {"DAMPERLAB_PORT": service.url.rpartition(":")[2]}
        expected = "address already in use"
    else:
        (tmp_path / "file").write_text("not a folder")
        environment = {"DAMPERLAB_DATA_DIR": str(tmp_path / "file")}
        expected = "Name another folder with --data-dir"
    with pytest.raises(AssertionError, match="did not start") as refused:
        own_service(**environment)
    assert expected in str(refused.value)
    assert "Traceback" not in str(refused.value)
