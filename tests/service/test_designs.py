"""Designs over HTTP, on a real service: asked for, followed, stopped, resumed, killed, deleted."""

import json
import math
import signal
from collections.abc import Callable
from pathlib import Path
from typing import Any

import httpx
import psutil
import pytest
from tests.service.cli.commands import run
from tests.service.conftest import SPECIFICATION, ended, wait_for_design, wait_until
from tests.service.contract import check

from damperlab import Client
from damperlab.studies.design.shelf import Shelf
from damperlab.studies.store.store import Store

DESIGNS = "/api/v1/designs"


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """What the command line answers, on a folder of its own."""
    folder = tmp_path_factory.mktemp("undisturbed")
    (folder / "spec.json").write_text(json.dumps(SPECIFICATION))
    told = run("design", folder / "spec.json", "--data-dir", folder / "data", "--json")
    answer: dict[str, Any] = json.loads(told.stdout)
    return answer


def test_answers_about_a_design_are_as_their_schemas_say(
    client: httpx.Client, design: dict[str, Any]
) -> None:
    one = f"{DESIGNS}/{design['id']}"
    check("get", DESIGNS, client.get(DESIGNS, params={"limit": 1}))
    check("get", f"{DESIGNS}/{{design_id}}", client.get(one))
    for parameters in ({}, {"dry_run": True}):
        answer = client.post(DESIGNS, json=design["specification"], params=parameters)
        check("post", DESIGNS, answer)


def test_a_design_is_kept_once_with_its_studies_and_its_report(
    client: httpx.Client, design: dict[str, Any]
) -> None:
    listed = client.get("/api/v1/studies", params={"limit": 200, "name": "small <floor>"}).json()["studies"]
    records = [client.get(f"/api/v1/studies/{each['id']}").json() for each in listed]
    assert {record["provenance"]["designs"] for record in records} == {design["digest"]}
    again = client.post(DESIGNS, json=SPECIFICATION | {"name": "another name"})
    assert (again.status_code, again.json()) == (200, design)
    for reference in (design["id"][:6], design["name"]):
        assert client.get(f"{DESIGNS}/{reference}").json()["id"] == design["id"]
    for what in ("cancel", "resume"):
        refused = client.post(f"{DESIGNS}/{design['id']}/{what}")
        assert (refused.status_code, refused.json()["type"]) == (409, "urn:damperlab:problem:design-ended")
    report = client.get(f"{DESIGNS}/{design['id']}/report")
    assert report.headers["content-type"].startswith("text/html")
    assert "default-src 'none'" in report.headers["content-security-policy"]
    assert f"small-floor-{design['id']}.html" in report.headers["content-disposition"]
    assert "small &lt;floor&gt;" in report.text
    assert not any(word in report.text for word in ("<floor>", "http://", "https://", "<script", "<link"))


def test_a_dry_run_keeps_nothing(client: httpx.Client) -> None:
    asked = SPECIFICATION | {"clearance_m": 0.0051}
    before = client.get(DESIGNS).json()
    found = client.post(DESIGNS, json=asked, params={"dry_run": True}).raise_for_status().json()
    assert (found["budget_points"], found["chosen"]) == (200, ["friction_force_n"])
    assert found["understood"] == []
    millimetres = client.post(DESIGNS, json=asked | {"clearance_m": 500.0}, params={"dry_run": True})
    assert any("`clearance_m`" in each for each in millimetres.json()["understood"])
    assert client.get(DESIGNS).json() == before


def test_a_specification_may_be_yaml(client: httpx.Client) -> None:
    text = "structure: {damping_ratio: 0.02}\nexcitation: {}\n"
    refused = client.post(DESIGNS, content=text, headers={"Content-Type": "application/yaml"})
    assert refused.status_code == 422
    assert "excitation.frequency_hz" in {fault["field"] for fault in refused.json()["errors"]}


@pytest.mark.parametrize("way", ["", "/report"])
def test_a_design_that_is_not_there_is_not_found(client: httpx.Client, way: str) -> None:
    for reference in ("000000000000", "..", "%2e%2e%2frecords", "x" * 150):
        answer = client.get(f"{DESIGNS}/{reference}{way}")
        assert answer.status_code == 404, (reference, answer.text)


def test_designs_are_listed_page_by_page(client: httpx.Client, design: dict[str, Any]) -> None:
    other = client.post(DESIGNS, json=SPECIFICATION | {"clearance_m": 0.0052, "name": "other"}).json()
    client.post(f"{DESIGNS}/{other['id']}/cancel").raise_for_status()

    def listed(**asked: object) -> tuple[list[str], str | None]:
        page = client.get(DESIGNS, params=asked).json()  # type: ignore[arg-type]
        return [each["id"] for each in page["designs"]], page["cursor"]

    first, cursor = listed(limit=1)
    assert first == [other["id"]]
    assert listed(limit=1, cursor=cursor) == ([design["id"]], None)
    done, _ = listed(state="done")
    assert (design["id"] in done, other["id"] in done) == (True, False)
    assert listed(name="OTH") == ([other["id"]], None)
    client.delete(f"{DESIGNS}/{other['id']}").raise_for_status()


def test_a_design_is_renamed_put_into_the_trash_and_restored(
    client: httpx.Client, service: Any, design: dict[str, Any]
) -> None:
    one = f"{DESIGNS}/{design['id']}"
    renamed = client.patch(one, json={"name": "second draft"})
    check("patch", f"{DESIGNS}/{{design_id}}", renamed)
    assert renamed.json() == design | {"name": "second draft"}
    refused = client.patch(one, json={"tags": ["steel"]})
    assert (refused.status_code, refused.json()["errors"][0]["allowed"]) == (422, "name")
    refused = client.delete(one, params={"dry_run": True})
    assert (refused.status_code, refused.json()["errors"][0]["field"]) == (422, "dry_run")
    with Client(service.url) as python:
        (same,) = python.designs(name="second draft")
        same.rename(design["name"]).delete(trash=True)
        assert "in the trash" in client.get(one).json()["errors"][0]["message"]
        assert [each["id"] for each in client.get(DESIGNS, params={"trash": True}).json()["designs"]] == [
            design["id"]
        ]
        assert same.undelete().record == design
    again = client.post(f"{one}/undelete")
    assert (again.status_code, again.json()["type"]) == (404, "urn:damperlab:problem:design-not-found")


@pytest.mark.night
def test_a_cancelled_design_stops_its_studies_goes_on_and_ends_the_same(
    own_service: Callable[..., Any], undisturbed: dict[str, Any]
) -> None:
    running = own_service()
    with running.client() as client:
        design_id = client.post(DESIGNS, json=SPECIFICATION).json()["id"]
        wait_for_design(client, design_id, lambda now: now["round"] > 1)
        refused = client.delete(f"{DESIGNS}/{design_id}")
        assert refused.json()["type"] == "urn:damperlab:problem:design-busy"
        cancelled = client.post(f"{DESIGNS}/{design_id}/cancel").raise_for_status().json()
        assert cancelled["state"] == "cancelled"
        assert cancelled["points"] > 0
        assert cancelled["known"]["design"]["friction_force_n"] is not None
        listed = client.get("/api/v1/studies", params={"limit": 200, "designs": True}).json()["studies"]
        assert {each["state"] for each in listed} <= {"done", "cancelled"}
        assert client.get(f"{DESIGNS}/{design_id}/report").status_code == 409
        resumed = client.post(f"{DESIGNS}/{design_id}/resume").raise_for_status().json()
        assert resumed["state"] in ("queued", "running")
        now = wait_for_design(client, design_id, ended)
        assert now["state"] == "done", now["message"]
        assert now["answer"] == undisturbed
        assert client.delete(f"{DESIGNS}/{design_id}").status_code == 204
        assert client.get(f"{DESIGNS}/{design_id}").status_code == 404
        assert client.get("/api/v1/studies", params={"designs": True}).json()["studies"]
    assert running.stop() == 0


def _lives(process: psutil.Process) -> bool:
    try:
        lives: bool = process.status() != psutil.STATUS_ZOMBIE
    except psutil.NoSuchProcess:
        return False
    return lives


@pytest.mark.night
@pytest.mark.usefixtures("anew")
def test_a_service_that_is_killed_again_and_again_ends_with_the_same_answer(
    own_service: Callable[..., Any], tmp_path: Path, undisturbed: dict[str, Any]
) -> None:
    design_id = ""
    for beyond in (0, 1, 2):
        running = own_service()
        with running.client() as client:
            design_id = design_id or client.post(DESIGNS, json=SPECIFICATION).json()["id"]
            now = wait_for_design(
                client, design_id, lambda now, least=beyond: now["round"] > least or now["finished"]
            )
            assert not now["finished"], "it ended before it could be killed"
        family = psutil.Process(running.process.pid).children(recursive=True)
        running.stop(signal.SIGKILL)
        wait_until(lambda family=family: not any(map(_lives, family)))
        assert not Shelf(tmp_path / "data").ended(design_id), "a process that was left behind went on with it"
    store = Store.open(tmp_path / "data")
    before = {record.id for record in store.page(200).records if record.state == "done"}
    store.close()
    assert before
    running = own_service()
    with running.client() as client:
        now = wait_for_design(client, design_id, ended)
        assert now["state"] == "done", now["message"]
        assert now["answer"] == undisturbed
    assert running.stop() == 0


@pytest.mark.night
def test_a_quota_smaller_than_a_round_of_a_design_delays_it_and_no_more(
    own_service: Callable[..., Any], undisturbed: dict[str, Any]
) -> None:
    running = own_service(DAMPERLAB_QUOTA_UNFINISHED="1")
    with running.client() as client:
        design_id = client.post(DESIGNS, json=SPECIFICATION).json()["id"]
        now = wait_for_design(client, design_id, ended)
        assert (now["state"], now["answer"]) == ("done", undisturbed)
    assert running.stop() == 0


@pytest.mark.night
def test_a_study_that_is_cancelled_while_its_design_computes_it_stays_cancelled(
    own_service: Callable[..., Any], undisturbed: dict[str, Any]
) -> None:
    """The first look at this band takes several blocks of the process that searches."""
    band = {"base_amplitude_m": 0.001, "frequency_hz": {"start": 6.0, "stop": 10.0}}
    wide = SPECIFICATION | {"excitation": band, "budget_points": 8000}
    wide["choose"] = {
        "clearance_m": [0.001 * k for k in range(2, 12)],
        "friction_force_n": [5.0 * k for k in range(10)],
    }
    del wide["clearance_m"]
    running = own_service()
    with running.client() as client:
        design_id = client.post(DESIGNS, json=wide).json()["id"]
        now = wait_for_design(client, design_id, lambda now: bool(now["studies"]))
        study = f"/api/v1/studies/{now['studies'][0]}"
        wait_until(lambda: client.get(study).status_code == 200)
        assert client.post(f"{study}/cancel").status_code == 200
        cancelled = client.get(study).json()
        assert cancelled["state"] == "cancelled", "it ended before it could be cancelled"
        now = wait_for_design(client, design_id, ended)
        assert now["state"] == "failed"
        assert "is cancelled" in now["message"]
        assert client.get(study).json()["state"] == "cancelled"
        client.post(f"{DESIGNS}/{design_id}/resume").raise_for_status()
        assert wait_for_design(client, design_id, ended)["state"] == "done"
    assert running.stop() == 0


@pytest.mark.night
def test_a_design_whose_record_is_gone_says_so_and_goes_on_once_it_is_back(client: httpx.Client) -> None:
    text = "time (s), acceleration (g)\n" + "\n".join(
        f"{0.02 * step:.2f},{0.2 * math.sin(step):.6f}" for step in range(300)
    )
    headers = {"Content-Type": "text/csv"}
    kept = client.post("/api/v1/records", content=text, headers=headers).json()
    document = SPECIFICATION | {
        "excitation": {"records": kept["id"], "scales": [0.3, 0.7]},
        "limits": {},
    }
    asked = client.post(DESIGNS, json=document).json()
    client.post(f"{DESIGNS}/{asked['id']}/cancel")
    assert client.delete(f"/api/v1/records/{kept['id']}").status_code in (200, 204)
    client.post(f"{DESIGNS}/{asked['id']}/resume")
    failed = wait_for_design(client, asked["id"], lambda each: each["finished"] is not None)
    assert failed["state"] == "failed"
    assert kept["id"] in failed["message"]
    client.post("/api/v1/records", content=text, headers=headers)
    client.post(f"{DESIGNS}/{asked['id']}/resume")
    done = wait_for_design(client, asked["id"], lambda each: each["finished"] is not None)
    assert done["state"] == "done", done["message"]
    assert {each["scale"] for each in done["answer"]["cases"]} == {0.3, 0.7}
