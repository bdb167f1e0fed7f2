"""A service that is stopped or dies leaves its studies so that the next one goes on with them."""

import signal
from collections.abc import Callable
from pathlib import Path
from typing import Any

import httpx
import pytest
from tests.filling import enter

from damperlab.studies.reading import parse_study_text
from damperlab.studies.store.store import Store

STUDIES = "/api/v1/studies"


def test_next_start_goes_on_where_a_stopped_service_was(
    own_service: Callable[..., Any], helpers: Any, tmp_path: Path
) -> None:
    first = own_service(DAMPERLAB_STUDIES_AT_ONCE="1")
    with httpx.Client(base_url=first.url, timeout=300) as client:
        running = client.post(STUDIES, json=helpers.long_study("first")).raise_for_status().json()["id"]
        waiting = client.post(STUDIES, json=helpers.CURVE).raise_for_status().json()["id"]
        helpers.wait_for(client, running, lambda record: record["blocks_done"] > 0)
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
    store.close()

    second = own_service(DAMPERLAB_STUDIES_AT_ONCE="2")
    with httpx.Client(base_url=second.url, timeout=300) as client:
        assert helpers.wait_for(client, waiting, helpers.ended)["state"] == "done"
        more = helpers.wait_for(client, running, lambda record: record["blocks_done"] > kept.blocks_done)
        assert more["state"] == "running"
    second.stop(signal.SIGINT)
    assert second.process.returncode == 0


def test_study_of_a_dead_process_is_picked_up(
    own_service: Callable[..., Any], helpers: Any, tmp_path: Path
) -> None:
    text = '{"particle": false, "axes": {"frequency_ratio": [0.5, 1]}}'
    study = parse_study_text(text, "json")
    store = Store.open(tmp_path / "data")
    record = enter(store, study, study.shape)
    # What a process leaves that was killed: a running study, and a claim that nobody renews.
    assert store.claim(record.id, "a process that died", seconds=0.5)
    store.set_state(record.id, "running")
    store.close()
    service = own_service()
    with httpx.Client(base_url=service.url, timeout=300) as client:
        assert helpers.wait_for(client, record.id, helpers.ended)["state"] == "done"
    assert service.stop() == 0


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
