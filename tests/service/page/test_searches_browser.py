"""Searches from the page: around the best design until it is known, and over base amplitudes; the numbers are the service's."""

import re
from collections.abc import Callable
from typing import Any

import httpx
import pytest
from playwright.sync_api import expect
from tests.service.page.looking import serious

pytestmark = pytest.mark.night


@pytest.fixture(scope="module")
def frictions(service: Any, helpers: Any) -> dict[str, Any]:
    """A study of friction alone over a band; its best friction lies inside."""
    axes = {
        "friction_ratio": {"start": 0.3, "stop": 0.8, "num": 11},
        "frequency_ratio": {"start": 0.9, "stop": 1.1, "num": 5},
    }
    study = {"name": "frictions", "particle": False, "damping_ratio": 0.021, "axes": axes}
    found: dict[str, Any] = helpers.computed(service, study)
    return found


def test_a_search_goes_on_until_the_best_is_known(
    open_page: Callable[..., Any], client: httpx.Client, frictions: dict[str, Any]
) -> None:
    page = open_page().go(f"#/studies/{frictions['id']}")
    page.get_by_text("Refine: is a better design nearby?").click()
    button = page.get_by_role("button", name="Search around the best design")
    button.focus()
    page.keyboard.press("Enter")
    panel = page.locator("details", has=button)
    expect(panel).to_contain_text("Known: ")
    expect(button).to_be_enabled()
    told = re.search(r"Known: ([\d.]+).* at γF = ([\d.]+)", panel.inner_text().replace("\n", ""))
    assert told
    # asked again with everything that was computed, the service says the same and has nothing more to compute
    follow_ups = [
        one["id"]
        for one in client.get("/api/v1/studies", params={"name": "frictions, refined"}).json()["studies"]
    ]
    assert follow_ups
    asked = {"with": ",".join(reversed(follow_ups)), "objective": "peak"}
    answer = client.post(f"/api/v1/studies/{frictions['id']}/refine", params=asked, json={}).json()
    assert answer["known"]
    assert float(told[1]) == pytest.approx(answer["found"]["value"], rel=1e-4)
    assert float(told[2]) == pytest.approx(answer["found"]["friction_ratio"], rel=1e-4)
    assert serious(page, ("light",)) == []


def test_robust_designs_are_those_of_the_service(
    open_page: Callable[..., Any], client: httpx.Client, frictions: dict[str, Any]
) -> None:
    watched = open_page(viewport={"width": 390, "height": 900})
    watched.allowed = ("422 (Unprocessable",)
    page = watched.go(f"#/studies/{frictions['id']}")
    page.get_by_text("Robust: what if").click()
    page.get_by_label("From … times").fill("0.8")
    page.get_by_label("to … times").fill("1.25")
    page.get_by_role("button", name="Judge the worst case").click()
    rows = page.get_by_role("region", name="Robust designs").locator("tbody tr")
    asked = {"amplitudes": "0.8,1.25", "top": 5, "objective": "peak"}
    answer = (
        client.get(f"/api/v1/studies/{frictions['id']}/robust-designs", params=asked)
        .raise_for_status()
        .json()
    )
    expect(rows).to_have_count(len(answer["designs"]))
    for row, design in zip(rows.all(), answer["designs"], strict=True):
        cells = [cell.inner_text() for cell in row.locator("td").all()]
        assert float(cells[0].split(" ")[0]) == pytest.approx(design["value"], rel=1e-4)
        assert float(cells[1]) == pytest.approx(design["nominal"], rel=1e-4)
        assert float(cells[3]) == pytest.approx(design["friction_ratio"], rel=1e-4)
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
    # the whole range leaves the grid: said, and what to do
    page.get_by_label("From … times").fill("0.01")
    page.get_by_label("to … times").fill("100")
    page.get_by_role("button", name="Judge the worst case").click()
    expect(page.get_by_role("alert")).to_contain_text("leaves the study's grid")
