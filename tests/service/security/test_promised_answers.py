"""Answers that are promised and fetched later: RFC 7240, ``Prefer: respond-async``."""

import time
from typing import Any

import httpx
import pytest
from starlette.datastructures import Headers
from tests.service.conftest import ends_once_given_up, held, wait_until
from tests.service.security.conftest import ENDLESS, QUICK

from damperlab.service.client.client import Client
from damperlab.service.client.faults import Unreachable
from damperlab.service.work.later import LONGEST_WAIT_SECONDS, WAIT_SECONDS, wait_seconds

SIMULATE = "/api/v1/simulate"
AT_ONCE = {"Prefer": "respond-async, wait=0"}
PATIENTLY = {"Prefer": "respond-async, wait=60"}


@pytest.mark.parametrize(
    ("said", "seconds"),
    [
        ([], None),
        (["wait=3"], None),
        (["respond-async"], WAIT_SECONDS),
        (["respond-async, wait=3"], 3.0),
        (["wait=0", "Respond-Async;x=1"], 0.0),
        (['respond-async, wait="7"'], 7.0),
        (["respond-async, wait=99999"], LONGEST_WAIT_SECONDS),
        (["respond-async, wait=-1"], WAIT_SECONDS),
        (["respond-async, wait=" + "9" * 5000], WAIT_SECONDS),
        (["respond-async, wait=²"], WAIT_SECONDS),
        ([",;=,respond-async=,handling=lenient"], WAIT_SECONDS),
    ],
)
def test_preference_is_read_and_what_is_malformed_counts_as_not_said(
    said: list[str], seconds: float | None
) -> None:
    headers = Headers(raw=[(b"prefer", each.encode("utf-8")) for each in said])
    assert wait_seconds(headers) == seconds


def _fetched(client: httpx.Client, promise: httpx.Response) -> httpx.Response:
    assert promise.status_code == 202
    assert promise.headers["preference-applied"] == "respond-async"
    assert promise.json()["answer"] == promise.headers["location"]
    answers: list[httpx.Response] = []

    def there() -> bool:
        answers.append(client.get(promise.headers["location"]))
        return answers[-1].status_code != 202

    wait_until(there)
    return answers[-1]


def test_promised_answer_is_the_answer(service: Any, client: httpx.Client) -> None:
    straight = client.post(SIMULATE, json=QUICK)
    promised = _fetched(client, client.post(SIMULATE, json=QUICK, headers=AT_ONCE))
    assert (promised.status_code, promised.headers["content-type"]) == (200, "application/json")
    assert promised.json()["state"] == straight.json()["state"]
    assert promised.json()["metrics"].keys() == straight.json()["metrics"].keys()
    # whoever waits long enough is answered at once
    patient = client.post(SIMULATE, json=QUICK, headers=PATIENTLY)
    assert (patient.status_code, patient.json()["state"]) == (200, straight.json()["state"])
    # a refusal is an answer too
    refused = client.post(SIMULATE, json=QUICK | {"frequency_ratio": -1}, headers=AT_ONCE)
    refused = _fetched(client, refused) if refused.status_code == 202 else refused
    assert refused.status_code == 422
    assert refused.json()["errors"][0]["field"] == "frequency_ratio"
    # from Python it is as if there were no promise
    with Client(service.url) as python:
        python._transport._http.headers.update(AT_ONCE)
        found = python.simulate(frequency_ratio=1.0, clearance_ratio=5, friction_ratio=0, cycles=3)
        assert found.state == straight.json()["state"]


@pytest.mark.parametrize("promised", [True, False], ids=["promise", "request"])
def test_what_is_given_up_is_computed_no_longer(apart: Any, promised: bool) -> None:
    with apart.client() as client:

        def give_up(seconds: float) -> None:
            promise = client.post(SIMULATE, json=ENDLESS, headers=AT_ONCE)
            assert promise.status_code == 202
            time.sleep(seconds)
            assert client.get(promise.headers["location"]).status_code == 202
            assert client.delete(promise.headers["location"]).status_code == 204
            gone = client.get(promise.headers["location"])
            assert (gone.status_code, gone.json()["type"]) == (404, "urn:damperlab:problem:no-such-answer")

        def leave(seconds: float) -> None:
            """Before anything is promised."""
            with pytest.raises(httpx.TimeoutException):
                client.post(SIMULATE, json=ENDLESS, headers=PATIENTLY, timeout=seconds)

        assert client.post(SIMULATE, json=QUICK).status_code == 200
        assert ends_once_given_up(held(apart), give_up if promised else leave)


def test_the_client_of_python_gives_up_what_it_no_longer_waits_for(
    service: Any, client: httpx.Client
) -> None:
    promises: list[str] = []
    with Client(service.url) as python:
        transport = python._transport
        transport._http.headers.update(AT_ONCE)
        transport._http.event_hooks["response"].append(
            lambda answer: promises.append(answer.headers.get("location", ""))
        )
        transport._timeout_seconds = 0.0
        with pytest.raises(Unreachable, match="took longer than 0 s"):
            python.simulate(**ENDLESS)  # type: ignore[arg-type]
    assert promises[0].startswith("/api/v1/answers/")
    assert client.get(promises[0]).status_code == 404


def test_an_answer_is_for_who_asked(guarded: Any) -> None:
    with guarded.client("ann") as mine, guarded.client("bob") as theirs, guarded.client(None) as nobody:
        promise = mine.post(SIMULATE, json=QUICK, headers=AT_ONCE)
        where = promise.headers["location"]
        assert theirs.get(where).status_code == 404
        assert theirs.delete(where).status_code == 404
        assert nobody.get(where).status_code == 401
        assert _fetched(mine, promise).status_code == 200
