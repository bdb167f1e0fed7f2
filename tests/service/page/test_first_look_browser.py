"""What somebody sees who has never been here: a key to sign in with, an empty service, a form, a study that is not done."""

from collections.abc import Callable
from typing import Any

import httpx
import pytest
from playwright.sync_api import expect
from tests.service.conftest import computed, ended, long_study, wait_for

pytestmark = pytest.mark.night

FOCUSED = "document.activeElement.closest('label')?.querySelector('span')?.textContent"


def test_an_empty_service_leads_to_a_design_in_units(
    open_page: Callable[..., Any], own_service: Callable[..., Any]
) -> None:
    page = open_page(own_service().url).go()
    expect(page.get_by_role("heading", name="No studies yet")).to_be_visible()
    page.get_by_role("link", name="Specify a design").click()
    expect(page.get_by_role("heading", name="New design")).to_be_visible()


def test_the_keyboard_stays_at_a_field_that_changes_the_others(open_page: Callable[..., Any]) -> None:
    page = open_page().go("#/new?scene=figure-11")
    page.get_by_label("Sizes as").focus()
    page.keyboard.press("ArrowDown")
    expect(page.get_by_role("group", name="Clearance d [mm]")).to_be_visible()
    assert page.evaluate(FOCUSED) == "Sizes as"
    page.get_by_label("With a particle").focus()
    page.keyboard.press("Space")
    expect(page.get_by_role("group", name="Clearance d [mm]")).to_be_hidden()
    assert page.evaluate("document.activeElement.type") == "checkbox"


def test_the_best_of_a_study_that_is_not_done_is_so_far_the_best(
    open_page: Callable[..., Any], client: httpx.Client
) -> None:
    study = long_study("not done", damping_ratio=0.0047)
    study_id = client.post("/api/v1/studies", json=study).raise_for_status().json()["id"]
    wait_for(client, study_id, lambda record: record["points_done"] > 0)
    client.post(f"/api/v1/studies/{study_id}/cancel").raise_for_status()
    record = wait_for(client, study_id, ended)
    assert record["points_done"] < record["points_total"]
    watched = open_page()
    page = watched.go(f"#/studies/{study_id}")
    expect(page.locator(".headline h2")).to_have_text("Best design so far")
    page = watched.go("")
    page.get_by_label("Search").fill("not done")
    card = page.locator(f'[data-study="{study_id}"]')
    expect(card.locator(".thumbnail")).to_have_text("partly computed, no picture")
    expect(page.locator("li.card")).to_have_count(1)


def test_the_first_screen_says_why_the_best_design_may_not_be_the_best(
    open_page: Callable[..., Any], client: httpx.Client, service: Any
) -> None:
    frequencies = {"start": 0.9, "stop": 1.1, "num": 4}  # the resonance lies between two of them
    axes = {"friction_ratio": [0.1, 0.2, 0.3], "frequency_ratio": frequencies}
    study = {"name": "short axis", "particle": False, "damping_ratio": 0.02, "axes": axes}
    study_id = computed(service, study)["id"]
    doubts = client.get(f"/api/v1/studies/{study_id}/optimal-designs").json()["doubts"]
    assert [doubt["kind"] for doubt in doubts] == ["hidden_peak", "end_of_range", "rugged"]
    page = open_page().go(f"#/studies/{study_id}")
    expect(page.locator(".headline")).to_be_in_viewport(ratio=1)
    said = page.locator(
        ".headline"
    ).inner_text()  # made in one piece: what is missing now does not come later
    for doubt in doubts:
        assert doubt["sentence"].replace("`", "") in said  # set as code
