"""Keys, scopes and origins of every route that there is: a new one cannot be forgotten."""

import re
from typing import NamedTuple

import httpx
import pytest
from tests.service.security.conftest import Guarded, every_route
from tests.service.security.raw import host_of, send_raw

from damperlab.service.app import create_app
from damperlab.service.settings import Settings

PUBLIC = {"/health/live", "/health/ready", "/api/v1/session"}
"""What needs no key; a route that is to join them is written here too."""
UNSAFE = ("POST", "PUT", "PATCH", "DELETE")
THERE = {"record_id": "northridge", "key": "zarr.json"}
"""What stands for a parameter of a path; for any other an id of nothing."""


class Operation(NamedTuple):
    """A method of a route."""

    method: str
    address: str
    path: str
    """As the OpenAPI document has it."""


@pytest.fixture(scope="module")
def operations() -> list[Operation]:
    """Every one of the OpenAPI document."""
    return [
        Operation(method.upper(), re.sub(r"{(\w+)}", lambda name: THERE.get(name[1], "0" * 12), path), path)
        for path, methods in create_app(Settings()).openapi()["paths"].items()
        for method in methods
    ]


def _kind(answer: httpx.Response) -> tuple[int, str]:
    return answer.status_code, answer.json()["type"].removeprefix("urn:damperlab:problem:")


def test_no_route_is_hidden_from_the_document(operations: list[Operation]) -> None:
    """The tests below ask what the OpenAPI document has; what it leaves out is the page and its files."""
    documented = {each.path for each in operations}
    routes = every_route(create_app(Settings(docs_dir=None)).routes)
    hidden = {route.path.replace(":path}", "}") for route in routes if hasattr(route, "path")} - documented
    assert hidden == {"/", "/openapi.json", "/page/{version}/{name}"}


def test_a_route_asks_for_a_key_of_the_right_scope(guarded: Guarded, operations: list[Operation]) -> None:
    with guarded.client(None) as nobody, guarded.client("reader") as reader:
        for each in operations:
            if each.path in PUBLIC:
                continue
            assert _kind(nobody.request(each.method, each.address)) == (401, "no-key"), each
            if each.method in UNSAFE:
                assert _kind(reader.request(each.method, each.address)) == (403, "scope-lacking"), each
            elif not each.path.endswith("/events"):
                assert reader.request(each.method, each.address).status_code not in (401, 403), each


def test_a_route_that_changes_something_is_closed_to_other_sites(
    guarded: Guarded, operations: list[Operation]
) -> None:
    """Every kind of elsewhere is tried in `test_pages_elsewhere`."""
    with guarded.client("admin") as admin:
        for each in operations:
            if each.method not in UNSAFE:
                continue
            elsewhere = {"Origin": "http://evil.example"}
            answer = admin.request(each.method, each.address, headers=elsewhere, content=b"{}")
            assert _kind(answer) == (403, "cross-site"), each
            foreign = admin.request(each.method, each.address, headers={"Host": "evil.example"})
            assert _kind(foreign) == (421, "foreign-host"), each


@pytest.mark.parametrize("method", ["TRACE", "CONNECT", "PROPFIND", "OPTIONS", "PUT", "PATCH"])
def test_methods_that_there_are_none_of_do_nothing(
    guarded: Guarded, operations: list[Operation], method: str
) -> None:
    """TRACE would hand back a cookie that no script may read."""
    for each in operations:
        head = (
            f"{method} {each.path} HTTP/1.1\r\nHost: {host_of(guarded.url).decode()}\r\nConnection: close\r\n"
        )
        answer = send_raw(
            guarded.url, f"{head}Cookie: damperlab_session=secret\r\nX-Odd: echo\r\n\r\n".encode()
        )
        assert answer.status in (401, 403, 404, 405), each
        assert b"secret" not in answer.body + answer.head.encode()
        assert b"echo" not in answer.body
