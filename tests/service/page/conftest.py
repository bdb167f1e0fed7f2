"""A real browser: the system's Chromium, driven from here, held to the service's own host and to a silent console."""

import os
import shutil
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any

import pytest
from playwright.sync_api import (
    Browser,
    BrowserContext,
    ConsoleMessage,
    Page,
    Request,
    expect,
    sync_playwright,
)
from tests.service.conftest import computed

FLAGS = (
    "--headless=new",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-background-networking",
    "--no-first-run",
)
PATIENCE_MILLISECONDS = 600_000

MAP: dict[str, Any] = {
    "name": "small map",
    "axes": {
        "clearance_ratio": [5, 10, 15],
        "friction_ratio": [0.2, 0.4, 0.9],
        "frequency_ratio": {"start": 0.9, "stop": 1.1, "num": 5},
    },
    "steady": {"max_cycles": 300, "tolerance": 0.01},
}
"""Both dampers over a band, friction that locks included: 45 points."""


# Not of the session: playwright keeps an event loop running in this thread, beside which asyncio.run() refuses to work.
@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    path = shutil.which("chromium") or shutil.which("chromium-browser")
    if path is None:
        how = "there is no Chromium: apt-get install chromium"
        if os.environ.get("CI") == "true":
            pytest.fail(how)
        pytest.skip(how)
    with sync_playwright() as playwright:
        expect.set_options(timeout=PATIENCE_MILLISECONDS)
        browser = playwright.chromium.launch(executable_path=path, args=list(FLAGS))
        yield browser
        browser.close()


@dataclass
class Watched:
    """A page and what must not happen on it."""

    page: Page
    root: str
    troubles: list[str] = field(default_factory=list)
    requests: list[Request] = field(default_factory=list)
    allowed: tuple[str, ...] = ()
    """What a console message may hold: a refusal that a test asks for is one."""

    def go(self, fragment: str = "") -> Page:
        """Open a view, as from an address that somebody sent."""
        address = f"{self.root}/{fragment}"
        if self.page.url.startswith(self.root):
            # as a link of last week, which loads the page; a new fragment alone does not
            self.page.evaluate("(address) => history.pushState(null, '', address)", address)
            self.page.reload()
        else:
            self.page.goto(address)
        self.page.wait_for_selector("h1")
        return self.page

    def note(self, message: ConsoleMessage) -> None:
        if message.type in ("error", "warning"):
            self.troubles.append(f"{message.type}: {message.text} {message.location}")

    def check(self) -> None:
        strangers = [r.url for r in self.requests if not r.url.startswith((self.root, "blob:", "data:"))]
        assert strangers == []
        assert [one for one in self.troubles if not any(part in one for part in self.allowed)] == []


USUAL: dict[str, Any] = {"viewport": {"width": 1440, "height": 900}}


@pytest.fixture(scope="module")
def usual(browser: Browser) -> BrowserContext:
    """What keeps modules and libraries from one page to the next."""
    return browser.new_context(**USUAL)


@pytest.fixture
def open_page(
    browser: Browser, usual: BrowserContext, service: Any, own_service: Callable[..., Any]
) -> Iterator[Callable[..., Watched]]:
    """Open pages; at the end none may have had an error, a warning, or a request to anywhere else.

    A page with options has a browser's memory of its own, all others share one, without what pages keep. A service of the
    test's own is there for longer, so that a page that still asks it something is answered.
    """
    opened: list[Watched] = []

    def start(root: str = service.url, **options: Any) -> Watched:
        context = browser.new_context(**USUAL | options) if options else usual
        context.set_default_timeout(PATIENCE_MILLISECONDS)
        page = context.new_page()
        watched = Watched(page, root)
        page.on("console", watched.note)
        page.on("pageerror", lambda error: watched.troubles.append(f"exception: {error}"))
        page.on("request", lambda request: watched.requests.append(request))
        opened.append(watched)
        return watched

    yield start
    for watched in opened:
        if watched.page.context is usual:
            watched.page.evaluate("localStorage.clear()")
            watched.page.close()
        else:
            watched.page.context.close()
    usual.clear_cookies()
    for watched in opened:
        watched.check()


@pytest.fixture(scope="session")
def small_map(service: Any) -> dict[str, Any]:
    """The record of a finished study with a map."""
    finished: dict[str, Any] = computed(service, MAP)
    return finished
