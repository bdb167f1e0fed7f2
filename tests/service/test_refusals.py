"""Every error is a problem document (RFC 9457) that says what was found, what is allowed and what to do."""

from collections.abc import Iterator
from typing import Any

import httpx
import pytest

STUDIES = "/api/v1/studies"
LIMIT = 4 * 1024 * 1024


def _problem(answer: httpx.Response, status: int) -> dict[str, object]:
    assert answer.status_code == status
    assert answer.headers["content-type"] == "application/problem+json"
    document: dict[str, object] = answer.json()
    assert {"type", "title", "status", "detail", "instance"} <= set(document)
    assert document["status"] == status
    assert document["request_id"] == answer.headers["x-request-id"]
    return document


@pytest.mark.parametrize(
    "path", ["/nothing", "/api/v1/studies/", f"{STUDIES}/000000000000", "/docs", "/redoc"]
)
def test_address_that_is_not_there(client: httpx.Client, path: str) -> None:
    _problem(client.get(path), 404)


@pytest.mark.parametrize(
    ("method", "path", "allowed"),
    [
        ("PUT", STUDIES, {"GET", "HEAD", "POST"}),
        ("GET", "/api/v1/simulate", {"POST"}),
        ("POST", "/health/live", {"GET", "HEAD"}),
    ],
)
def test_method_that_is_not_there_names_those_that_are(
    client: httpx.Client, method: str, path: str, allowed: set[str]
) -> None:
    answer = client.request(method, path)
    _problem(answer, 405)
    assert allowed == set(answer.headers["allow"].split(", "))


@pytest.mark.parametrize("path", [STUDIES, "/api/v1/simulate"])
@pytest.mark.parametrize(
    "headers",
    [
        {},
        {"content-type": "application/xml"},
        {"content-type": "application/json; charset=latin-1"},
        {"content-type": "application/json", "content-encoding": "gzip"},
        {"content-type": "text"},
    ],
)
def test_body_in_another_format(client: httpx.Client, path: str, headers: dict[str, str]) -> None:
    answer = client.post(path, content=b"{}", headers=headers)
    assert _problem(answer, 415)["errors"]
    assert "application/json" in answer.headers["accept"]


def _endless(length: int) -> Iterator[bytes]:
    sent = 0
    while sent < length:
        yield b" " * 65536
        sent += 65536


@pytest.mark.parametrize("path", [STUDIES, "/api/v1/simulate"])
def test_body_over_the_limit_announced_or_not(client: httpx.Client, path: str) -> None:
    headers = {"content-type": "application/json"}
    _problem(client.post(path, content=b" " * (LIMIT + 1), headers=headers), 413)
    _problem(client.post(path, content=_endless(2 * LIMIT), headers=headers), 413)
    # One byte less is read, and refused for what it says.
    _problem(client.post(path, content=b" " * LIMIT, headers=headers), 422)


@pytest.mark.parametrize("path", [STUDIES, "/api/v1/simulate"])
@pytest.mark.parametrize(
    "body",
    [
        b"",
        b"null",
        b"[]",
        b'"text"',
        b"\xff\xfe",
        b"{",
        b'{"axes": NaN}',
        b'{"frequency_ratio": Infinity}',
        b'{"a": 1, "a": 2}',
        b"[" * 100_000,
        b'{"a":' * 50_000,
        b'{"cycles": ' + b"9" * 10_000 + b"}",
        b'{"\\ud800": "\\udfff"}',
        b'{"name": "\\u0000"}',
    ],
)
def test_body_that_is_no_request(client: httpx.Client, path: str, body: bytes) -> None:
    answer = client.post(path, content=body, headers={"content-type": "application/json"})
    for fault in _problem(answer, 422)["errors"]:  # type: ignore[attr-defined]
        assert all(fault[key] for key in ("field", "found", "allowed", "advice"))


def test_parameters_are_checked_by_name_and_value(client: httpx.Client) -> None:
    answer = client.get(STUDIES, params={"limit": "many", "stat": "done", "state": "asleep"})
    faults = {fault["field"]: fault for fault in _problem(answer, 422)["errors"]}  # type: ignore[attr-defined]
    assert set(faults) == {"limit", "stat", "state"}
    assert "state" in faults["stat"]["advice"]
    _problem(client.get(STUDIES, params={"cursor": "@"}), 422)
    _problem(client.post(STUDIES, params={"dry_run": "perhaps"}, json={}), 422)


@pytest.mark.parametrize(
    ("method", "path", "body"),
    [
        ("POST", f"{STUDIES}?dry_run=true&dry_run=false", {"axes": {}}),
        ("POST", "/api/v1/designs?dry_run=true&dry_run=true", {}),
        ("POST", "/api/v1/simulate?dry_run=false&dry_run=true", {}),
        ("GET", f"{STUDIES}?limit=1&limit=2", None),
        ("GET", f"{STUDIES}/000000000000/optimal-designs?top=1&top=2", None),
    ],
)
def test_a_parameter_that_is_given_twice_is_refused(
    client: httpx.Client, method: str, path: str, body: dict[str, object] | None
) -> None:
    document = _problem(client.request(method, path, json=body), 422)
    name = path.partition("?")[2].partition("=")[0]
    assert document["errors"][0]["field"] == name
    assert "given more than once" in str(document)


TWICE = '"odd": 1, "odd": 2'


@pytest.mark.parametrize(
    ("method", "path", "body", "field"),
    [
        ("POST", STUDIES, "{%s}", "odd"),
        ("POST", "/api/v1/designs", "{%s}", "odd"),
        ("POST", "/api/v1/simulate", '{"frequency_ratio": 1, "contact": {%s}}', "contact.odd"),
        ("POST", "/api/v1/earthquake-comparisons", "{%s}", "odd"),
        ("POST", "/api/v1/fits", '{"structure": {%s}}', "structure.odd"),
        ("POST", "/api/v1/fits", '{"specification": {"limits": {%s}}}', "specification.limits.odd"),
        ("POST", "/api/v1/records", '{"kanai_tajimi": {%s}}', "kanai_tajimi.odd"),
        ("POST", "/api/v1/session", "{%s}", "odd"),
        ("PATCH", f"{STUDIES}/{{id}}", '{"note": "a", %s}', "odd"),
        # these take no body at all
        ("POST", f"{STUDIES}/{{id}}/refine", "{%s}", "body"),
        ("POST", f"{STUDIES}/{{id}}/race", "{%s}", "body"),
    ],
)
def test_a_key_that_is_given_twice_in_a_body_is_refused(
    client: httpx.Client, curve: dict[str, Any], method: str, path: str, body: str, field: str
) -> None:
    url = path.replace("{id}", curve["id"])
    sent = client.request(method, url, content=body % TWICE, headers={"Content-Type": "application/json"})
    errors: Any = _problem(sent, 422)["errors"]
    assert field in [
        each["field"] for each in errors if "more than once" in each["message"] or field == "body"
    ]


def test_request_id_of_the_client_is_kept_if_it_is_harmless(client: httpx.Client) -> None:
    assert client.get("/health/live", headers={"x-request-id": "abc-1"}).headers["x-request-id"] == "abc-1"
    assert client.get("/health/live", headers={"x-request-id": "a b;c"}).headers["x-request-id"] != "a b;c"


@pytest.mark.parametrize(
    ("query", "found", "allowed"),
    [
        ("limit=0", "0", "at least 1"),
        ("limit=201", "201", "at most 200"),
        ("limit=many", 'the text "many"', "a whole number"),
        ("coarse=perhaps", 'the text "perhaps"', "true or false"),
    ],
)
def test_a_parameter_is_refused_with_what_was_found_and_what_is_allowed(
    client: httpx.Client, query: str, found: str, allowed: str
) -> None:
    (fault,) = client.get(f"{STUDIES}?{query}").json()["errors"]
    assert (fault["field"], fault["found"], fault["allowed"]) == (query.partition("=")[0], found, allowed)
    assert fault["message"] == f"`{fault['field']}` must be {allowed}, not {found}."
