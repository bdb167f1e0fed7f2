"""What was asked for first and answered last: a view shows what is chosen now, and asks for nothing else."""

from collections.abc import Callable
from typing import Any

import httpx
import pytest
from playwright.sync_api import expect
from tests.service.page.looking import Held, pick, until

pytestmark = pytest.mark.night

CURVES = """() => Object.fromEntries([...document.querySelectorAll(".survey .plot")]
  .map((plot) => [plot.getAttribute("aria-label"), plot.data?.length ?? 0]))"""
FRAGILITY = "Probability of exceeding the limit"
AT_ONCE = """async () => {
  const limit = document.querySelector(".survey input");
  limit.value = String(2 * Number(limit.value));
  limit.dispatchEvent(new Event("input"));
  const labels = [...document.querySelectorAll("label.field")];
  const shown = labels.find((one) => one.textContent.startsWith("Shown")).querySelector("select");
  shown.value = "status";
  shown.dispatchEvent(new Event("change"));
  await new Promise((over) => setTimeout(over, 600));
}"""
"""A limit is typed and another result chosen before the limit is asked about, which is 200 ms later."""


def test_a_limit_is_asked_about_only_of_the_result_that_it_was_typed_for(
    open_page: Callable[..., Any], suite: dict[str, Any]
) -> None:
    watched = open_page()
    page = watched.go(f"#/studies/{suite['id']}")
    page.locator(".survey input").first.fill("10")  # no limit counts that nobody named
    until(page, CURVES, lambda curves: curves.get(FRAGILITY, 0) > 0)
    page.evaluate(AT_ONCE)
    asked = [one.url for one in watched.requests if "/fragility" in one.url]
    assert asked
    assert not [url for url in asked if "status" in url]
    panel = page.get_by_role("region", name="The damper")
    expect(panel).to_contain_text("no limit can be exceeded")
    expect(panel.get_by_role("spinbutton")).to_be_hidden()
    pick(page, "Shown", "peak_absolute_acceleration_m_s2")
    expect(panel.get_by_role("spinbutton")).to_be_visible()
    expect(panel.locator("label.field")).to_contain_text("Limit [m/s²]")


def test_late_answers_do_not_replace_later_ones_where_a_study_is_explored(
    open_page: Callable[..., Any], client: httpx.Client, small_map: dict[str, Any]
) -> None:
    page = open_page().go(f"#/studies/{small_map['id']}/explore")
    designs = page.locator("section").filter(has=page.get_by_role("heading", name="All designs"))
    said = designs.locator("p[role=status]")
    whole = client.get(f"/api/v1/studies/{small_map['id']}/optimal-designs", params={"top": 2000}).json()
    request = Held(page, "stick_fraction=0%2C0")
    designs.get_by_label("Share of time sticking").fill("0")
    request.wait()  # while it waits for more to be typed
    designs.get_by_label("Share of time sticking").fill("1")
    expect(said).to_contain_text(f"of {len(whole['designs'])} designs")
    request.let_go()
    expect(said).to_contain_text(f"of {len(whole['designs'])} designs")


def test_a_late_list_of_studies_does_not_replace_what_was_searched_for_last(
    open_page: Callable[..., Any], small_map: dict[str, Any], suite: dict[str, Any]
) -> None:
    page = open_page().go()
    card = page.locator(".cards .title")
    expect(card.filter(has_text="small map").first).to_be_visible()
    request = Held(page, "name=two+earthquakes")
    page.get_by_label("Search").fill("two earthquakes")
    request.wait()
    page.get_by_label("Search").fill("small map")
    expect(card.filter(has_text="two earthquakes")).to_have_count(0)
    request.let_go()
    expect(card.filter(has_text="two earthquakes")).to_have_count(0)


def test_a_tab_that_was_left_does_not_take_the_address_back(
    open_page: Callable[..., Any], small_map: dict[str, Any]
) -> None:
    page = open_page().go(f"#/studies/{small_map['id']}/tmd")
    expect(page.locator("#tmd-ratio")).to_be_visible()
    page.evaluate(
        """async () => {
          const slider = [...document.querySelectorAll("label.slider")]
            .find((one) => one.textContent.startsWith("Frequency off by")).querySelector("input");
          slider.value = "10";
          slider.dispatchEvent(new Event("input"));
          [...document.querySelectorAll("nav.tabs a")].find((one) => one.textContent === "Data").click();
          await new Promise((over) => setTimeout(over, 600));
        }"""
    )
    expect(page.get_by_role("heading", name="Download the data")).to_be_visible()
    assert f"/studies/{small_map['id']}/data" in page.url
    assert "detuning=0.1" in page.url


@pytest.mark.parametrize(
    ("address", "text", "cost"),
    [
        ("#/new", "The study as JSON", "Expected cost"),
        ("#/designs/new?specification=prototype", "The specification as JSON", "Budget"),
    ],
)
def test_a_late_dry_run_is_not_given_up_and_replaces_nothing(
    open_page: Callable[..., Any], address: str, text: str, cost: str
) -> None:
    watched = open_page()
    watched.allowed = ("422",)
    page = watched.go("#/")
    request = Held(page, "dry_run")
    page.evaluate("(address) => { location.hash = address }", address)
    request.wait()
    page.get_by_label(text).evaluate(
        """(box) => { box.value = '{"name": 1}'; box.dispatchEvent(new Event("input")) }"""
    )
    estimate = page.get_by_role("region", name=cost).locator("[role=status]")
    expect(estimate).to_contain_text("to fix before it can")
    request.let_go()
    expect(estimate).to_contain_text("to fix before it can")
