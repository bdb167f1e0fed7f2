"""Signing in on the page, where the service asks for a key."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from playwright.sync_api import expect
from tests.service.security.conftest import make_key


def test_a_key_opens_the_page_and_signing_out_closes_it(
    open_page: Callable[..., Any], own_service: Callable[..., Any], tmp_path: Path
) -> None:
    key = make_key(tmp_path / "data", "ann", "submit")["key"]
    running = own_service(DAMPERLAB_ACCESS="keys")
    watched = open_page(running.url)
    watched.allowed = ("401",)
    page = watched.go()
    expect(page.get_by_role("heading", name="Sign in")).to_be_visible()
    page.get_by_label("Key").fill("dlk_nonsense")
    page.get_by_role("button", name="Sign in").click()
    expect(page.get_by_role("alert")).to_contain_text("not a key of this service")
    page.get_by_label("Key").fill(key)
    page.get_by_role("button", name="Sign in").click()
    expect(page.get_by_role("heading", name="Studies", exact=True)).to_be_visible()
    expect(page.get_by_role("button", name="Sign out")).to_be_visible()
    assert page.evaluate("document.cookie") == ""
    page.get_by_role("button", name="Sign out").click()
    expect(page.get_by_role("heading", name="Sign in")).to_be_visible()
