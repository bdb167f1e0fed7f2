"""Keys, scopes and origins of every route that there is: a new one cannot be forgotten."""

import re
from typing import Any

import httpx
import pytest
from tests.service.security.conftest import Guarded
from tests.service.security.raw import host_of, send_raw

from damperlab.service.app import create_app
from damperlab.service.settings import Settings

PUBLIC = {"/health/live", "/health/ready", "/api/v1/session"}
"""What needs no key; a route that is to join them is written here too."""
UNSAFE = ("POST", "PUT", "PATCH", "DELETE")
THERE = {"record_id": "northridge", "key": "zarr.json"}
"""What stands for a parameter of a path; for any other an id of nothing."""

OPERATIONS = [
    (method.upper(), re.sub(r"{(\w+)}", lambda found: THERE.get(found[1], "0" * 12), path), path)
    for path, operations in create_app(Settings()).openapi()["paths"].items()
    for method in operations
]
GUARDED = [(method, address) for method, address, path in OPERATIONS if path not in PUBLIC]
CHANGING = [(method, address) for method, address, _ in OPERATIONS if method in UNSAFE]


def _kind(answer: httpx.Response) -> tuple[int, str]:
    return answer.status_code, answer.json()["type"].removeprefix("urn:damperlab:problem:")


def test_no_route_is_hidden_from_the_document() -> None:
    """The tables below are made from the OpenAPI document; what it leaves out is the page and its files."""
    documented = {path for _, _, path in OPERATIONS}

    def paths(routes: Any) -> set[str]:
        found: set[str] = set()
        for route in routes:
            inner = getattr(getattr(route, "original_router", None), "routes", None)
            if inner is not None:
                found |= paths(inner)
            elif getattr(route, "path", None) is not None:
                found.add(route.path.replace(":path}", "}"))
        return found

    hidden = paths(create_app(Settings(docs_dir=None)).routes) - documented
    assert hidden == {"/", "/openapi.json", "/page/{version}/{name}"}


@pytest.mark.parametrize(("method", "path"), GUARDED)
def test_a_route_asks_for_a_key_of_the_right_scope(guarded: Guarded, method: str, path: str) -> None:
    with guarded.client(None) as nobody, guarded.client("reader") as reader:
        assert _kind(nobody.request(method, path)) == (401, "no-key")
        if method in UNSAFE:
            assert _kind(reader.request(method, path)) == (403, "scope-lacking")
        elif not path.endswith("/events"):
            assert reader.request(method, path).status_code not in (401, 403)


@pytest.mark.parametrize(("method", "path"), CHANGING)
def test_a_route_that_changes_something_is_closed_to_other_sites(
    guarded: Guarded, method: str, path: str
) -> None:
    with guarded.client("admin") as admin:
        for elsewhere in (
            {"Origin": "http://evil.example"},
            {"Sec-Fetch-Site": "cross-site"},
            {"Origin": "null"},
        ):
            answer = admin.request(method, path, headers=elsewhere, content=b"{}")
            assert _kind(answer) == (403, "cross-site"), elsewhere
        foreign = admin.request(method, path, headers={"Host": "evil.example"})
        assert _kind(foreign) == (421, "foreign-host")


@pytest.mark.parametrize("method", ["TRACE", "CONNECT", "PROPFIND", "OPTIONS", "PUT", "PATCH"])
def test_methods_that_there_are_none_of_do_nothing(guarded: Guarded, method: str) -> None:
    """TRACE would hand back a cookie that no script may read."""
    for _, path, _ in OPERATIONS:
        head = f"{method} {path} HTTP/1.1\r\nHost: {host_of(guarded.url).decode()}\r\nConnection: close\r\n"
        answer = send_raw(
            guarded.url, f"{head}Cookie: damperlab_session=secret\r\nX-Odd: echo\r\n\r\n".encode()
        )
        assert answer is not None
        assert answer.status in (401, 403, 404, 405), path
        assert b"secret" not in answer.body + answer.head.encode()
        assert b"echo" not in answer.body
