"""The page leads to its documentation, which the service sends under a policy of its own; without it there is no link."""

import os
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import httpx
import pytest
from playwright.sync_api import expect
from tests.service.page.looking import serious
from tests.service.security.conftest import make_key

ROOT = Path(__file__).parents[3]


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The site, built."""
    folder = tmp_path_factory.mktemp("documentation") / "site"
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet", "--site-dir", str(folder)]
    environment = os.environ | {"NO_MKDOCS_2_WARNING": "1"}
    subprocess.run(command, cwd=ROOT, env=environment, check=True, timeout=900)
    return folder


def helped() -> set[str]:
    """Every page to which the page's modules lead."""
    modules = "".join(file.read_text() for file in (ROOT / "service/page").glob("*.js"))
    return set(re.findall(r'\bhelp\("([^"]+)"', modules))


@pytest.mark.night
def test_the_page_leads_to_its_documentation_which_works_under_its_policy(
    own_service: Callable[..., Any], open_page: Callable[..., Any], site: Path
) -> None:
    running = own_service(DAMPERLAB_DOCS_DIR=str(site))
    watched = open_page(running.url)
    page = watched.go("#/new")
    expect(page.get_by_role("link", name="Documentation", exact=True)).to_have_attribute("href", "docs/")
    links = page.locator("a.help")
    expect(links.first).to_be_visible()
    assert serious(page, ("light",)) == []
    with page.expect_popup() as opened:
        links.first.click()
    documentation = opened.value
    said: list[str] = []
    documentation.on("console", watched.note)
    documentation.on("pageerror", lambda error: said.append(str(error)))
    expect(documentation.locator("h1")).to_be_visible()
    assert len(helped()) >= 8
    for address in (*sorted(helped()), "tutorial/"):  # again: from the browser's store
        documentation.goto(f"{running.url}/docs/{address}")
        heading = address.partition("#")[2]
        expect(documentation.locator(f'[id="{heading}"]' if heading else "h1")).to_be_visible()
    documentation.get_by_role("textbox", name="Search").press_sequentially(
        "restitution"
    )  # it listens to keys
    expect(documentation.locator(".md-search-result__item").first).to_be_visible()
    assert said == []


@pytest.mark.night
def test_files_of_the_site_are_sent_with_what_each_may_do(
    own_service: Callable[..., Any], site: Path, tmp_path: Path
) -> None:
    make_key(tmp_path / "data", "ann", "submit")
    running = own_service(DAMPERLAB_DOCS_DIR=str(site), DAMPERLAB_ACCESS="keys")
    with httpx.Client(base_url=running.url, timeout=300) as client:
        page = client.get("/docs/")
        policy = page.headers["content-security-policy"]
        assert "'sha256-" in policy
        assert "script-src 'self' 'unsafe-inline'" not in policy
        assert page.headers["x-content-type-options"] == "nosniff"
        assert client.get("/docs/site.css").status_code == 200
        again = client.get("/docs/", headers={"if-none-match": page.headers["etag"]})
        assert (again.status_code, again.content) == (304, b"")
        # a browser takes the headers of this answer for the page that it has kept
        assert again.headers["content-security-policy"] == policy
        for outside in (
            "/docs/..%2fsettings.py",
            "/docs/%2e%2e/%2e%2e/etc/passwd",
            "/docs/none",
        ):
            assert client.get(outside).status_code == 404, outside


@pytest.mark.night
def test_without_the_site_there_is_no_link(
    own_service: Callable[..., Any], open_page: Callable[..., Any]
) -> None:
    running = own_service(DAMPERLAB_DOCS_DIR="none")
    page = open_page(running.url).go("#/new")
    expect(page.get_by_role("heading", name="New study")).to_be_visible()
    assert page.locator("a.help").count() == 0
    assert page.get_by_role("link", name="Documentation").count() == 0
    assert httpx.get(f"{running.url}/docs/", timeout=300).status_code == 404


def test_a_folder_that_holds_no_site_is_refused(tmp_path: Path) -> None:
    from damperlab.service.settings import Settings

    with pytest.raises(ValueError, match=r"index\.html"):
        Settings(docs_dir=tmp_path)
