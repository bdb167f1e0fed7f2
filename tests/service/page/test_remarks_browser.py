"""Tags and notes on the page, and the list of studies cut down by them and by what studies vary."""

from collections.abc import Callable
from typing import Any

import httpx
import pytest
from playwright.sync_api import expect
from tests.service.page.looking import serious

pytestmark = pytest.mark.night

COMMON = {"particle": False, "steady": {"max_cycles": 40}}


@pytest.mark.parametrize("width", [390, 1440])
def test_a_tag_is_written_and_leads_to_its_studies(
    open_page: Callable[..., Any], own_service: Callable[..., Any], helpers: Any, width: int
) -> None:
    running = own_service()
    with httpx.Client(base_url=running.url, timeout=300) as client:
        for name, frictions in (("low", [0.1, 0.2]), ("high", [0.5, 0.6])):
            axes = {"friction_ratio": frictions, "frequency_ratio": [0.9, 1.1]}
            study = {"name": name, "damping_ratio": 0.02, "axes": axes} | COMMON
            record = client.post("/api/v1/studies", json=study).raise_for_status().json()
            helpers.wait_for(client, record["id"], helpers.ended)
    watched = open_page(running.url, viewport={"width": width, "height": 900})
    page = watched.go(f"#/studies/{record['id']}/data")
    page.get_by_label("Tags, with commas").fill("Rig 2")
    page.get_by_role("button", name="Save tags and note").click()
    expect(page.get_by_role("alert")).to_contain_text("lower-case letters")
    page.get_by_label("Tags, with commas").fill("steel, rig-2")
    page.get_by_label("Note", exact=True).fill("measured\ntwice")
    page.keyboard.press("Tab")
    page.keyboard.press("Enter")
    expect(page.get_by_text("Saved.", exact=True)).to_be_visible()
    page = watched.go(f"#/studies/{record['id']}/data")
    expect(page.get_by_label("Tags, with commas")).to_have_value("rig-2, steel")
    expect(page.get_by_label("Note", exact=True)).to_have_value("measured\ntwice")
    assert serious(page) == []

    page = watched.go("")
    cards = page.locator(".card")
    expect(cards).to_have_count(2)
    page.get_by_role("button", name="Studies with the tag rig-2").click()
    expect(cards).to_have_count(1)
    expect(cards).to_contain_text("high")
    expect(page.get_by_label("Tag", exact=True)).to_have_value("rig-2")
    page.reload()  # as from a link that somebody sent
    expect(cards).to_have_count(1)
    expect(page.get_by_label("Tag", exact=True)).to_have_value("rig-2")
    page.get_by_label("Tag", exact=True).fill("Rig")
    expect(page.get_by_text("No study has such a tag")).to_be_visible()
    assert serious(page) == []
    page.get_by_label("Tag", exact=True).fill("")
    expect(cards).to_have_count(2)
    page.get_by_label("Values of").select_option("friction_ratio")
    page.get_by_label("from", exact=True).fill("0.15")
    page.get_by_label("to", exact=True).fill("0.3")
    expect(cards).to_have_count(1)
    expect(cards).to_contain_text("low")
    page.get_by_label("from", exact=True).fill("0.35")
    expect(page.get_by_text("The range holds nothing")).to_be_visible()
    page.get_by_label("from", exact=True).fill("0.25")
    expect(page.get_by_text("No study matches the search.")).to_be_visible()
    with page.expect_response(lambda response: "axis=clearance_m" in response.url) as answered:
        page.get_by_label("Values of").select_option("clearance_m")
    assert answered.value.json()["studies"] == []
    expect(page.get_by_text("No study matches the search.")).to_be_visible()
    assert page.evaluate("document.documentElement.scrollWidth") <= width
