"""No route computes in the process of the service: it reads little, or has a process apart compute, to the same answers."""

import inspect
from collections.abc import Iterator
from contextlib import suppress
from typing import Any, cast

import httpx
import pytest
from fastapi.routing import APIRoute
from tests.service.conftest import CURVE, computed, computing, ends_once_given_up, held, wait_until
from tests.service.security.conftest import every_route

from damperlab.service.app import create_app
from damperlab.service.routes.late import LateRoute
from damperlab.service.settings import Settings

STUDY = "/api/v1/studies/{study_id}"
LIGHT_ROUTES = {
    ("GET", "/"),
    ("GET", "/page/{version}/{name}"),
    ("GET", "/health/live"),
    ("GET", "/health/ready"),
    ("GET", "/metrics"),
    ("GET", "/api/v1/session"),
    ("POST", "/api/v1/session"),
    ("DELETE", "/api/v1/session"),
    ("GET", "/api/v1/catalog"),
    ("POST", f"{STUDY}/undelete"),
    ("GET", "/api/v1/accuracy"),
    ("GET", "/api/v1/accuracy/reports"),
    ("GET", "/api/v1/answers/{answer_id}"),
    ("DELETE", "/api/v1/answers/{answer_id}"),
    ("GET", "/api/v1/records"),
    ("DELETE", "/api/v1/records/{record_id}"),
    ("GET", "/api/v1/studies"),
    ("GET", "/api/v1/studies/{study_id}"),
    ("PATCH", "/api/v1/studies/{study_id}"),
    ("DELETE", "/api/v1/studies/{study_id}"),
    ("GET", f"{STUDY}/axes"),
    ("GET", f"{STUDY}/events"),
    ("GET", f"{STUDY}/versions"),
    ("GET", f"{STUDY}/zarr/{{key:path}}"),
    ("POST", f"{STUDY}/cancel"),
    ("POST", f"{STUDY}/recompute"),
    ("POST", f"{STUDY}/resume"),
    ("POST", f"{STUDY}/retry"),
    ("GET", "/api/v1/designs"),
    ("GET", "/api/v1/designs/{design_id}"),
    ("DELETE", "/api/v1/designs/{design_id}"),
    ("PATCH", "/api/v1/designs/{design_id}"),
    ("POST", "/api/v1/designs/{design_id}/undelete"),
    ("POST", "/api/v1/designs/{design_id}/cancel"),
    ("POST", "/api/v1/designs/{design_id}/resume"),
    # the page of HTML is kept; `document` has a process print it
    ("GET", "/api/v1/designs/{design_id}/report"),
}
"""Routes that read or write a row or a file; all others must go apart."""


def _routes() -> list[APIRoute]:
    every = every_route(create_app(Settings(docs_dir=None)).routes)
    return [cast(APIRoute, route.analysed) for route in every if isinstance(route, LateRoute)]


APART = ({"work", "run"}, {"computed"}, {"is_large", "written"}, {"written"})
"""What a route calls that has its answer computed in a process, of a study where it is large."""


def _goes_apart(route: APIRoute) -> bool:
    return any(names <= set(route.endpoint.__code__.co_names) for names in APART)


def test_every_route_is_light_or_computes_apart() -> None:
    seen = set()
    for route in _routes():
        for method in route.methods or ():
            listed = (method, route.path) in LIGHT_ROUTES
            assert listed + _goes_apart(route) == 1, (method, route.path)
            seen.add((method, route.path))
    assert seen >= LIGHT_ROUTES


THREADED = {"_exact_study", "_design", "_exact_design"}
"""What reads the catalogue or a file before a change, or for a design."""


def test_no_dependency_waits_for_a_thread() -> None:
    """The threads are shared: where all of them wait for a store, what needs none is answered all the same."""

    def calls(dependant: Any) -> Iterator[Any]:
        for each in dependant.dependencies:
            yield each.call
            yield from calls(each)

    found = {call for route in _routes() for call in calls(route.dependant)}
    threaded = [
        call for call in found if not any(map(inspect.iscoroutinefunction, (call, type(call).__call__)))
    ]
    assert {call.__name__ for call in threaded} == THREADED


QUESTIONS = (
    ("GET", "resonance-map?x=frequency_ratio&y=friction_ratio"),
    pytest.param("POST", "refine?dry_run=true", marks=pytest.mark.night),
)


@pytest.fixture(scope="module")
def url(apart: Any) -> str:
    """A finished study of the service that computes apart."""
    return f"/api/v1/studies/{computed(apart, CURVE)['id']}"


def test_the_same_is_answered_apart(
    apart: Any, url: str, client: httpx.Client, curve: dict[str, Any]
) -> None:
    assert url.endswith(curve["id"])
    for process in computing(apart):
        process.kill()
    wait_until(lambda: not computing(apart))
    with apart.client() as other:
        for question in (
            "frequency-response",
            "frequency-response?metric=nonsense",
            "frequency-response?odd=1",
            "resonance-map?x=frequency_ratio&y=friction_ratio",
            "optimal-designs?objective=peak",
        ):
            here, there = (each.get(f"{url}/{question}") for each in (client, other))
            assert there.status_code == here.status_code, (question, there.text)
            assert there.headers["content-type"] == here.headers["content-type"]
            assert there.json() | {"request_id": ""} == here.json() | {"request_id": ""}, question
        assert len(computing(apart)) == 1
        first = other.get(f"{url}/frequency-response")
        assert other.get(f"{url}/frequency-response").content == first.content
        again = other.get(f"{url}/frequency-response", headers={"If-None-Match": first.headers["etag"]})
        assert again.status_code == 304
        assert other.get("/api/v1/studies/000000000000/frequency-response").status_code == 404


@pytest.mark.parametrize(("method", "question"), QUESTIONS)
def test_what_a_study_is_asked_ends_with_its_client(apart: Any, url: str, method: str, question: str) -> None:
    with apart.client() as client:
        assert client.request(method, f"{url}/{question}").status_code in (200, 422)

        def leave(seconds: float) -> None:
            with suppress(httpx.TimeoutException):
                # packed otherwise: what was answered before is kept
                otherwise = {"Accept-Encoding": "identity"}
                client.request(method, f"{url}/{question}", headers=otherwise, timeout=seconds)

        assert ends_once_given_up(held(apart), leave)
        assert client.get(url).status_code == 200
