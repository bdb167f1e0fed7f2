"""What somebody sees who has never been here: a key to sign in with, an empty service, a form, a study that is not done."""

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import httpx
import pytest
from playwright.sync_api import expect
from tests.service.page.looking import serious
from tests.service.security.conftest import make_key

FIRST_TRACE = "[...document.querySelector('.plot').data[0].y]"
FOCUSED = "document.activeElement.closest('label')?.querySelector('span')?.textContent"


@pytest.mark.night
def test_an_empty_service_leads_to_a_design_in_units(
    open_page: Callable[..., Any], own_service: Callable[..., Any]
) -> None:
    page = open_page(own_service().url).go()
    expect(page.get_by_role("heading", name="No studies yet")).to_be_visible()
    page.get_by_role("link", name="Specify a design").click()
    expect(page.get_by_role("heading", name="New design")).to_be_visible()


def test_a_fit_and_an_earthquake_need_no_study(open_page: Callable[..., Any]) -> None:
    page = open_page().go()
    with page.expect_response(re.compile("/earthquake-comparisons$")) as answered:
        page.get_by_role("navigation").get_by_role("link", name="Earthquake").click()
    expect(page.get_by_role("row", name=re.compile("^tuned mass damper"))).to_be_visible()
    peaks = [case["peak_relative_displacement_m"] for case in answered.value.json()["cases"].values()]
    page.wait_for_selector(".plot .plot-container")
    assert page.evaluate(FIRST_TRACE) == pytest.approx([1000 * peak for peak in peaks])
    page.get_by_role("navigation").get_by_role("link", name="Fit").click()
    page.get_by_label("Start from").select_option("friction of a structure")
    damping = page.get_by_role("group", name="Structural damping ratio")
    damping.get_by_label("Value").fill("0.03")
    expect(page.locator(".estimate")).to_contain_text("The estimate takes")
    asked = json.loads(page.get_by_label("The question as JSON").input_value())
    assert (asked["structure"]["damping_ratio"], asked["fit"]) == (0.03, {"friction_ratio": [0, 0.7]})
    page.get_by_role("button", name="Estimate").click()
    found = page.get_by_role("region", name="What was found").first
    expect(found.get_by_role("row", name=re.compile("^Friction ratio"))).to_contain_text("to")
    page.wait_for_selector(".plot .plot-container")
    assert page.evaluate(FIRST_TRACE) == pytest.approx([6.1, 10.2, 16.4, 11.8, 7.6])  # as measured, in mm
    assert serious(page, ("light",)) == []


@pytest.mark.night
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


@pytest.mark.night
def test_the_best_of_a_study_that_is_not_done_is_so_far_the_best(
    open_page: Callable[..., Any], client: httpx.Client, helpers: Any
) -> None:
    study = helpers.long_study("not done", damping_ratio=0.0047)
    study_id = client.post("/api/v1/studies", json=study).raise_for_status().json()["id"]
    helpers.wait_for(client, study_id, lambda record: record["points_done"] > 0)
    client.post(f"/api/v1/studies/{study_id}/cancel").raise_for_status()
    record = helpers.wait_for(client, study_id, helpers.ended)
    assert record["points_done"] < record["points_total"]
    watched = open_page()
    page = watched.go(f"#/studies/{study_id}")
    expect(page.locator(".headline h2")).to_have_text("Best design so far")
    page = watched.go("")
    page.get_by_label("Search").fill("not done")
    card = page.locator(f'[data-study="{study_id}"]')
    expect(card.locator(".thumbnail")).to_have_text("partly computed, no picture")
    expect(page.locator("li.card")).to_have_count(1)


@pytest.mark.night
def test_the_first_screen_says_why_the_best_design_may_not_be_the_best(
    open_page: Callable[..., Any], client: httpx.Client, helpers: Any
) -> None:
    frequencies = {"start": 0.9, "stop": 1.1, "num": 4}  # the resonance lies between two of them
    axes = {"friction_ratio": [0.1, 0.2, 0.3], "frequency_ratio": frequencies}
    study = {"name": "short axis", "particle": False, "damping_ratio": 0.02, "axes": axes}
    study_id = client.post("/api/v1/studies", json=study).raise_for_status().json()["id"]
    helpers.wait_for(client, study_id, helpers.ended)
    doubts = client.get(f"/api/v1/studies/{study_id}/optimal-designs").json()["doubts"]
    assert [doubt["kind"] for doubt in doubts] == ["hidden_peak", "end_of_range", "rugged"]
    page = open_page().go(f"#/studies/{study_id}")
    expect(page.locator(".headline")).to_be_in_viewport(ratio=1)
    said = page.locator(
        ".headline"
    ).inner_text()  # made in one piece: what is missing now does not come later
    for doubt in doubts:
        assert doubt["sentence"].replace("`", "") in said  # set as code


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
