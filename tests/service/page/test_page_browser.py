"""What people do on the page, in a real browser before a real service; what follows at night has its files beside this one."""

import csv
import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import httpx
import pytest
from playwright.sync_api import Page, expect
from tests.service.conftest import SPECIFICATION, computed
from tests.service.page.looking import (
    IN_UNITS,
    KNOWN_POINTS,
    NO_PLOT_IS_EMPTY,
    Held,
    pick,
    serious,
    until,
)
from tests.service.security.conftest import make_key

FIRST_TRACE = "[...document.querySelector('.plot').data[0].y]"
PLACE_OF_TRACE = """(name) => {
  const plot = document.querySelector(".plot");
  const trace = plot.data.find((one) => one.name === name);
  const { xaxis, yaxis } = plot._fullLayout;
  const box = plot.getBoundingClientRect();
  return [box.x + xaxis._offset + xaxis.l2p(trace.x[0]), box.y + yaxis._offset + yaxis.l2p(trace.y[0])];
}"""
LOOKS = """(name) => {
  const { marker } = document.querySelector('.plot').data.find((one) => one.name === name);
  return [marker.symbol, marker.color, marker.line.color];
}"""
IS_MARKED = "(name) => document.querySelector('.plot').data.some((one) => one.name === name)"
NAME = '<img src=x onerror="window.taken=1"><b>\'"&amp;</b><script>window.taken=1</script>'


def assert_names_are_text(page: Page) -> None:
    assert page.evaluate("window.taken") is None
    assert page.locator("main img, main b").count() == 0


def test_the_whole_journey_of_a_study_whose_name_is_text_wherever_it_stands(
    open_page: Callable[..., Any], client: httpx.Client, tmp_path: Path
) -> None:
    watched = open_page()
    # the estimate refuses what is typed so far; a study that is asked for in the end is not there
    watched.allowed = ("status of 422", "404 (Not Found)")
    page = watched.go()
    page.get_by_role("navigation").get_by_role("link", name="New study").click()
    page.get_by_label("Start from").select_option("figure-11")
    clearance = page.get_by_role("group", name="Clearance ratio d/Z")
    clearance.get_by_label("values").fill("5")
    page.get_by_role("group", name="Friction ratio γ_F").get_by_label("values").fill("6")
    # a comma that is typed or pasted into a number is its decimal point
    mass = page.get_by_role("group", name="Mass ratio β").get_by_label("Mass ratio β", exact=True)
    mass.fill("")
    mass.press_sequentially("0,125")
    expect(mass).to_have_value("0.125")
    mass.press("Control+A")
    page.keyboard.insert_text("0,1")
    expect(mass).to_have_value("0.1")
    assert json.loads(page.get_by_label("The study as JSON").input_value())["axes"]["mass_ratio"] == 0.1
    page.get_by_label("Name").fill(NAME)
    expect(page.locator(".estimate")).to_contain_text("30")
    page.get_by_role("button", name="Run the study").click()

    expect(page.get_by_role("heading", level=1)).to_have_text(NAME)
    expect(page.locator(".head .badge")).to_contain_text("done", timeout=1_800_000)
    until(page, KNOWN_POINTS, lambda known: known == 30)
    assert_names_are_text(page)

    # friction alone has the least value and clamps nothing: it leads, and the best with impacts is marked beside it
    until(page, IS_MARKED, bool, "optimum")
    # within an outline of the other end of brightness, so that it is seen on cells of any
    assert page.evaluate(LOOKS, "best with impacts") == ["star", "white", "black"]
    study_id = re.search(r"#/studies/(\w+)", page.url).group(1)  # type: ignore[union-attr]
    best = client.get(f"/api/v1/studies/{study_id}/optimal-designs?top=1").json()["designs"][0]
    head = page.get_by_role("region", name="Best design", exact=True)
    # the ranking of all points is there: it moves the mark, and makes the headline higher
    expect(head.get_by_role("heading")).to_have_text("No design is recommended yet")
    expect(head.locator("strong")).to_contain_text(f"{best['value']:.5g}")
    page.mouse.click(*page.evaluate(PLACE_OF_TRACE, "optimum"))
    panel = page.locator(".point")
    expect(panel.get_by_role("heading", level=2)).to_contain_text(f"d/Z = {best['clearance_ratio']:g}")
    expect(panel.locator("dd").first).to_have_text(f"{best['value']:.6g}")
    expect(panel.get_by_role("heading", name="Motion at r = 1")).to_be_visible()
    assert f"friction_ratio={best['friction_ratio']}" in page.url

    with page.expect_download() as download:
        page.get_by_role("button", name=f"Download as PNG: Resonance map of {NAME}").click()
    picture = tmp_path / "map.png"
    download.value.save_as(picture)
    assert picture.read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"
    assert picture.stat().st_size > 10_000
    with page.expect_download() as download:
        page.get_by_role("button", name=f"Download as CSV: Resonance map of {NAME}").click()
    table = tmp_path / "map.csv"
    download.value.save_as(table)
    head_row, *rows = list(csv.reader(table.read_text().splitlines()))
    assert head_row[2] == "amplitude ratio X/Z"
    shown = {(float(x), float(y)): float(value) for x, y, value in rows}
    assert len(shown) == 30
    assert shown[best["clearance_ratio"], best["friction_ratio"]] == best["value"]

    page.get_by_role("link", name="Tuned mass damper").click()
    at = {"clearance_ratio": best["clearance_ratio"], "friction_ratio": best["friction_ratio"]}
    compared = client.get(f"/api/v1/studies/{study_id}/tmd-comparison", params=at).json()
    # at one frequency no ratio is shown, but what to compute next
    assert "frequency_ratio: {start" in compared["brief"]["next"]  # which is a button
    for sentence in compared["verdict"]:
        expect(page.get_by_text(sentence)).to_be_visible()
    expect(page.locator("#tmd-ratio")).to_have_count(0)
    assert_names_are_text(page)
    further = page.get_by_role("link", name="Judge it over r = 0.8 to 1.25").get_attribute("href")

    page.go_back()  # to the map, with the point that was chosen
    expect(panel.get_by_role("heading", level=2)).to_contain_text(f"d/Z = {best['clearance_ratio']:g}")
    link = page.get_by_role("link", name="Judge it over r = 0.8 to 1.25")
    assert link.get_attribute("href") == further
    link.click()
    text = page.get_by_label("The study as JSON")
    over_band = json.loads(text.input_value())
    assert over_band["name"] == f"{NAME}, over a band"
    assert over_band["axes"]["frequency_ratio"] == {"start": 0.8, "stop": 1.25, "num": 19}
    definition = client.get(f"/api/v1/studies/{study_id}").json()["definition"]
    assert over_band["axes"]["friction_ratio"] == definition["axes"]["friction_ratio"]

    text.fill(json.dumps({"name": NAME, "<b>x</b>": 1}))
    expect(page.locator(".cost .faults")).to_contain_text("<b>x</b>")
    assert_names_are_text(page)
    page.get_by_role("navigation").get_by_role("link", name="Studies", exact=True).click()
    page.get_by_role("link", name=NAME, exact=True).click()
    page.get_by_role("link", name="Data", exact=True).click()
    expect(page.get_by_role("heading", name="Download the data")).to_be_visible()
    assert_names_are_text(page)
    page.evaluate("location.hash = '#/studies/<img src=x onerror=window.taken=1>'")
    expect(page.get_by_role("alert")).to_contain_text("no such study")
    assert_names_are_text(page)


def test_keys_alone_reach_and_move_the_point(
    open_page: Callable[..., Any], small_map: dict[str, Any]
) -> None:
    page = open_page().go(f"#/studies/{small_map['id']}/map?clearance_ratio=5&friction_ratio=0.2")
    until(page, KNOWN_POINTS, lambda known: known > 0)
    heading = page.locator(".point h2")

    def tab_to(focused: str) -> None:
        for _ in range(40):
            page.keyboard.press("Tab")
            if page.evaluate(f"document.activeElement.{focused}"):
                return
        raise AssertionError(f"no key leads to {focused}")

    expect(heading).to_contain_text("d/Z = 5")
    page.keyboard.press("Tab")
    assert page.evaluate("document.activeElement.textContent") == "Skip to the content"
    tab_to("classList.contains('plot')")
    page.keyboard.press("ArrowRight")
    expect(heading).to_contain_text("d/Z = 10")
    page.keyboard.press("ArrowUp")
    expect(heading).to_contain_text("= 0.4")
    tab_to("getAttribute('aria-label') === 'Friction ratio of the point'")
    page.keyboard.press("Home")
    expect(heading).to_contain_text("= 0.2")
    expect(page.locator(".point").get_by_role("heading", name=re.compile("Motion at r"))).to_be_visible()


def test_a_map_has_no_serious_fault_of_accessibility_and_is_not_wider_than_a_telephone(
    open_page: Callable[..., Any], small_map: dict[str, Any]
) -> None:
    watched = open_page(viewport={"width": 390, "height": 900})
    page = watched.go(f"#/studies/{small_map['id']}/map?clearance_ratio=10&friction_ratio=0.4")
    page.wait_for_selector(".point .js-plotly-plot", state="attached")
    assert serious(page, ("dark",)) == []
    assert page.evaluate("document.documentElement.scrollWidth") <= 390


def test_a_late_ranking_of_designs_does_not_replace_a_later_one(
    open_page: Callable[..., Any], client: httpx.Client, small_map: dict[str, Any]
) -> None:
    path = f"/api/v1/studies/{small_map['id']}/optimal-designs"
    early, late = (
        client.get(path, params={"objective": objective}).json()["designs"][0]["value"]
        for objective in ("resonance", "band_rms")
    )
    assert f"{early:.3g}" != f"{late:.3g}"
    page = open_page().go(f"#/studies/{small_map['id']}")
    best = page.locator(".designs tbody td").first
    expect(best).not_to_be_empty()
    request = Held(page, "objective=resonance")
    pick(page, "Judged by", "resonance")
    pick(page, "Judged by", "band_rms")
    expect(best).to_contain_text(f"{late:.4g}"[:4])
    request.let_go()
    expect(best).to_contain_text(f"{late:.4g}"[:4])


def test_a_design_is_asked_for_in_the_form_followed_and_answered(
    open_page: Callable[..., Any], client: httpx.Client
) -> None:
    page = open_page().go()
    page.get_by_role("navigation").get_by_role("link", name="Designs").click()
    page.get_by_role("link", name="New design").click()
    expect(page.get_by_role("heading", name="New design", level=1)).to_be_visible()
    page.get_by_label("The specification as JSON").fill(json.dumps(SPECIFICATION))
    # the fields follow the text, in the units of a drawing
    clearance = page.get_by_role("group", name="Clearance d on either side")
    expect(clearance.get_by_label("Value")).to_have_value("5")
    clearance.get_by_label("Value").fill("5.6")
    friction = page.get_by_role("group", name="Coulomb friction force")
    expect(friction.get_by_label("It is")).to_have_value("range")
    page.get_by_role("textbox", name="Name").fill("asked on the page")
    asked = json.loads(page.get_by_label("The specification as JSON").input_value())
    assert asked == SPECIFICATION | {"clearance_m": 0.0056, "name": "asked on the page"}
    expect(page.locator(".estimate")).to_contain_text("200")
    page.get_by_role("button", name="Find the damper").click()
    expect(page.get_by_role("heading", name="asked on the page", level=1)).to_be_visible()
    expect(page.get_by_role("region", name="Progress")).to_be_visible()
    expect(page.get_by_role("region", name="The best so far")).to_contain_text("N")
    recommended = page.get_by_role("region", name="Recommended damper")
    expect(recommended).to_be_visible(timeout=1_800_000)
    address = f"/api/v1/designs/{page.url.rpartition('/')[2]}"
    answer = client.get(address).json()["answer"]
    for sentence in answer["words"]:
        expect(recommended).to_contain_text(sentence.replace("`", ""))
    expect(recommended).to_contain_text("5.6 mm")
    expect(
        page.get_by_role("row", name=re.compile("^Tuned mass damper of the same mass, up to 2 %"))
    ).to_contain_text("mm")
    # what is known is drawn: others beside it, and what other amplitudes and masses do
    expect(page.locator(".plot .main-svg").first).to_be_visible()
    curves = page.get_by_role("img", name=re.compile("^Response over the band"))
    expect(curves).to_contain_text("tuned mass damper")
    (recommended_curve, *_) = page.evaluate(
        "document.querySelector('.js-plotly-plot').data.map((each) => ({x: [...each.x], y: [...each.y]}))"
    )
    assert recommended_curve["x"] == pytest.approx(answer["response"]["frequency_hz"])
    assert recommended_curve["y"] == pytest.approx([1e3 * metres for metres in answer["response"]["value"]])
    report = page.get_by_role("link", name="Report").get_attribute("href")
    assert "asked on the page" in httpx.get(report, timeout=300).text
    page.go_back()
    expect(page.get_by_role("heading", name="New design", level=1)).to_be_visible()
    page.go_forward()
    expect(recommended).to_be_visible()
    page.get_by_role("link", name="Change and ask again").click()
    expect(page.get_by_role("textbox", name="Name")).to_have_value("asked on the page, changed")
    page.goto(f"{page.url.partition('#')[0]}#/designs")
    page.get_by_role("link", name="asked on the page").click()
    page.get_by_text("Rename").click()
    page.get_by_role("textbox", name="Name").fill("renamed on the page")
    page.get_by_role("button", name="Save name").click()
    expect(page.get_by_role("heading", name="renamed on the page", level=1)).to_be_visible()
    assert client.get(address).json()["name"] == "renamed on the page"
    page.get_by_role("button", name="Delete renamed on the page").click()
    page.get_by_role("button", name="Delete it").click()
    expect(page.get_by_role("heading", name="Designs", level=1)).to_be_visible()
    assert client.get(address).status_code == 404
    # it comes back from the trash, or is gone for good
    page.get_by_label("State").select_option("trash")
    page.get_by_role("button", name="Restore renamed on the page").click()
    expect(page.get_by_text("No design matches the search.")).to_be_visible()
    assert client.get(address).status_code == 200
    page.get_by_label("State").select_option("")
    page.get_by_label("Choose renamed on the page").check()
    page.get_by_role("group", name="Those chosen").get_by_role("button", name="Delete").click()
    page.get_by_role("dialog").get_by_role("button", name="Delete").click()
    page.get_by_label("State").select_option("trash")
    page.get_by_role("button", name="Delete for good renamed on the page").click()
    page.get_by_role("button", name="Delete it for good").click()
    expect(page.get_by_text("No design matches the search.")).to_be_visible()
    assert client.get("/api/v1/designs", params={"trash": True}).json()["designs"] == []


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


def test_studies_are_sorted_by_what_they_reach_compared_and_deleted_together(
    open_page: Callable[..., Any], client: httpx.Client, service: Any
) -> None:
    names = ["row: worse", "row: better", "row: middling"]
    for name, frictions in zip(names, ([0.1, 0.2], [0.5, 0.6], [0.2, 0.4]), strict=True):
        axes = {"friction_ratio": frictions, "frequency_ratio": [0.9, 1.0, 1.1]}
        study = {"name": name, "particle": False, "damping_ratio": 0.02, "axes": axes}
        record = computed(service, study)
    worse, better, middling = names
    page = open_page().go("")
    page.get_by_label("Search").fill("row:")
    titles = page.locator(".cards .title")
    expect(titles).to_have_text([middling, better, worse])
    expect(page.locator(".best strong")).to_have_count(3)
    page.get_by_label("Sorted by").select_option("best")
    expect(titles).to_have_text([better, middling, worse])
    assert "sort=best" in page.url
    for name in (better, worse):
        page.get_by_label(f"Choose {name}").check()
    page.get_by_role("link", name="Compare").click()
    rows = page.get_by_role("region", name="Compared").get_by_role("row")
    expect(rows).to_have_count(3)
    best = client.get(f"/api/v1/studies/{record['id']}/optimal-designs").json()["designs"][0]
    page.go_back()
    page.get_by_label(f"Choose {middling}").check()
    expect(page.locator(".best strong").nth(1)).to_have_text(f"{best['value']:.4g} X/Z")
    page.get_by_label(f"Choose {better}").check()
    page.get_by_role("group", name="Those chosen").get_by_role("button", name="Delete").click()
    page.get_by_role("dialog").get_by_role("button", name="Delete").click()
    expect(titles).to_have_text([worse])
    assert len(client.get("/api/v1/studies", params={"name": "row:"}).json()["studies"]) == 1
    page.get_by_label("State").select_option("trash")
    expect(titles).to_have_text([middling, better])
    page.get_by_role("button", name=f"Restore {middling}").click()
    expect(titles).to_have_text([better])
    page.get_by_role("button", name=f"Delete for good {better}").click()
    page.get_by_role("button", name="Delete it for good").click()
    expect(page.get_by_text("No study matches the search.")).to_be_visible()
    page.get_by_label("State").select_option("")
    expect(titles).to_have_text([middling, worse])


RATIO = re.compile(
    r".{0,40}(?:\bd/Z|γ_F|X/Z|Z·ω|\br = |/ Z\b|(?<!\w)β|\w+(?<!damping)_ratio(?:_at| = )|amplitude ratio).{0,20}"
)
VIEWS = {
    "map": ".plot .main-svg",
    "explore": ".parallel",
    "tmd": "#tmd-ratio",
    "earthquake": ".records option >> nth=1",
    "beside": ".beside-study .main-svg",
    "data": "pre",
}
"""The views of a study, with what each has once it is complete."""
SHOWN = "() => document.querySelector('main').innerText"


def test_no_view_of_a_study_in_units_has_a_ratio(open_page: Callable[..., Any], service: Any) -> None:
    other = IN_UNITS | {"name": "the other", "axes": {"restitution": 0.3}}
    first, second = (computed(service, each)["id"] for each in (IN_UNITS, other))
    point = f"clearance_ratio=4&friction_ratio=0.1&pins=0.0&minus={second}&pareto=impact_speed"
    page = open_page().go(f"#/studies/{first}?{point}")
    found = {}
    for view, ready in VIEWS.items():
        page.locator(f"nav.tabs a[href='#/studies/{first}/{view}']").click()
        page.wait_for_selector(ready, state="attached")
        until(page, SHOWN, lambda text: "damper in units" in text and "Computing" not in text)
        if view != "earthquake":
            until(page, NO_PLOT_IS_EMPTY, bool)
        text = page.evaluate(SHOWN)
        if view == "data":  # the definition and the names of files are what was submitted
            text = text.partition("Definition")[0]
        found[view] = RATIO.findall(text)
    assert found == {view: [] for view in VIEWS}


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
