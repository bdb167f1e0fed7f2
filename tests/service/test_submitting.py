"""Studies over HTTP, one or many: one definition is one study; what is refused is not kept."""

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import httpx
import numpy as np
from tests.service.conftest import ended, wait_for, wait_until

from damperlab import Client
from damperlab.studies.definition import parse_study
from damperlab.studies.plan import Block
from damperlab.studies.store.store import Store
from damperlab.worker.block import solve_block

STUDIES = "/api/v1/studies"
SMALL: dict[str, Any] = {"particle": False, "axes": {"frequency_ratio": [0.5, 1.0]}}


def _count(client: httpx.Client) -> int:
    return len(client.get(STUDIES, params={"limit": 200}).json()["studies"])


def test_new_study_is_created_at_its_location_and_computed(client: httpx.Client) -> None:
    answer = client.post(STUDIES, json={"name": "new", "damping_ratio": 0.011, **SMALL})
    assert answer.status_code == 201
    record = answer.json()
    assert record["points_total"] == 2
    assert record["id"] == record["digest"][:12]
    # By which a later version tells that it must not go on with this cube.
    assert record["provenance"]["kernels"]
    assert client.get(answer.headers["location"]).json()["digest"] == record["digest"]
    done = wait_for(client, record["id"], ended)
    assert (done["state"], done["points_done"], done["points_failed"]) == ("done", 2, 0)
    for action in ("cancel", "resume"):
        assert client.post(f"{STUDIES}/{record['id']}/{action}").status_code == 409


def test_one_definition_in_other_words_is_the_same_study(client: httpx.Client) -> None:
    first = client.post(STUDIES, json={"damping_ratio": 0.012, **SMALL})
    text = (
        "name: other words\naxes:\n  frequency_ratio: [5.0e-1, 1]\nparticle: false\ndamping_ratio: 1.2e-2\n"
    )
    again = client.post(STUDIES, content=text, headers={"content-type": "application/yaml; charset=UTF-8"})
    assert (first.status_code, again.status_code) == (201, 200)
    assert again.json()["digest"] == first.json()["digest"]
    assert again.headers["location"] == first.headers["location"]


def test_dry_run_tells_the_cost_and_stores_nothing(client: httpx.Client) -> None:
    before = _count(client)
    study = {"metrics": ["amplitude_ratio", "status"], "damping_ratio": 0.013, **SMALL}
    answer = client.post(STUDIES, params={"dry_run": "true"}, json=study)
    assert answer.status_code == 200
    estimate = answer.json()
    # One double and one byte for each of the two points.
    assert (estimate["points"], estimate["bytes"]) == (2, 2 * (8 + 1))
    assert estimate["points_stored"] == 0
    assert estimate["blocks"] >= 1
    assert estimate["seconds"] > 0
    assert _count(client) == before
    assert client.get(f"{STUDIES}/{estimate['digest'][:12]}").status_code == 404


def test_list_is_paged_newest_first_without_gaps(client: httpx.Client, curve: dict[str, Any]) -> None:
    for number in range(3):
        client.post(
            STUDIES, json={"name": f"page {number}", "damping_ratio": 0.021 + 0.001 * number, **SMALL}
        )
    found: list[str] = []
    asked = {"limit": "2", "name": "page "}
    while not found or "cursor" in asked:
        page = client.get(STUDIES, params=asked).json()
        assert len(page["studies"]) <= 2
        found += [study["name"] for study in page["studies"]]
        asked = {"limit": "2", "name": "page "} | ({"cursor": page["cursor"]} if page["cursor"] else {})
    assert found == ["page 2", "page 1", "page 0"]
    for state in ("done", "queued"):
        listed = client.get(STUDIES, params={"state": state, "name": "curve", "limit": 200}).json()["studies"]
        assert (curve["id"] in [study["id"] for study in listed]) == (state == "done")
        # Other tests ask this service for curves too.
        assert all(study["state"] == state and "curve" in study["name"] for study in listed)


def _linear(stop: float) -> dict[str, Any]:
    return {"particle": False, "axes": {"frequency_ratio": {"start": 0.5, "stop": stop, "num": 5}}}


def test_reuse_can_be_switched_off(client: httpx.Client) -> None:
    first = client.post(STUDIES, json=_linear(1.5)).json()
    wait_for(client, first["id"], ended)
    finer = {"particle": False, "axes": {"frequency_ratio": {"start": 0.5, "stop": 1.5, "num": 9}}}
    taken = wait_for(client, client.post(STUDIES, json=finer).json()["id"], ended)
    assert taken["points_reused"] == 5
    client.delete(f"{STUDIES}/{taken['id']}").raise_for_status()
    alone = client.post(STUDIES, json=finer, params={"reuse": "false"}).json()
    assert wait_for(client, alone["id"], ended)["points_reused"] == 0


def point(number: int, ratio: float = 0.02) -> dict[str, Any]:
    """One point with friction."""
    axes = {"friction_ratio": 0.3, "frequency_ratio": 1.0}
    return {
        "name": f"point {number}",
        "particle": False,
        "damping_ratio": ratio + 1e-5 * number,
        "axes": axes,
    }


def test_a_list_is_stored_as_a_whole(client: httpx.Client) -> None:
    answer = client.post(STUDIES, json=[point(number) for number in (1, 2, 1)])
    assert answer.status_code == 201
    found = answer.json()["studies"]
    assert [one["name"] for one in found] == ["point 1", "point 2", "point 1"]
    assert [one["created"] for one in found] == [True, True, False]
    assert "definition" not in found[0]
    again = client.post(STUDIES, json=[point(2)])
    assert (again.status_code, again.json()["studies"][0]["id"]) == (200, found[1]["id"])


def test_a_list_with_faults_is_refused_as_a_whole_with_their_places(client: httpx.Client) -> None:
    bad = [
        point(11),
        {**point(12), "damping_ratio": -1},
        {**point(13), "axes": {"friction_ratio": "much"}},
        7,
    ]
    answer = client.post(STUDIES, json=bad)
    assert answer.status_code == 422
    fields = [error["field"] for error in answer.json()["errors"]]
    assert "[1].damping_ratio" in fields
    assert any(field.startswith("[2].axes") for field in fields)
    assert any(field.startswith("[3]") for field in fields)
    # no more are read than are told
    errors = client.post(STUDIES, json=[7] * 150).json()["errors"]
    assert [error["field"] for error in errors[:-1]] == [f"[{place}]" for place in range(99)]
    assert "The studies from [100] on were not read." in errors[-1].values()
    digest = client.post(STUDIES, params={"dry_run": "true"}, json=point(11)).json()["digest"]
    assert client.get(f"{STUDIES}/{digest[:12]}").status_code == 404


def test_lists_that_no_list_may_be(client: httpx.Client) -> None:
    for some in ([], [point(number) for number in range(201)]):
        answer = client.post(STUDIES, json=some)
        assert (answer.status_code, answer.json()["errors"][0]["allowed"]) == (422, "1 to 200 studies")
    long = {"particle": False, "axes": {"frequency_ratio": {"start": 0.5, "stop": 2, "num": 400_000}}}
    answer = client.post(STUDIES, json=[{**long, "damping_ratio": 0.1 + 0.01 * place} for place in range(9)])
    assert (answer.status_code, answer.json()["errors"][0]["field"]) == (422, "[2].axes")
    estimates = client.post(STUDIES, params={"dry_run": "true"}, json=[point(22), point(23)]).json()[
        "studies"
    ]
    assert [one["points"] for one in estimates] == [1, 1]
    assert client.get(f"{STUDIES}/{estimates[0]['digest'][:12]}").status_code == 404


def test_many_small_studies_are_run_together_to_the_same_bits(
    service: Any, remote: Client, store: Store
) -> None:
    before = service.log.read_text().count("run together")
    remote.submit(point(0, 0.06)).wait()  # what must be compiled is compiled alone
    every = [point(number, 0.06) for number in range(1, 21)]
    with ThreadPoolExecutor(8) as pool:
        single = list(pool.map(remote.submit, every[:10]))
    studies = single + remote.submit_all(every[10:])
    for study in studies:
        study.wait()
    wait_until(lambda: service.log.read_text().count("run together") > before)
    for document, study in zip(every, studies, strict=True):
        asked = parse_study(document)
        whole = solve_block(asked, Block.whole(asked.shape))
        cube = store.cube(study.id)
        for name, values in whole.items():
            if name != "run_time":
                assert cube[name].values.tobytes() == np.asarray(values).tobytes()
        record = store.find(study.id)
        assert (record.state, record.points_done, record.owner) == ("done", 1, None)
        said = [what for _, what in store.events(study.id)]
        assert (said[0], said[-1]) == ("submitted", "running to done")
        files = [path for path in Path(store.cube_path(study.id)).rglob("*") if path.is_file()]
        assert len(files) == 3
