"""Which studies every door lists: those that somebody asked for, by tags and values."""

import json
from typing import Any

import httpx
import pytest
from tests.service.cli.commands import run
from tests.service.conftest import computed

from damperlab.service.client import Client
from damperlab.studies.definition import parse_study
from damperlab.studies.plan import make_plan
from damperlab.studies.store.provenance import DESIGNS, REFINES
from damperlab.studies.store.store import Store
from damperlab.worker.dispatch.cost_model import seconds_per_point
from damperlab.worker.provenance import provenance


def test_studies_of_programs_are_listed_where_they_are_asked_for(
    client: httpx.Client, service: Any, store: Store
) -> None:
    for place, more in enumerate(({}, {DESIGNS: "d"}, {REFINES: "r"})):
        axes = {"friction_ratio": place / 10, "frequency_ratio": [0.5, 1.0]}
        document = {"name": f"listed {place}", "particle": False, "damping_ratio": 0.0173, "axes": axes}
        study = parse_study(document)
        record, _ = store.submit(study, make_plan(study, seconds_per_point), provenance() | more)
        store.set_state(record.id, "cancelled")
    with Client(service.url) as python:
        for designs, names in ((False, ["listed 0"]), (True, ["listed 2", "listed 1", "listed 0"])):
            query = {"designs": "true"} if designs else {}
            page = client.get("/api/v1/studies", params=query).json()["studies"]
            option = ["--designs"] if designs else []
            told = json.loads(
                run("studies", "--limit", "500", "--data-dir", store.data_dir, "--json", *option).stdout
            )
            doors = [[one["name"] for one in each] for each in (page, told["studies"])]
            doors.append([study.name for study in python.studies(designs=designs)])
            for found in doors:
                assert [name for name in found if name.startswith("listed ")] == names


@pytest.fixture
def made(service: Any) -> dict[str, Any]:
    axes = {"friction_ratio": [0.37, 0.39], "frequency_ratio": 1.0}
    study = {"name": "remarked", "particle": False, "damping_ratio": 0.031, "axes": axes}
    return computed(service, study)


def listed(client: httpx.Client, **query: Any) -> list[str]:
    return [
        one["id"] for one in client.get("/api/v1/studies", params=query).raise_for_status().json()["studies"]
    ]


def test_a_study_is_tagged_and_found(client: httpx.Client, service: Any, made: dict[str, Any]) -> None:
    url = f"/api/v1/studies/{made['id']}"
    now = client.patch(url, json={"tags": ["steel", "rig-7"], "note": "Shaker, May."}).raise_for_status()
    assert (now.json()["tags"], now.json()["note"]) == (["rig-7", "steel"], "Shaker, May.")
    assert client.get(url).json()["tags"] == ["rig-7", "steel"]
    assert listed(client, tag="rig-7") == [made["id"]]
    assert listed(client, tag="rig-8") == []
    assert made["id"] in listed(client, axis="friction_ratio", **{"from": 0.38, "to": 0.385}, tag="steel")
    assert listed(client, axis="friction_ratio", **{"from": 0.4}, tag="steel") == []
    assert client.patch(url, json={"tags": []}).json()["note"] == "Shaker, May."
    # a whole id, and a body that no form of another page can send
    assert client.patch(url[:-6], json={"note": "n"}).status_code == 404
    plain = {"Content-Type": "text/plain"}
    assert client.patch(url, content="{}", headers=plain).status_code == 415
    with Client(service.url) as python:
        study = python.study(made["id"]).remark(tags={"from-python"}, note="n")
        assert (study.record.tags, study.record.note) == (("from-python",), "n")
        assert python.studies(tag="from-python") == [study]
        assert study in python.studies(within=("friction_ratio", None, 0.37))
        assert study not in python.studies(within=("friction_ratio", 0.5, None))
