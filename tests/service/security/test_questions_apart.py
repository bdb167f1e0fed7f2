"""Questions to large cubes, answered by a process apart: the same answers, refusals and tags."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import httpx
import pytest

from damperlab.service.edge.conditional import TAGGED_BYTES

STUDY = {
    "name": "curve",
    "particle": False,
    "damping_ratio": 0.0038,
    "axes": {"friction_ratio": 0, "frequency_ratio": {"start": 0.5, "stop": 1.5, "num": 11}},
}


def test_the_same_is_answered_apart(
    own_service: Callable[..., Any], client: httpx.Client, curve: dict[str, Any], helpers: Any
) -> None:
    running = own_service(DAMPERLAB_QUESTION_POINTS_APART="0")
    with httpx.Client(base_url=running.url, timeout=300) as apart:
        made = apart.post("/api/v1/studies", json=STUDY).json()
        helpers.wait_for(apart, made["id"], helpers.ended)
        assert made["digest"] == curve["digest"]
        url = f"/api/v1/studies/{curve['id']}"

        assert helpers.computing(running) == []
        for question in (
            "frequency-response",
            "frequency-response?metric=nonsense",
            "frequency-response?odd=1",
            "resonance-map?x=frequency_ratio&y=friction_ratio",
            "optimal-designs?objective=peak",
            "tmd-comparison?mass_ratio=0.05",
            "work-precision",
        ):
            here, there = (each.get(f"{url}/{question}") for each in (client, apart))
            assert there.status_code == here.status_code, (question, there.text)
            assert there.headers["content-type"] == here.headers["content-type"]
            one, other = here.json(), there.json()
            for volatile in ("request_id", "run_time"):
                one.pop(volatile, None), other.pop(volatile, None)
            if "work-precision" not in question:
                assert other == one, question
        assert len(helpers.computing(running)) == 1
        first = apart.get(f"{url}/frequency-response")
        assert apart.get(f"{url}/frequency-response").content == first.content
        again = apart.get(f"{url}/frequency-response", headers={"If-None-Match": first.headers["etag"]})
        assert again.status_code == 304
        assert apart.get("/api/v1/studies/000000000000/frequency-response").status_code == 404


def test_an_answer_is_kept_while_the_study_stays_as_it_is(client: httpx.Client, helpers: Any) -> None:
    study = {**STUDY, "damping_ratio": 0.0041, "axes": {**STUDY["axes"], "friction_ratio": [0, 0.1]}}  # type: ignore[dict-item]
    url = f"/api/v1/studies/{client.post('/api/v1/studies', json=study).json()['id']}"
    seen = []
    while not seen or seen[-1]["state"] != "done":
        seen.append(client.get(url).json())
        answer = client.get(f"{url}/frequency-response")
        assert answer.status_code in (200, 409)
    record = helpers.wait_for(client, seen[-1]["id"], helpers.ended)
    first, again = (client.get(f"{url}/frequency-response").json() for _ in range(2))
    assert first == again
    assert first["complete"] == record["points_done"] / record["points_total"] == 1.0
    helpers.wait_until(lambda: client.delete(url).status_code == 204)
    assert client.get(f"{url}/frequency-response").status_code == 404


@pytest.mark.night
def test_a_long_answer_is_handed_on_as_it_is_read(
    own_service: Callable[..., Any], client: httpx.Client, helpers: Any, tmp_path: Path
) -> None:
    study = {
        "name": "large map",
        "particle": False,
        "damping_ratio": {"start": 0.01, "stop": 0.3, "num": 500},
        "axes": {"friction_ratio": 0, "frequency_ratio": {"start": 0.5, "stop": 1.5, "num": 500}},
    }
    left = tmp_path / "left"
    left.mkdir()
    running = own_service(DAMPERLAB_QUESTION_POINTS_APART="0", TMPDIR=str(left))
    with httpx.Client(base_url=running.url, timeout=300) as apart:
        answers = []
        for each in (client, apart):
            made = each.post("/api/v1/studies", json=study).json()
            helpers.wait_for(each, made["id"], helpers.ended)
            url = f"/api/v1/studies/{made['id']}/resonance-map?x=frequency_ratio&y=damping_ratio"
            answers.append(each.get(url))
        assert len(answers[0].content) > TAGGED_BYTES
        assert answers[1].content == answers[0].content
        plain = apart.get(url, headers={"Accept-Encoding": "identity"})
        assert plain.content == answers[0].content
        assert int(plain.headers["content-length"]) == len(plain.content)
        # whoever leaves in the middle stops it, and its file goes with it
        with apart.stream("GET", url, headers={"Accept-Encoding": "identity"}) as answer:
            next(answer.iter_raw(1000))

        def kept() -> list[Path]:
            return [path for path in left.rglob("*") if path.is_file() and path.stat().st_size > TAGGED_BYTES]

        helpers.wait_until(lambda: not kept())
