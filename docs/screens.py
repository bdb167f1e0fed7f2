"""Pictures of the web page, taken in Chromium from a running service: `python -m docs.screens`."""

import re
import shutil
from pathlib import Path

from docs.console import ROOT, TITLED
from docs.running import service
from playwright.sync_api import Browser, Page, sync_playwright

from damperlab import Client

FIGURES = Path(__file__).parent / "figures"
FLAGS = ["--headless=new", "--no-sandbox", "--disable-gpu"]
DRAWN = ".main-svg"
"""What a plot holds once it has drawn."""
PATIENCE_MILLISECONDS = 90_000
SETTLED_MILLISECONDS = 1500
"""For what moves to come to rest."""


def take(browser: Browser, url: str, study: str) -> None:
    """Take every picture of the tour.

    Parameters
    ----------
    browser : Browser
        Chromium.
    url, study : str
        Of the service, and the id of a finished study with a map.
    """
    page = browser.new_page(viewport={"width": 1280, "height": 1000})
    for name, place in (
        ("studies", ""),
        ("new", "#/new"),
        ("design", "#/designs/new?specification=prototype"),
        ("tmd", f"#/studies/{study}/tmd"),
    ):
        _go(page, f"{url}/{place}", drawn=name == "tmd")
        page.screenshot(path=FIGURES / f"page-{name}.png")
    _go(page, f"{url}/#/studies/{study}", drawn=True)
    page.get_by_role("button", name="Look at the best design").click()
    page.get_by_role("heading", name=re.compile("^Motion")).wait_for(timeout=PATIENCE_MILLISECONDS)
    page.wait_for_timeout(SETTLED_MILLISECONDS)
    page.screenshot(path=FIGURES / "page-map.png")
    page.get_by_role("heading", name="Designs", exact=True).evaluate("heading => heading.scrollIntoView()")
    page.screenshot(path=FIGURES / "page-designs.png")
    _go(page, f"{url}/#/studies/{study}/explore", drawn=True)
    _pin_two(page)
    page.screenshot(path=FIGURES / "page-explore.png", full_page=True)
    small = browser.new_page(viewport={"width": 390, "height": 844})
    _go(small, f"{url}/#/studies/{study}", drawn=True)
    small.screenshot(path=FIGURES / "page-small.png")


def _pin_two(page: Page) -> None:
    """Pin the best design and the one beside it, so that their curves are drawn together."""
    pin = page.get_by_role("button", name="Pin this point")
    pin.click()
    page.get_by_role("slider").first.press("ArrowRight")
    page.wait_for_timeout(SETTLED_MILLISECONDS)
    pin.click()
    page.locator("section", has=page.get_by_role("heading", name="Pinned points")).locator(
        DRAWN
    ).first.wait_for()
    page.wait_for_timeout(SETTLED_MILLISECONDS)
    page.evaluate("window.scrollTo(0, 0)")


def _go(page: Page, address: str, drawn: bool = False) -> None:
    page.goto(address)
    page.reload()
    page.wait_for_selector("h1")
    if drawn:
        page.wait_for_selector(f".plot {DRAWN}", timeout=PATIENCE_MILLISECONDS)
    page.wait_for_timeout(SETTLED_MILLISECONDS)


def main() -> None:
    """Compute the tutorial's study in a service, and take the pictures."""
    path = shutil.which("chromium") or shutil.which("chromium-browser")
    found = TITLED.search((ROOT / "docs" / "tutorial.md").read_text())
    if path is None or found is None:
        raise SystemExit("Chromium is needed (apt-get install chromium), and the study of the tutorial.")
    with service() as url, Client(url) as client, sync_playwright() as playwright:
        study = client.submit(re.sub(r"\s+$", "\n", found[2])).wait(progress=False)
        browser = playwright.chromium.launch(executable_path=path, args=FLAGS)
        take(browser, url, study.id)
        browser.close()


if __name__ == "__main__":
    main()
