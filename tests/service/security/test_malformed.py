"""Malformed heads and bodies over real sockets: each is answered, none by a failure."""

import json
import os
from typing import Any

import httpx
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from tests.service.security.raw import ask, host_of

REQUESTS = int(os.environ.get("MALFORMED_REQUESTS", "120"))
"""How many are sent; `make fuzz` sends 20,000."""
METHODS = [b"GET", b"POST", b"DELETE", b"HEAD", b"PUT", b"OPTIONS", b"get", b"", b"B\x00D", b"\xff"]
PATHS = [
    b"/",
    b"/health/live",
    b"/api/v1/studies",
    b"/api/v1/studies?dry_run=true",
    b"/api/v1/studies?limit=1&limit=2",
    b"/api/v1/simulate?dry_run=true",
    b"/api/v1/earthquake-comparisons?dry_run=true",
    b"/api/v1/records",
    b"/api/v1/session",
    b"/api/v1/studies/0/export",
    b"/%00%ff",
    b"//",
    b"*",
    b"http://evil.example/",
    b"/\xff",
]
VERSIONS = [b"HTTP/1.1", b"HTTP/1.0", b"HTTP/9.9", b"http/1.1", b"", b"HTTP/1.1\x00"]
NAMES = [
    b"Host",
    b"Content-Type",
    b"Content-Length",
    b"Transfer-Encoding",
    b"Expect",
    b"Connection",
    b"Origin",
    b"Cookie",
    b"Authorization",
    b"Range",
    b"If-None-Match",
    b"X-Request-ID",
    b"X-Forwarded-For",
    b"",
    b"Bad Name",
]
VALUES = st.one_of(
    st.sampled_from(
        [
            b"localhost",
            b"application/json",
            b"application/yaml",
            b"application/json; charset*" + b"7" * 900 + b"=x",
            b";" * 1500,
            b"chunked",
            b"gzip, chunked",
            b"100-continue",
            b"0",
            b"2",
            b"-1",
            b"1e3",
            b"99999999999999999999",
            b"close",
            b"keep-alive",
            b"null",
            b"damperlab_session=a.b.c",
            b"Bearer \xff",
            b"bytes=0-",
            b"*",
        ]
    ),
    st.binary(max_size=30),
)
BODIES = st.one_of(
    st.sampled_from(
        [b"", b"{}", b"[]", b"{", b"2\r\n{}\r\n0\r\n\r\n", b"ffffffffffffffffff\r\n", b"zz\r\n", b"\x00" * 50]
    ),
    st.binary(max_size=60),
)
STRUCTURED = st.builds(
    lambda method, path, version, host, headers, body: (
        b"%s %s %s\r\n" % (method, path, version)
        + (b"Host: localhost\r\n" if host else b"")
        + b"".join(b"%s: %s\r\n" % header for header in headers)
        + b"\r\n"
        + body
    ),
    st.sampled_from(METHODS),
    st.sampled_from(PATHS),
    st.sampled_from(VERSIONS),
    st.booleans(),
    st.lists(st.tuples(st.sampled_from(NAMES), VALUES), max_size=5),
    BODIES,
)
BROKEN = st.builds(
    lambda request, place, junk: request[: place % (len(request) + 1)] + junk,
    STRUCTURED,
    st.integers(0, 10**6),
    st.binary(max_size=8),
)


def judge(request: bytes, answer: bytes) -> None:
    """Every request is answered, by no failure, and a refusal is a problem document."""
    if not answer:
        assert not request.strip(), request
        return
    assert answer.startswith(b"HTTP/1.1 "), answer
    head, _, body = answer.partition(b"\r\n\r\n")
    status = int(head[9:12])
    if status == 100:
        head, _, body = body.partition(b"\r\n\r\n")
        status = int(head[9:12] or b"200")
    assert status < 500 or status == 501, (
        request,
        answer,
    )  # 501: a transfer coding that HTTP does not require
    assert b"x-content-type-options: nosniff" in head.lower(), (request, answer)
    if status >= 400 and not request.startswith(b"HEAD "):
        assert b"content-type: application/problem+json" in head.lower(), (request, answer)
        if b"transfer-encoding" not in head.lower() and b"content-encoding" not in head.lower():
            length = int(head.lower().partition(b"content-length: ")[2].partition(b"\r\n")[0])
            assert json.loads(body[:length])["status"] == status


@pytest.fixture
def warm_service(service: Any, client: httpx.Client) -> Any:
    """The service, once it has read what the first request of each kind reads: who ends its half is not waited for long."""
    for path in ("/", "/openapi.json", "/api/v1/records"):
        client.get(path).raise_for_status()
    return service


@settings(
    max_examples=REQUESTS,
    deadline=None,
    derandomize=True,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
@given(request=STRUCTURED | BROKEN | st.binary(min_size=1, max_size=80))
def test_any_bytes_are_answered(warm_service: Any, request: bytes) -> None:
    request = request.replace(b"Host: localhost", b"Host: " + host_of(warm_service.url))
    judge(request, ask(warm_service.url, request))
