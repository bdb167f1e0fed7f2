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
