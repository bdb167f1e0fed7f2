"""What a page of another site makes a browser send, and names that somebody else made point here."""

from typing import Any

import httpx
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.service.security.raw import send_raw

from damperlab.service.security.hosts import Hosts, host_name, is_loopback

EVIL = {"Origin": "http://evil.example"}
STUDY = {"name": "cross", "particle": False, "axes": {"frequency_ratio": [0.5, 0.75, 1.75]}}


@pytest.mark.parametrize(
    "headers",
    [
        EVIL,
        {"Origin": "null"},
        {"Origin": "http://127.0.0.1:1"},
        {"Origin": "evil"},
        {"Origin": "http://[["},
        {"Sec-Fetch-Site": "cross-site"},
        {"Sec-Fetch-Site": "same-site"},
        {"Sec-Fetch-Site": "odd"},
        EVIL | {"Sec-Fetch-Site": "same-origin"},
    ],
)
def test_a_change_from_elsewhere_is_refused(
    client: httpx.Client, curve: dict[str, Any], headers: dict[str, str]
) -> None:
    """As a form may be sent, and on a study; every route is asked in `test_every_route`."""
    url = f"/api/v1/studies/{curve['id']}"
    form = {"content": "x", "headers": {"Content-Type": "text/plain"} | headers}
    for answer in (
        client.post("/api/v1/records", **form),  # type: ignore[arg-type]
        client.post("/api/v1/studies", json=STUDY, headers=headers),
        client.delete(url, headers=headers),
    ):
        assert answer.status_code == 403, answer.text
        assert answer.json()["type"] == "urn:damperlab:problem:cross-site"
    assert client.get(url).status_code == 200
    assert not client.get("/api/v1/studies", params={"name": "cross"}).json()["studies"]


def test_the_services_own_page_may_change_things(client: httpx.Client, service: Any) -> None:
    own = {"Origin": service.url, "Sec-Fetch-Site": "same-origin"}
    point = {"frequency_ratio": 1.0, "particle": False, "friction_ratio": 0}
    assert client.post("/api/v1/simulate?dry_run=true", json=point, headers=own).status_code == 200
    # a body that any page may send without being asked is refused from a browser, whatever it says of its origin
    for kind in ("text/plain", "application/x-www-form-urlencoded", "multipart/form-data; boundary=x"):
        answer = client.post("/api/v1/records", content="x", headers=own | {"Content-Type": kind})
        assert answer.status_code == 415


@pytest.mark.parametrize(
    "host", ["evil.example", "evil.example:8000", "127.0.0.1.evil.example", "10.1.2.3", "", "["]
)
def test_a_name_that_is_not_the_services_is_refused(service: Any, host: str) -> None:
    for method in ("GET", "POST", "DELETE"):
        request = f"{method} /api/v1/studies HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n"
        answer = send_raw(service.url, request.encode())
        assert answer.status in (400, 421)
        assert "application/problem+json" in answer.head
        assert b'studies":' not in answer.body


def test_every_answer_says_what_a_browser_may_do_with_it(client: httpx.Client, curve: dict[str, Any]) -> None:
    for path in (
        "/",
        "/health/live",
        "/nothing",
        "/openapi.json",
        "/metrics",
        f"/api/v1/studies/{curve['id']}",
    ):
        headers = client.get(path).headers
        assert headers["x-content-type-options"] == "nosniff", path
        assert "frame-ancestors 'none'" in headers["content-security-policy"], path
        assert headers["cross-origin-resource-policy"] == "same-origin", path
        assert "access-control-allow-origin" not in headers, path


def test_names_of_this_machine_and_those_that_were_added_are_right_and_beyond_loopback_digits_too() -> None:
    anywhere = Hosts("0.0.0.0")
    assert anywhere.allows("10.1.2.3:8000")
    assert anywhere.allows("[2001:db8::1]")
    assert not anywhere.allows("evil.example")
    assert Hosts("damper.example").allows("damper.example")
    here = Hosts("127.0.0.1", ["damper.example", ".lab.example"])
    right = ("localhost", "LOCALHOST.", "[::1]:1", "127.9.9.9", "damper.example", "a.lab.example:80")
    assert all(map(here.allows, right))
    assert not any(map(here.allows, ("lab.example", "xlab.example", "10.1.2.3")))
    assert is_loopback("127.0.0.1")
    assert is_loopback("::1")
    assert is_loopback("localhost")
    assert not is_loopback("0.0.0.0")
    assert not is_loopback("::")


@given(st.text(max_size=40))
def test_any_text_as_a_host_is_judged(text: str) -> None:
    name = host_name(text)
    if Hosts("127.0.0.1").allows(text):
        assert name is not None
        assert name == "localhost" or is_loopback(name)
