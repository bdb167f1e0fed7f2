"""Studies over HTTP: one definition is one study, whatever its spelling; a key stands for one; what is refused is not kept."""

from typing import Any

import httpx
import pytest

STUDIES = "/api/v1/studies"
SMALL: dict[str, Any] = {"particle": False, "axes": {"frequency_ratio": [0.5, 1.0]}}


def _count(client: httpx.Client) -> int:
    return len(client.get(STUDIES, params={"limit": 200}).json()["studies"])


def test_new_study_is_created_at_its_location_and_computed(client: httpx.Client, helpers: Any) -> None:
    answer = client.post(STUDIES, json={"name": "new", "damping_ratio": 0.011, **SMALL})
    assert answer.status_code == 201
    record = answer.json()
    assert record["points_total"] == 2
    assert record["id"] == record["digest"][:12]
    # By which a later version tells that it must not go on with this cube.
    assert record["provenance"]["kernels"]
    assert client.get(answer.headers["location"]).json()["digest"] == record["digest"]
    done = helpers.wait_for(client, record["id"], helpers.ended)
    assert (done["state"], done["points_done"], done["points_failed"]) == ("done", 2, 0)


def test_one_definition_in_other_words_is_the_same_study(client: httpx.Client) -> None:
    first = client.post(STUDIES, json={"damping_ratio": 0.012, **SMALL})
    text = (
        "name: other words\naxes:\n  frequency_ratio: [5.0e-1, 1]\nparticle: false\ndamping_ratio: 1.2e-2\n"
    )
    again = client.post(STUDIES, content=text, headers={"content-type": "application/yaml; charset=UTF-8"})
    assert (first.status_code, again.status_code) == (201, 200)
    assert again.json()["digest"] == first.json()["digest"]
    assert again.headers["location"] == first.headers["location"]


def test_definition_of_a_record_can_be_submitted_again(client: httpx.Client, curve: dict[str, Any]) -> None:
    again = client.post(STUDIES, json=curve["definition"])
    assert again.status_code == 200
    assert again.json()["id"] == curve["id"]


def test_dry_run_tells_the_cost_and_stores_nothing(client: httpx.Client) -> None:
    before = _count(client)
    study = {"metrics": ["amplitude_ratio", "status"], "damping_ratio": 0.013, **SMALL}
    answer = client.post(STUDIES, params={"dry_run": "true"}, json=study)
    assert answer.status_code == 200
    estimate = answer.json()
    # One double and one byte for each of the two points.
    assert (estimate["points"], estimate["bytes"]) == (2, 2 * (8 + 1))
    assert estimate["blocks"] >= 1
    assert estimate["seconds"] > 0
    assert _count(client) == before
    assert client.get(f"{STUDIES}/{estimate['digest'][:12]}").status_code == 404


def test_dry_run_of_a_study_of_ten_million_points_holds_no_list_of_them(client: httpx.Client) -> None:
    axis = {"start": 0.1, "stop": 0.9, "num": 10_000}
    axes = {"friction_ratio": axis, "frequency_ratio": {"start": 0.5, "stop": 2, "num": 1000}}
    answer = client.post(STUDIES, params={"dry_run": "true"}, json={"particle": False, "axes": axes})
    assert answer.json()["points"] == 10_000_000


@pytest.mark.parametrize(
    ("kind", "text", "place"),
    [
        ("application/json", '{"axes": {\n  "frequency_ratio": ,\n}}', "line 2, column 22"),
        ("application/yaml", "axes:\n  frequency_ratio: [1, 2\nparticle: false\n", "line"),
    ],
)
def test_malformed_text_is_refused_with_its_place(
    client: httpx.Client, kind: str, text: str, place: str
) -> None:
    answer = client.post(STUDIES, content=text, headers={"content-type": kind})
    assert answer.status_code == 422
    assert place in str(answer.json()["errors"][0])


def test_list_is_paged_newest_first_without_gaps(client: httpx.Client, curve: dict[str, Any]) -> None:
    for number in range(3):
        client.post(
            STUDIES, json={"name": f"page {number}", "damping_ratio": 0.021 + 0.001 * number, **SMALL}
        )
    found: list[str] = []
    cursor = None
    while True:
        params = {"limit": "2", "name": "page "} | ({"cursor": cursor} if cursor else {})
        page = client.get(STUDIES, params=params).json()
        assert len(page["studies"]) <= 2
        found += [study["name"] for study in page["studies"]]
        cursor = page["cursor"]
        if cursor is None:
            break
    assert found == ["page 2", "page 1", "page 0"]
    done = client.get(STUDIES, params={"state": "done", "name": "curve", "limit": 200}).json()["studies"]
    assert curve["id"] in [study["id"] for study in done]
    # Other tests ask this service for curves too.
    assert all(study["state"] == "done" and "curve" in study["name"] for study in done)
    waiting = client.get(STUDIES, params={"state": "queued", "name": "curve"}).json()["studies"]
    assert curve["id"] not in [study["id"] for study in waiting]


def test_finished_study_can_be_neither_cancelled_nor_resumed(
    client: httpx.Client, curve: dict[str, Any]
) -> None:
    for action in ("cancel", "resume"):
        answer = client.post(f"{STUDIES}/{curve['id']}/{action}")
        assert answer.status_code == 409
        assert answer.headers["content-type"] == "application/problem+json"


def test_delete_wants_the_whole_id_and_leaves_nothing(client: httpx.Client, helpers: Any) -> None:
    study = {"name": "to delete", "damping_ratio": 0.031, **SMALL}
    record = client.post(STUDIES, json=study).json()
    helpers.wait_for(client, record["id"], helpers.ended)
    assert client.delete(f"{STUDIES}/{record['id'][:11]}").status_code == 404
    assert client.delete(f"{STUDIES}/{record['id']}").status_code == 204
    assert client.get(f"{STUDIES}/{record['id']}").status_code == 404
    assert client.post(STUDIES, json=study).status_code == 201


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
