"""What the browser is sent before it runs anything: policy, caching, packing, and modules that parse."""

import gzip
import os
import re
import shutil
import subprocess
from pathlib import Path
from typing import Any

import httpx
import pytest

from damperlab.service.page.files import PLOTLY, page_file, page_names, page_version
from damperlab.studies.reading import named_studies

FOLDER = Path(__file__).parents[3] / "service" / "page"
FIRST_VIEW_BYTES = 1_500_000
WIDEST = 110


def test_the_page_allows_itself_nothing_from_elsewhere(client: httpx.Client) -> None:
    answer = client.get("/")
    assert answer.headers["content-type"] == "text/html; charset=utf-8"
    policy = answer.headers["content-security-policy"]
    assert "default-src 'none'; script-src 'self';" in policy
    assert "unsafe-inline" not in policy.replace("style-src-attr 'unsafe-inline'", "")
    assert "unsafe-eval" not in policy
    assert not re.search(r"https?://|<script>| on\w+=| style=|<style", answer.text)


def test_every_file_that_the_page_names_is_there_and_kept_for_good(client: httpx.Client) -> None:
    names = re.findall(r'(?:href|src)="(page/[^"]+)"', client.get("/").text)
    assert len(set(names)) >= 15
    for name in set(names):
        answer = client.get("/" + name)
        assert answer.status_code == 200, name
        assert "immutable" in answer.headers["cache-control"]
        assert answer.headers["x-content-type-options"] == "nosniff"
        again = client.get("/" + name, headers={"if-none-match": answer.headers["etag"]})
        assert (again.status_code, again.content) == (304, b"")


def test_the_page_itself_and_files_of_another_version_are_asked_for_anew(client: httpx.Client) -> None:
    first = client.get("/")
    assert first.headers["cache-control"] == "no-cache"
    assert client.get("/", headers={"if-none-match": first.headers["etag"]}).status_code == 304
    old = client.get("/page/000000000000/main.js")
    assert (old.status_code, old.headers["cache-control"]) == (200, "no-cache")


@pytest.mark.parametrize("name", ["files.py", "__init__.py", "..%2fapp.py", "none.js", "index.htm"])
def test_nothing_else_of_the_package_is_served(client: httpx.Client, name: str) -> None:
    assert client.get(f"/page/{page_version()}/{name}").status_code == 404


def test_files_are_packed_for_who_takes_that_and_plain_for_who_does_not(service: Any) -> None:
    for name in ("main.js", PLOTLY):
        address = f"{service.url}/page/{page_version()}/{name}"
        plain = httpx.get(address, headers={"accept-encoding": "identity"}, timeout=300)
        assert "content-encoding" not in plain.headers
        with httpx.stream("GET", address, headers={"accept-encoding": "gzip"}, timeout=300) as packed:
            sent = b"".join(packed.iter_raw())
            assert packed.headers["content-encoding"] == "gzip"
        assert gzip.decompress(sent) == plain.content
        assert len(sent) < 0.5 * len(plain.content)


def test_the_first_view_is_small(client: httpx.Client) -> None:
    files = [file.packed for name in page_names() if (file := page_file(name))]
    assert sum(map(len, files)) < FIRST_VIEW_BYTES / 10


@pytest.mark.skipif(
    shutil.which("node") is None, reason="node is not here; the browser's tests run the modules"
)
def test_modules_parse_without_their_comments_and_do_what_needs_no_browser(tmp_path: Path) -> None:
    modules = [tmp_path / name for name in page_names() if name.endswith(".js")]
    for path in modules:
        served = page_file(path.name)
        assert served is not None
        assert b"@param" not in served.content
        path.write_bytes(served.content)
    (tmp_path / "package.json").write_text('{"type": "module"}')
    read = (
        "const fs = require('fs'), vm = require('vm'); "
        "for (const path of process.argv.slice(1)) "
        "new vm.SourceTextModule(fs.readFileSync(path, 'utf8'), {identifier: path})"
    )
    parsing = ["--experimental-vm-modules", "--no-warnings", "-e", read, *modules]
    for asked in (parsing, ["--test", Path(__file__).with_name("pure.test.mjs")]):
        environment = os.environ | {"PAGE": str(tmp_path)}
        checked = subprocess.run(["node", *asked], env=environment, capture_output=True, timeout=120)
        assert checked.returncode == 0, (checked.stdout + checked.stderr).decode()


def test_catalog_holds_every_named_study(client: httpx.Client) -> None:
    catalog = client.get("/api/v1/catalog").raise_for_status().json()
    assert {study["name"] for study in catalog["studies"]} == set(named_studies())
    assert all(study["about"][0] for study in catalog["studies"])
    (clearance,) = (one for one in catalog["dimensions"] if one["name"] == "clearance_ratio")
    assert (clearance["lowest"], clearance["highest"], clearance["default"]) == (1e-12, 1e12, None)


def test_axes_are_those_of_the_grid(client: httpx.Client, curve: dict[str, Any]) -> None:
    answer = client.get(f"/api/v1/studies/{curve['id']}/axes").raise_for_status().json()
    assert answer["axes"]["frequency_ratio"] == [0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1, 1.2, 1.3, 1.4, 1.5]
    assert answer["axes"]["damping_ratio"] == [0.0038]
    assert {"amplitude_ratio", "status"} <= set(answer["variables"])


def test_no_line_is_wider_than_a_reader_takes_in() -> None:
    written = [path for path in FOLDER.iterdir() if path.suffix in (".js", ".ts", ".css", ".html")]
    wide = [
        f"{path.name}:{number}"
        for path in written
        for number, line in enumerate(path.read_text().splitlines(), 1)
        if len(line) > WIDEST
    ]
    assert wide == []
