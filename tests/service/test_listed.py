"""Which studies every door lists: those that somebody asked for, not those that designs and refinements did."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import httpx
import pytest
from tests.service.cli.commands import run

from damperlab.service.client import Client
from damperlab.studies.definition import parse_study
from damperlab.studies.plan import make_plan
from damperlab.studies.store.provenance import DESIGNS, REFINES
from damperlab.studies.store.store import Store
from damperlab.worker.dispatch.cost_model import seconds_per_point
from damperlab.worker.provenance import provenance


@pytest.mark.parametrize(("designs", "names"), [(False, ["mine"]), (True, ["followed", "designed", "mine"])])
def test_studies_of_programs_are_listed_where_they_are_asked_for(
    tmp_path: Path, own_service: Callable[..., Any], designs: bool, names: list[str]
) -> None:
    data = tmp_path / "data"
    store = Store.open(data)
    for place, (name, more) in enumerate(
        {"mine": {}, "designed": {DESIGNS: "d"}, "followed": {REFINES: "r"}}.items()
    ):
        axes = {"friction_ratio": place / 10, "frequency_ratio": [0.5, 1.0]}
        study = parse_study({"name": name, "particle": False, "damping_ratio": 0.01, "axes": axes})
        record, _ = store.submit(study, make_plan(study, seconds_per_point), provenance() | more)
        store.set_state(record.id, "cancelled")
        store.set_state(record.id, "done")
    store.close()
    url = own_service(data).url
    query = {"designs": "true"} if designs else {}
    page = httpx.get(f"{url}/api/v1/studies", params=query, timeout=60).raise_for_status().json()
    option = ["--designs"] if designs else []
    listed = json.loads(run("studies", "--data-dir", data, "--json", *option).stdout)
    with Client(url) as client:
        asked = [study.name for study in client.studies(designs=designs)]
    assert [one["name"] for one in page["studies"]] == names
    assert [one["name"] for one in listed["studies"]] == names
    assert asked == names
