"""HEAD, ETag and Range: what a client has is not sent again, and what it lacks may be asked for in parts."""

from typing import Any

import anyio
import httpx
import pytest
from tests.service.security.conftest import Guarded

from damperlab.service.edge.head import ShortHead

STUDIES = "/api/v1/studies"


def test_head_is_get_without_the_body(client: httpx.Client, curve: dict[str, Any]) -> None:
    url = f"{STUDIES}/{curve['id']}"
    for path in (
        "/",
        "/health/live",
        "/openapi.json",
        "/metrics",
        STUDIES,
        url,
        f"{url}/frequency-response",
        f"{url}/events",
        f"{url}/export?format=csv",
        f"{url}/zarr/zarr.json",
    ):
        head = client.head(path)
        assert (head.status_code, head.content) == (200, b""), path
        if path != "/metrics" and "events" not in path:
            got = client.get(path).headers
            for name in ("content-type", "etag"):
                assert head.headers.get(name) == got.get(name), (path, name)
    assert client.head("/api/v1/simulate").status_code == 405
    assert client.head(f"{STUDIES}/000000000000").status_code == 404


@pytest.mark.parametrize(
    "path",
    ["", "/frequency-response", "/export?format=netcdf", "/export?format=csv", "/export?format=parquet"],
)
def test_what_the_client_has_is_not_sent_again(
    client: httpx.Client, curve: dict[str, Any], path: str
) -> None:
    url = f"{STUDIES}/{curve['id']}{path}"
    first, second = (client.get(url, headers=sent) for sent in ({}, {"If-None-Match": '"other"'}))
    tag = first.headers["etag"]
    assert (second.content, second.headers["etag"]) == (first.content, tag)  # or it would stand for several
    again = client.get(url, headers={"If-None-Match": tag})
    assert (again.status_code, again.content, again.headers["etag"]) == (304, b"", tag)


def test_an_export_in_parts_is_the_whole(client: httpx.Client, curve: dict[str, Any]) -> None:
    """Every kind of part is asked of a block, in `test_zarr`."""
    url = f"{STUDIES}/{curve['id']}/export"
    whole = client.get(url)
    size, tag = len(whole.content), whole.headers["etag"]
    assert whole.headers["accept-ranges"] == "bytes"
    parts = b""
    for start, stop in ((0, size // 2), (size // 2, size)):
        part = client.get(url, headers={"Range": f"bytes={start}-{stop - 1}", "If-Range": tag})
        assert part.status_code == 206
        assert part.headers["content-range"] == f"bytes {start}-{stop - 1}/{size}"
        parts += part.content
    assert parts == whole.content
    assert client.get(url, headers={"Range": f"bytes={size}-"}).status_code == 416


def test_an_uploaded_record_can_be_removed_by_its_owner(guarded: Guarded) -> None:
    csv = "".join(f"{0.01 * i},{(-1) ** i}\n" for i in range(50))
    with guarded.client("ann") as ann, guarded.client("bob") as bob, guarded.client("reader") as reader:

        def upload() -> str:
            answer = ann.post("/api/v1/records?units=g", content=csv, headers={"Content-Type": "text/csv"})
            assert answer.status_code == 201, answer.text
            record_id: str = answer.json()["id"]
            return record_id

        record = upload()
        url = f"/api/v1/records/{record}"
        assert reader.delete(url).status_code == 403
        assert bob.delete(url).json()["type"] == "urn:damperlab:problem:not-yours"
        assert ann.delete(url).status_code == 204
        assert ann.delete(url).status_code == 404
        assert record not in {each["id"] for each in ann.get("/api/v1/records").json()["records"]}
        assert upload() == record
        with guarded.client("admin") as admin:
            assert admin.delete(url).status_code == 204
            built_in = admin.get("/api/v1/records").json()["records"][0]["id"]
            assert admin.delete(f"/api/v1/records/{built_in}").status_code == 409


def test_an_address_has_only_so_many_parameters(client: httpx.Client) -> None:
    names = "&".join(f"a{each}=1" for each in range(8000 // 4))
    refused = client.get(f"/health/live?{names}")
    assert (refused.status_code, refused.json()["errors"][0]["field"]) == (431, "query")


def test_no_cookie_is_read_but_the_session() -> None:
    """Reading a quoted one takes time as the square of its length (CVE-2024-7592)."""
    seen: list[list[bytes]] = []

    async def application(scope: Any, receive: Any, send: Any) -> None:
        seen.append([value for name, value in scope["headers"] if name == b"cookie"])

    session = b"damperlab_session=0a.1.2b"
    for cookies in (
        [b'a="' + b"\\" * 20_000 + b'"; ' + session],
        [b"x" + session, session + b"; b=2"],
        [session],
        [b"a=1"],
        [],
    ):
        headers = [(b"host", b"localhost"), *((b"cookie", each) for each in cookies)]
        scope = {"type": "http", "query_string": b"", "headers": headers}
        nothing: Any = None
        anyio.run(ShortHead(application), scope, nothing, nothing)
    assert seen == [[session]] * 3 + [[]] * 2
