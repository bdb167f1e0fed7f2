"""Many small studies: handed in as lists or by many clients at once, and run together."""

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import httpx
import numpy as np
import pytest

from damperlab import Client
from damperlab.studies.definition import parse_study
from damperlab.studies.plan import Block
from damperlab.studies.store.store import Store
from damperlab.worker.block import solve_block

STUDIES = "/api/v1/studies"


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
    answer = client.post(STUDIES, json=[point(21)], headers={"Idempotency-Key": "one"})
    assert (answer.status_code, answer.json()["errors"][0]["field"]) == (422, "Idempotency-Key")
    long = {"particle": False, "axes": {"frequency_ratio": {"start": 0.5, "stop": 2, "num": 400_000}}}
    answer = client.post(STUDIES, json=[{**long, "damping_ratio": 0.1 + 0.01 * place} for place in range(9)])
    assert (answer.status_code, answer.json()["errors"][0]["field"]) == (422, "[2].axes")
    estimates = client.post(STUDIES, params={"dry_run": "true"}, json=[point(22), point(23)]).json()[
        "studies"
    ]
    assert [one["points"] for one in estimates] == [1, 1]
    assert client.get(f"{STUDIES}/{estimates[0]['digest'][:12]}").status_code == 404


def test_many_small_studies_are_run_together_to_the_same_bits(
    own_service: Any, helpers: Any, tmp_path: Path
) -> None:
    running = own_service()
    with Client(running.url) as client:
        client.submit(point(0)).wait()  # what must be compiled is compiled alone
        every = [point(number) for number in range(1, 21)]
        with ThreadPoolExecutor(8) as pool:
            single = list(pool.map(client.submit, every[:10]))
        studies = single + client.submit_all(every[10:])
        for study in studies:
            study.wait()
    running.stop()
    assert "run together" in running.log.read_text()
    store = Store.open(tmp_path / "data")
    for document, study in zip(every, studies, strict=True):
        asked = parse_study(document)
        whole = solve_block(asked, Block(0, (0,) * 6, asked.shape))
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
    store.close()


@pytest.mark.night
def test_small_studies_that_a_stop_cut_short_are_done_after_it(own_service: Any, tmp_path: Path) -> None:
    running = own_service()
    with Client(running.url) as client:
        client.submit(point(0)).wait()
        studies = client.submit_all([point(number) for number in range(1, 101)])
    running.process.kill()
    running.process.wait()
    running = own_service()
    with Client(running.url) as client:
        for study in studies:
            assert client.study(study.id).wait().state == "done"
