"""Heads and bodies that used to bring down an answer, or the loop that answers all others."""

import json
from pathlib import Path
from typing import Any

import httpx
import pytest
from tests.service.cli.commands import run
from tests.service.security.raw import host_of, send_raw

LIMIT = 4 * 1024 * 1024


def _post(url: str, path: str, content_type: bytes, body: bytes = b"{}") -> bytes:
    return (
        b"POST %s HTTP/1.1\r\nHost: %s\r\nContent-Type: %s\r\nContent-Length: %d\r\nConnection: close\r\n\r\n%s"
        % (path.encode(), host_of(url), content_type, len(body), body)
    )


@pytest.mark.parametrize("path", ["/api/v1/studies", "/api/v1/simulate", "/api/v1/records"])
@pytest.mark.parametrize(
    "content_type",
    [
        b"application/json; charset*" + b"1" * 5000 + b"=x",
        b"application/json; charset*0*=utf-8''x",
        b"application/json" + b";" * 12_000,
        b'application/json; charset="' + b"\\" * 3000,
    ],
)
def test_odd_parameters_of_a_content_type_are_refused_and_not_parsed(
    service: Any, path: str, content_type: bytes
) -> None:
    answer = send_raw(service.url, _post(service.url, path, content_type))
    assert answer is not None
    assert answer.status in (400, 415, 422, 431), answer
    assert "application/problem+json" in answer.head


def test_a_head_that_is_too_long_is_refused(service: Any) -> None:
    for size in (40_000, 120_000):
        answer = send_raw(
            service.url, _post(service.url, "/api/v1/studies", b"application/json" + b";" * size)
        )
        assert answer is not None
        assert answer.status == 431
        assert "application/problem+json" in answer.head


@pytest.mark.parametrize("path", ["/api/v1/studies", "/api/v1/simulate", "/api/v1/records"])
def test_a_body_over_the_limit_is_answered_although_the_connection_closes(service: Any, path: str) -> None:
    for size in (LIMIT + 1, LIMIT + 70_000, 3 * LIMIT):
        answer = send_raw(service.url, _post(service.url, path, b"application/json", b" " * size))
        assert answer is not None, "the connection was reset before its answer"
        assert answer.status == 413


def test_a_body_for_nothing_is_dropped_and_answered(service: Any) -> None:
    answer = send_raw(service.url, _post(service.url, "/api/v1/nothing", b"application/json", b" " * LIMIT))
    assert answer is not None
    assert answer.status == 404


@pytest.mark.parametrize(
    "request_bytes",
    [b"GET / HTTP/1.1\r\nbad header\r\n\r\n", b"\x00\x01\r\n\r\n", b"GET / HTTP/1.1\r\n\r\n"],
)
def test_what_is_no_http_gets_a_problem_document(service: Any, request_bytes: bytes) -> None:
    answer = send_raw(service.url, request_bytes)
    assert answer is not None
    assert answer.status == 400
    assert "content-type: application/problem+json" in answer.head
    assert "x-request-id:" in answer.head
    document = json.loads(answer.body)
    assert document["status"] == 400
    assert document["request_id"]


def test_unknown_keys_and_values_are_cut(client: httpx.Client) -> None:
    key = "k" * 3_000_000
    for path, body in (
        ("/api/v1/simulate", {key: 1}),
        ("/api/v1/studies", {key: 1}),
        ("/api/v1/records", {key: 1}),
        ("/api/v1/records", {"kanai_tajimi": {key: 1}}),
        ("/api/v1/earthquake-comparisons", {key: 1}),
        ("/api/v1/studies", {"axes": {key: 1}}),
    ):
        answer = client.post(path, json=body)
        assert answer.status_code == 422
        assert len(answer.content) < 4000, path
    answer = client.get("/api/v1/studies", params={"k" * 8000: "v" * 8000})
    assert answer.status_code == 422
    assert len(answer.content) < 4000


def test_a_chunk_of_a_study_that_never_existed_is_not_there(client: httpx.Client) -> None:
    answer = client.get("/api/v1/studies/0123456789ab/zarr/status/c.0.0.0.0.0.0")
    assert answer.status_code == 404


@pytest.mark.parametrize(
    "address",
    [
        "postgresql://user:secret@host:port/db",
        "postgresql://user:secret@127.0.0.1:99999/db",
        "postgresql://user:secret@127.0.0.1/db?foo=bar",
        "postgresql://[::1/db",
    ],
)
def test_an_address_that_is_no_database_is_told_in_a_sentence(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, address: str
) -> None:
    monkeypatch.setenv("DAMPERLAB_CATALOGUE", address)
    told = run("studies", "--data-dir", tmp_path, status=1).stderr
    assert told.startswith("damperlab: ")
    assert "secret" not in told
