"""Heads, bodies and targets that used to bring down an answer, or that try to lead elsewhere."""

import json
from pathlib import Path
from typing import Any

import httpx
import pytest
from tests.service.cli.commands import run
from tests.service.conftest import ended, wait_for
from tests.service.security.raw import ask, host_of, send_raw

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
    assert answer.status in (400, 415, 422, 431), answer
    assert "application/problem+json" in answer.head


def test_a_head_that_is_too_long_is_refused(service: Any) -> None:
    for size in (40_000, 120_000):
        answer = send_raw(
            service.url, _post(service.url, "/api/v1/studies", b"application/json" + b";" * size)
        )
        assert answer.status == 431
        assert "application/problem+json" in answer.head


@pytest.mark.parametrize(
    ("path", "sizes", "status"),
    [
        ("/api/v1/studies", (LIMIT + 1, LIMIT + 70_000, 3 * LIMIT), 413),
        ("/api/v1/simulate", (LIMIT + 1,), 413),
        ("/api/v1/records", (LIMIT + 1,), 413),
        ("/api/v1/nothing", (LIMIT,), 404),
    ],
)
def test_a_body_that_is_not_read_is_answered_although_the_connection_closes(
    service: Any, path: str, sizes: tuple[int, ...], status: int
) -> None:
    for size in sizes:
        answer = send_raw(service.url, _post(service.url, path, b"application/json", b" " * size))
        assert answer.status == status


@pytest.mark.parametrize(
    "request_bytes",
    [b"GET / HTTP/1.1\r\nbad header\r\n\r\n", b"\x00\x01\r\n\r\n", b"GET / HTTP/1.1\r\n\r\n"],
)
def test_what_is_no_http_gets_a_problem_document(service: Any, request_bytes: bytes) -> None:
    answer = send_raw(service.url, request_bytes)
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


STUDIES = "/api/v1/studies"


def _answers(url: str, request: bytes) -> list[int]:
    """Send bytes and give the statuses of all answers, until the connection ends."""
    received, statuses = ask(url, request), []
    while received.startswith(b"HTTP/1.1 "):
        head, _, rest = received.partition(b"\r\n\r\n")
        statuses.append(int(head[9:12]))
        length = head.lower().partition(b"content-length: ")[2].partition(b"\r\n")[0]
        received = rest[int(length or b"0") :]
    return statuses


SMUGGLED = b"DELETE /api/v1/studies/000000000000 HTTP/1.1\r\nHost: %(host)b\r\n\r\n"


@pytest.mark.parametrize(
    "framing",
    [
        b"Content-Length: 5\r\nTransfer-Encoding: chunked\r\n",
        b"Transfer-Encoding: chunked\r\nContent-Length: 5\r\n",
        b"Content-Length: 5\r\nContent-Length: 90\r\n",
        b"Content-Length: 5, 90\r\n",
        b"Content-Length: +5\r\n",
        b"Content-Length: 0x5\r\n",
        b"Content-Length : 5\r\n",
        b"Content-Length:\x0b5\r\n",
        b"Transfer-Encoding: chunked, identity\r\n",
        b"Transfer-Encoding: xchunked\r\n",
        b"Transfer-Encoding: chunked\r\nTransfer-Encoding: identity\r\n",
        b"Transfer-Encoding\x00: chunked\r\n",
        b"X: y\r\n Content-Length: 5\r\n",
        b"X: y\nContent-Length: 5\r\n",
    ],
)
def test_no_request_hides_in_another(service: Any, framing: bytes) -> None:
    """Where two readers could differ on where a body ends, one answer comes and the connection ends, or both see the same."""
    host = host_of(service.url)
    hidden = SMUGGLED % {b"host": host}
    head = b"POST /api/v1/studies HTTP/1.1\r\nHost: " + host + b"\r\n"
    head += b"Content-Type: application/json\r\n" + framing + b"\r\n"
    statuses = _answers(service.url, head + b"0\r\n\r\n" + hidden)
    assert statuses, framing
    # the hidden one is answered 404 where it is served
    assert statuses[0] in (400, 411, 415, 422, 501), statuses
    if b"Content-Length: 5" in framing and framing.count(b"chunked"):
        assert statuses == [400], statuses
    if statuses[0] in (400, 501):
        assert len(statuses) == 1, statuses


@pytest.mark.parametrize(
    ("line", "statuses"),
    [
        (b"GET http://evil.example/api/v1/studies HTTP/1.1", (400, 404, 421)),
        (b"GET //evil.example/api/v1/studies HTTP/1.1", (404,)),
        (b"GET /api/v1/../../etc/passwd HTTP/1.1", (404,)),
        (b"GET /page/..%2f..%2f..%2fetc%2fpasswd HTTP/1.1", (404,)),
        (b"GET /page/%2e%2e/%2e%2e/etc/passwd HTTP/1.1", (404,)),
        (b"GET /page/main.js%00.html HTTP/1.1", (404,)),
        (b"GET /api/v1/studies/..%2f..%2fcatalogue.sqlite/export HTTP/1.1", (404, 422)),
        (b"GET /api/v1/studies/x/zarr/../../../catalogue.sqlite HTTP/1.1", (404, 410)),
        (b"GET /api/v1/studies/x/zarr/%2fetc%2fpasswd HTTP/1.1", (404, 410)),
        (b"DELETE /api/v1/records/..%2f..%2fcatalogue HTTP/1.1", (404,)),
        (b"OPTIONS * HTTP/1.1", (400, 404, 405)),
        (b"CONNECT 127.0.0.1:22 HTTP/1.1", (400, 404, 405)),
        (b"PRI * HTTP/2.0", (400, 404, 405, 505)),
    ],
)
def test_odd_targets_lead_nowhere(service: Any, line: bytes, statuses: tuple[int, ...]) -> None:
    answer = send_raw(
        service.url, line + b"\r\nHost: " + host_of(service.url) + b"\r\nConnection: close\r\n\r\n"
    )
    assert answer.status in statuses
    assert "application/problem+json" in answer.head
    assert b"root:" not in answer.body
    assert b"SQLite" not in answer.body


def test_http_1_0_is_answered_once_and_closed(service: Any) -> None:
    for host in (b"", b"Host: " + host_of(service.url) + b"\r\n"):
        answer = send_raw(service.url, b"GET /health/live HTTP/1.0\r\n" + host + b"\r\n")
        assert answer.status == 200
        assert "connection: close" in answer.head
    refused = send_raw(service.url, b"GET /health/live HTTP/1.0\r\nHost: evil.example\r\n\r\n")
    assert refused.status == 421


def test_nothing_is_upgraded(service: Any) -> None:
    for protocol in (b"websocket", b"h2c"):
        more = b"Upgrade: " + protocol + b"\r\nConnection: Upgrade, close\r\nSec-WebSocket-Version: 13\r\n"
        more += b"Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nHTTP2-Settings: AAMAAABkAAQAAP__\r\n\r\n"
        answer = send_raw(
            service.url, b"GET /api/v1/studies HTTP/1.1\r\nHost: " + host_of(service.url) + b"\r\n" + more
        )
        assert answer.status in (200, 400)
        assert "upgrade" not in answer.head


def test_a_name_puts_no_header_into_an_answer(client: httpx.Client) -> None:
    study = {
        "name": 'x"; filename="evil.exe"\r\nX-Evil: 1',
        "particle": False,
        "axes": {"friction_ratio": 0, "frequency_ratio": [0.6, 0.7, 1.1]},
    }
    made = client.post(STUDIES, json=study)
    if made.status_code == 422:
        study["name"] = 'x"; filename="evil.exe"'
        made = client.post(STUDIES, json=study)
    assert made.status_code == 201, made.text
    wait_for(client, made.json()["id"], ended)
    url = f"{STUDIES}/{made.json()['id']}"
    for path in (f"{url}/export?format=csv", f"{url}/report"):
        answer = client.get(path)
        assert answer.status_code == 200, path
        assert "x-evil" not in answer.headers
        disposition = answer.headers.get("content-disposition", "")
        assert "evil.exe" not in disposition or disposition.count("filename=") <= 1, disposition
    assert client.delete(url).status_code in (204, 409)
