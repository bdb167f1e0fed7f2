"""Idempotency-Key: a submission that is sent again is the same submission; a key stands for one definition."""

from typing import Any

import httpx

STUDIES = "/api/v1/studies"


def _linear(stop: float) -> dict[str, Any]:
    return {"particle": False, "axes": {"frequency_ratio": {"start": 0.5, "stop": stop, "num": 5}}}


def test_a_key_stands_for_one_definition(client: httpx.Client) -> None:
    key = {"Idempotency-Key": "9f-1"}
    first = client.post(STUDIES, json=_linear(1.11), headers=key)
    again = client.post(STUDIES, json=_linear(1.11), headers=key)
    assert (first.status_code, again.status_code) == (201, 200)
    assert first.json()["id"] == again.json()["id"]
    other = client.post(STUDIES, json=_linear(1.12), headers=key)
    assert other.status_code == 422
    assert other.json()["type"] == "urn:damperlab:problem:key-taken"
    assert first.json()["id"] in other.json()["errors"][0]["found"]
    # the refused definition was not stored
    assert client.post(STUDIES, json=_linear(1.12)).status_code == 201


def test_a_key_that_is_none_is_refused(client: httpx.Client) -> None:
    for key in ("", "x" * 201):
        answer = client.post(STUDIES, json=_linear(1.13), headers={"Idempotency-Key": key})
        assert answer.status_code == 422
        assert answer.headers["content-type"].startswith("application/problem+json")


def test_reuse_can_be_switched_off(client: httpx.Client, helpers: Any) -> None:
    first = client.post(STUDIES, json=_linear(1.5)).json()
    helpers.wait_for(client, first["id"], helpers.ended)
    finer = {"particle": False, "axes": {"frequency_ratio": {"start": 0.5, "stop": 1.5, "num": 9}}}
    taken = helpers.wait_for(client, client.post(STUDIES, json=finer).json()["id"], helpers.ended)
    assert taken["points_reused"] == 5
    client.delete(f"{STUDIES}/{taken['id']}").raise_for_status()
    alone = client.post(STUDIES, json=finer, params={"reuse": "false"}).json()
    assert helpers.wait_for(client, alone["id"], helpers.ended)["points_reused"] == 0
