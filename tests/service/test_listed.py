"""Which studies every door lists: those that somebody asked for, not those that designs and refinements did."""

import json
from typing import Any

import httpx
from tests.service.cli.commands import run

from damperlab.service.client import Client
from damperlab.studies.definition import parse_study
from damperlab.studies.plan import make_plan
from damperlab.studies.store.provenance import DESIGNS, REFINES
from damperlab.studies.store.store import Store
from damperlab.worker.dispatch.cost_model import seconds_per_point
from damperlab.worker.provenance import provenance


def test_studies_of_programs_are_listed_where_they_are_asked_for(service: Any) -> None:
    data = service.log.parent / "data"
    store = Store.open(data)
    for place, more in enumerate(({}, {DESIGNS: "d"}, {REFINES: "r"})):
        axes = {"friction_ratio": place / 10, "frequency_ratio": [0.5, 1.0]}
        document = {"name": f"listed {place}", "particle": False, "damping_ratio": 0.0173, "axes": axes}
        study = parse_study(document)
        record, _ = store.submit(study, make_plan(study, seconds_per_point), provenance() | more)
        store.set_state(record.id, "cancelled")
    store.close()
    with Client(service.url) as client:
        for designs, names in ((False, ["listed 0"]), (True, ["listed 2", "listed 1", "listed 0"])):
            query = {"designs": "true"} if designs else {}
            page = httpx.get(f"{service.url}/api/v1/studies", params=query, timeout=60).json()["studies"]
            option = ["--designs"] if designs else []
            told = json.loads(run("studies", "--limit", "500", "--data-dir", data, "--json", *option).stdout)
            doors = [[one["name"] for one in each] for each in (page, told["studies"])]
            doors.append([study.name for study in client.studies(designs=designs)])
            for found in doors:
                assert [name for name in found if name.startswith("listed ")] == names
