"""A study on the page in a real browser: its address, its motion, its units, its form, its end."""

import json
import os
import re
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import httpx
import numpy as np
import pytest
from playwright.sync_api import Page, expect
from tests.service.conftest import computed, lasting_study, wait_for
from tests.service.page.looking import (
    IN_UNITS,
    KNOWN_POINTS,
    NO_PLOT_IS_EMPTY,
    one_step,
    pick,
    run_the_lines_of_python,
    serious,
    until,
)

from damperlab.service.page.files import SMALL, plotly_path
from damperlab.service.reports import keep_report
from damperlab.worker.accuracy.cases import SCENES
from damperlab.worker.accuracy.extremes import Extreme
from damperlab.worker.accuracy.methods import METHODS
from damperlab.worker.accuracy.stability import stability_table
from damperlab.worker.accuracy.work_precision import draw_diagrams
from damperlab.worker.point import Design

pytestmark = pytest.mark.night

FIRST_MAP_BYTES = 700_000
ZOOMED = """() => {
  const plot = document.querySelector('.left .plot');
  return plot?._fullLayout && ['x', 'y'].flatMap((axis) => plot._fullLayout[`${axis}axis`].range);
}"""
ZOOM = """() => window.Plotly.relayout(document.querySelector('.left .plot'), {
  'xaxis.range[0]': 2, 'xaxis.range[1]': 12, 'yaxis.range[0]': 0.1, 'yaxis.range[1]': 0.5,
})"""


def test_an_address_shows_the_same_view_elsewhere_and_back_goes_one_step_back(
    open_page: Callable[..., Any], small_map: dict[str, Any]
) -> None:
    page = open_page().go(f"#/studies/{small_map['id']}")
    until(page, KNOWN_POINTS, lambda known: known == 9)
    # the part that is looked at: the cells that lie in it are shown whole
    page.evaluate(ZOOM)
    page.wait_for_url("**x_range=2*")
    part = until(page, ZOOMED, lambda ranges: ranges == pytest.approx([2.5, 12.5, 0.1, 0.5]))
    page.get_by_label("Contour lines").uncheck()
    page.wait_for_timeout(300)
    assert page.evaluate(ZOOMED) == part
    again = open_page().go(page.url.partition("/#")[2].join(["#", ""]))
    assert until(again, ZOOMED, bool) == part

    chosen = {"Up": "frequency_ratio", "Shown": "impacts_per_cycle", "Judged by": "band_mean"}
    for label, value in chosen.items():
        one_step(page, partial(pick, page, label, value))
    asked = 'resonance_map(x="clearance_ratio", y="frequency_ratio", metric="impacts_per_cycle"'
    expect(page.locator(".left .figure pre")).to_contain_text(asked)
    other = open_page().go(page.url.partition("/#")[2].join(["#", ""]))
    expect(other.locator(".left .figure pre")).to_contain_text(asked)

    def shows(view: Page, label: str, value: str) -> None:
        expect(view.locator("label.field").filter(has_text=label).locator("select")).to_have_value(value)

    for label, value in chosen.items():
        shows(other, label, value)
    page.go_back()
    shows(page, "Judged by", "peak")
    shows(page, "Shown", "impacts_per_cycle")
    page.go_back()
    shows(page, "Shown", "amplitude_ratio")


DRAWN = """() => [...document.querySelectorAll('.point .plot')].map((plot) => {
  const { xaxis, yaxis } = plot._fullLayout ?? {};
  return plot.data && {
    names: plot.data.map((one) => one.name), first: [...plot.data[0].y], exponents: yaxis.exponentformat,
    ends: [xaxis.range, yaxis.range], reach: ['x', 'y'].map((axis) => {
      const all = plot.data.flatMap((one) => [...one[axis]]);
      return [Math.min(...all), Math.max(...all)];
    }),
  };
})"""


def test_the_motion_is_shown_over_whole_periods_and_moves_when_it_is_played(
    open_page: Callable[..., Any], client: httpx.Client, small_map: dict[str, Any]
) -> None:
    def mapped(metric: str) -> np.ndarray[Any, Any]:
        asked = {"x": "clearance_ratio", "y": "friction_ratio", "metric": metric, "frequency_ratio": 1}
        answer = client.get(f"/api/v1/studies/{small_map['id']}/resonance-map", params=asked)
        return np.array(answer.json()["values"], float)

    periods, axes = mapped("period"), small_map["definition"]["axes"]
    j, i = np.argwhere((periods >= 1) & (mapped("impacts_per_cycle") > 0))[0]
    design = f"clearance_ratio={axes['clearance_ratio'][i]}&friction_ratio={axes['friction_ratio'][j]}"
    page = open_page().go(f"#/studies/{small_map['id']}/map?{design}&frequency_ratio=1&worst=no")
    panel = page.locator(".point")
    expect(panel.get_by_role("heading", name="Motion at r = 1")).to_be_visible()
    sketch = panel.get_by_role("img", name="Sketch of the damper as it moves")
    place = "(svg) => [...svg.querySelectorAll('g')].map((g) => g.getAttribute('transform')).join(' ')"
    at_first = sketch.evaluate(place)
    panel.get_by_role("button", name="One step on").click()
    assert sketch.evaluate(place) != at_first
    panel.get_by_role("button", name="One step back").click()
    assert sketch.evaluate(place) == at_first
    panel.get_by_role("button", name="Play").click()
    until(page, "() => document.querySelector('.sketch g').getAttribute('transform')", at_first.__ne__)
    panel.get_by_role("button", name="Pause").click()

    cycles = int(panel.get_by_label("Moment of the motion, in cycles").get_attribute("max") or 0)
    assert cycles % periods[j, i] == 0
    _, motion, phase, spectrum, _ = until(page, DRAWN, lambda drawn: len(drawn) == 5 and all(drawn))
    assert {"structure x", "base z", "particle in its cavity", "walls"} <= set(motion["names"])
    assert {"structure", "once a cycle"} <= set(phase["names"])
    # a line at the frame looks cut
    for (low, high), (least, most) in zip(phase["ends"], phase["reach"], strict=True):
        assert low < least - 0.04 * (most - least)
        assert high > most + 0.04 * (most - least)
    # "100μ" on an axis in millimetres would be read as micrometres
    assert spectrum["exponents"] == "power"
    # the figure's own line of Python gives the very motion that is drawn
    found = run_the_lines_of_python(page, ".point")
    (answer,) = (each for each in found if hasattr(each, "history"))
    assert motion["first"] == pytest.approx(answer.history["u"].values, rel=1e-12)


def test_a_study_in_units_is_shown_in_units_or_as_ratios_and_the_choice_is_remembered(
    open_page: Callable[..., Any], client: httpx.Client, service: Any
) -> None:
    force = 100.0 * (2 * np.pi * 8.0) ** 2 * 0.0005
    physical = {
        "mass_kg": 100.0,
        "natural_frequency_hz": 8.0,
        "base_amplitude_m": 0.0005,
        "friction_force_n": [0.2 * force, 0.4 * force],
        "excitation_frequency_hz": {"start": 6.4, "stop": 9.6, "num": 5},
    }
    study = {"name": "machine floor", "particle": False, "damping_ratio": 0.02, "physical": physical}
    record = computed(service, study)
    best = client.get(f"/api/v1/studies/{record['id']}/optimal-designs").json()["designs"][0]
    at = f"friction_ratio={best['friction_ratio']}"
    curve = client.get(f"/api/v1/studies/{record['id']}/frequency-response?{at}").json()["values"]
    page = open_page().go(f"#/studies/{record['id']}/map?{at}")
    head = page.get_by_role("region", name="Best design", exact=True)
    shown = "() => [...document.querySelectorAll('.plot')].map((plot) => plot.data?.[0]?.y ?? [])[1]"
    expect(head.locator("strong")).to_have_text(f"{0.5 * best['value']:.5g} mm")
    expect(head).to_contain_text(f"Ff = {best['friction_ratio'] * force:.5g} N")
    until(page, shown, lambda drawn: drawn == pytest.approx([0.5 * x for x in curve], rel=1e-12))
    page.get_by_label("Quantities").select_option("ratios")
    expect(head.locator("strong")).to_have_text(f"{best['value']:.5g}")
    until(page, shown, lambda drawn: drawn == pytest.approx(curve, rel=1e-12))
    page.reload()
    expect(page.get_by_label("Quantities")).to_have_value("ratios")


def test_the_list_of_studies_comes_before_the_plotting_library_which_is_small(
    open_page: Callable[..., Any], small_map: dict[str, Any]
) -> None:
    watched = open_page(color_scheme="light")  # with options: nothing is in its memory
    sizes: list[int] = []
    watched.page.on("requestfinished", lambda request: sizes.append(request.sizes()["responseBodySize"]))
    watched.page.goto(watched.root + "/")
    watched.page.wait_for_selector(".card")
    watched.page.wait_for_function("() => window.Plotly")
    asked = [request.url for request in watched.requests]
    listed, plotted = (
        next(i for i, url in enumerate(asked) if part in url) for part in ("/studies?", "plotly")
    )
    assert listed < plotted
    if plotly_path().name != SMALL:
        how = "the page has no small plotting library: npm, then make install-dev"
        if os.environ.get("CI") == "true":
            pytest.fail(how)
        pytest.skip(how)
    watched.page.goto(f"{watched.root}/#/studies/{small_map['id']}/map")
    until(watched.page, KNOWN_POINTS, lambda known: known == 9)
    watched.page.wait_for_load_state("networkidle")
    assert [request.url for request in watched.requests if "plotly" in request.url]
    assert sum(sizes) < FIRST_MAP_BYTES


def test_a_map_as_a_table_is_in_units_and_its_axes_are_without_what_conversion_leaves(
    open_page: Callable[..., Any], client: httpx.Client, service: Any
) -> None:
    # there and back, 9 mm over a base of 1.5 mm are 8.999999999999998 mm
    physical = IN_UNITS["physical"] | {"clearance_m": [0.003, 0.006, 0.009], "friction_force_n": [0.05, 0.11]}
    metrics = ["amplitude_ratio", "acceleration_ratio", "acceleration_ratio_rms"]
    study = IN_UNITS | {"name": "felt", "physical": physical, "metrics": metrics}
    record = computed(service, study)
    asked = {"x": "clearance_m", "y": "friction_force_n", "metric": "acceleration_m_per_s2"}
    address = f"/api/v1/studies/{record['id']}/resonance-map"
    answer = client.get(address, params=asked).raise_for_status().json()
    page = open_page().go(f"#/studies/{record['id']}?metric=acceleration_ratio")
    until(page, NO_PLOT_IS_EMPTY, bool)
    with page.expect_download() as download:
        page.get_by_role("button", name="Download as CSV: Resonance map of felt").click()
    head, *rows = Path(download.value.path()).read_text().splitlines()
    assert head == "Clearance d [mm],Friction force F_f [N],acceleration of the structure [m/s²]"
    places = [",".join(row.split(",")[:2]) for row in rows]
    assert places == ["3,0.05", "6,0.05", "9,0.05", "3,0.11", "6,0.11", "9,0.11"]
    # the page multiplies in another order
    shown = [float(row.split(",")[2]) for row in rows]
    assert shown == pytest.approx([value for row in answer["values"] for value in row], rel=1e-9)


def test_dampers_over_base_amplitudes_are_mapped_and_ranked_in_units_or_as_ratios(
    open_page: Callable[..., Any], client: httpx.Client, service: Any
) -> None:
    amplitudes = [0.0005, 0.001, 0.002]
    physical = {
        "mass_kg": 100.0,
        "natural_frequency_hz": 8.0,
        "base_amplitude_m": amplitudes,
        "friction_force_n": [30.0, 60.0],
        "excitation_frequency_hz": {"start": 6.4, "stop": 9.6, "num": 5},
    }
    study = {"name": "more or less", "particle": False, "damping_ratio": 0.02, "physical": physical}
    record = computed(service, study)

    def best(**asked: str) -> dict[str, Any]:
        address = f"/api/v1/studies/{record['id']}/optimal-designs"
        answer = client.get(address, params={"metric": "amplitude_m", **asked}).json()
        found: dict[str, Any] = answer["designs"][0]
        return found

    page = open_page().go(f"#/studies/{record['id']}")
    cells = page.locator(".designs tbody tr").first.locator("td")
    first = best()
    shown = [f"{first['friction_force_n']:g}", f"{1000 * first['value']:.5g}"]
    shown += [f"{1000 * first['base_amplitude_m']:g} mm", f"{8 * first['frequency_ratio']:.5g} Hz"]
    for place, text in enumerate(shown):
        expect(cells.nth(place)).to_have_text(text)
    assert serious(page) == []
    pick(page, "Base amplitude", "0.001")
    expect(cells.nth(1)).to_have_text(f"{1000 * best(base_amplitude_m='0.001,0.001')['value']:.5g}")
    pick(page, "Up", "base_amplitude_m")
    drawn = "() => [...document.querySelectorAll('.plot')].map((plot) => plot.data?.[0]?.y ?? [])[0]"
    until(page, drawn, lambda y: y == pytest.approx([1000 * one for one in amplitudes]))
    page.get_by_label("Quantities").select_option("ratios")
    expect(page.locator(".designs")).not_to_contain_text("[mm]")


def test_fields_and_json_follow_each_other_and_faults_stand_at_their_fields(
    open_page: Callable[..., Any],
) -> None:
    """How units become ratios is tested without a browser: `pure.test.mjs`."""
    watched = open_page()
    watched.allowed = ("422 (Unprocessable",)
    page = watched.go("#/new?scene=figure-11")
    text = page.get_by_label("The study as JSON")

    def asked() -> Any:
        return json.loads(text.input_value())

    mass = page.get_by_role("group", name="Mass ratio β")
    mass.get_by_label("Mass ratio β", exact=True).fill("-1")
    assert asked()["axes"]["mass_ratio"] == -1
    expect(mass.locator(".faults")).to_contain_text("not -1")
    expect(mass.get_by_label("Mass ratio β", exact=True)).to_have_attribute("aria-invalid", "true")

    study = asked()
    study["axes"]["mass_ratio"] = [0.1, 0.2]
    text.fill(json.dumps(study))
    expect(page.get_by_label("Mass ratio β: values, separated by commas")).to_have_value("0.1, 0.2")
    expect(page.locator(".estimate")).to_contain_text("3,234")
    text.fill("{")
    expect(page.locator(".beside .faults[role=alert]")).to_contain_text("not JSON yet")
    expect(page.get_by_role("button", name="Run the study")).to_be_disabled()
    text.fill(json.dumps(study))

    page.get_by_label("Sizes as").select_option("units")
    clearance = page.get_by_role("group", name="Clearance d [mm]")
    expect(clearance.get_by_label("Clearance d: to", exact=True)).to_have_value("37.5")
    page.get_by_text("Cavity, excitation").click()
    for group, value in (("Coefficient μ_i", "0.02"), ("Tilt α", "90")):
        page.get_by_role("group", name=group).locator("input[type=number]").fill(value)
    standing = {"particle_friction_coefficient": 0.02, "tilt_deg": 90}
    assert standing.items() <= asked()["physical"].items()
    expect(page.locator(".estimate")).to_contain_text("3,234")
    page.get_by_label("Sizes as").select_option("ratios")
    page.get_by_text("Cavity, excitation").click()
    page.get_by_role("group", name="Gravity along").locator("input[type=number]").fill("0")
    assert "gravity_ratio" not in asked()
    page.get_by_label("With a particle").uncheck()
    assert not {"particle_friction_ratio", "clearance_ratio"} & {*asked(), *asked()["axes"]}


def test_cancel_resume_and_delete_which_asks_first_and_the_keyboard_stays_where_it_is(
    open_page: Callable[..., Any], client: httpx.Client
) -> None:
    study = lasting_study("long")
    record = client.post("/api/v1/studies", json=study).raise_for_status().json()
    watched = open_page()
    # a study that is cancelled before any design has all its frequencies cannot say which is best
    watched.allowed = ("409 (Conflict",)
    page = watched.go(f"#/studies/{record['id']}")
    page.get_by_role("link", name="Edit a copy").focus()
    wait_for(client, record["id"], lambda now: now["points_done"] > 0)
    words = page.locator(".head .progress .words")
    expect(words).not_to_have_text(re.compile(r"^(Starting|Waiting|Compiling|0 of)"))
    at_first = until(page, KNOWN_POINTS, lambda known: known >= 0)
    until(page, KNOWN_POINTS, lambda known: known > at_first)  # the map fills before the reader's eyes
    assert page.evaluate("document.activeElement.textContent") == "Edit a copy"
    page.get_by_role("button", name="Cancel long").focus()
    page.keyboard.press("Enter")
    expect(page.get_by_role("button", name="Resume long")).to_be_visible()
    assert page.evaluate("document.activeElement.textContent") == "long"

    page = watched.go()
    card = page.locator(f"[data-study='{record['id']}']")
    page.get_by_label("Search").fill("long")
    card.get_by_role("button", name="Resume long").click()
    expect(card.locator(".badge")).to_contain_text(re.compile("queued|running"))
    card.get_by_role("button", name="Cancel long").click()
    expect(card.locator(".badge")).to_contain_text("cancelled")
    card.get_by_role("button", name="Delete long").click()
    dialog = page.get_by_role("dialog", name="Delete this study?")
    dialog.get_by_role("button", name="Keep it").click()
    expect(card).to_be_visible()
    wait_for(client, record["id"], lambda now: now["state"] == "cancelled" and now["owner"] is None)
    card.get_by_role("button", name="Delete long").click()
    dialog.get_by_role("button", name="Delete it").click()
    expect(card).to_have_count(0)
    assert client.get(f"/api/v1/studies/{record['id']}").status_code == 404


EVERY_VIEW = {
    "list": ("", ".card"),
    "form": ("#/new", ".estimate dl"),
    "map": (
        "#/studies/{study}/map?clearance_ratio=10&friction_ratio=0.4",
        ".point .js-plotly-plot",
    ),
    "tuned mass damper": ("#/studies/{study}/tmd", "#tmd-ratio"),
    "explore": ("#/studies/{study}/explore", ".parallel"),
    "earthquake": ("#/studies/{study}/earthquake", ".records option >> nth=1"),
    "data": ("#/studies/{study}/data", "pre"),
    "accuracy": ("#/accuracy", "pre"),
    "designs": ("#/designs", "main li"),
    "specification": ("#/designs/new", ".estimate"),
    "fit": ("#/fit", "textarea"),
}
"""Addresses of views, with what each shows once it is complete."""


@pytest.mark.parametrize(
    ("width", "schemes"),
    [
        (390, ("dark",)),
        (1440, ("light", "dark")),
    ],
)
def test_no_serious_fault_of_accessibility_and_nothing_wider_than_the_screen(
    open_page: Callable[..., Any],
    small_map: dict[str, Any],
    design: dict[str, Any],
    width: int,
    schemes: tuple[str, ...],
) -> None:
    watched = open_page(viewport={"width": width, "height": 900})
    for view, (address, ready) in EVERY_VIEW.items():
        page = watched.go(address.format(study=small_map["id"]))
        page.wait_for_selector(ready, state="attached")
        assert serious(page, schemes) == [], view
        assert page.evaluate("document.documentElement.scrollWidth") <= width, view


def test_an_accuracy_report_is_drawn_and_its_table_read(open_page: Callable[..., Any], service: Any) -> None:
    diagrams = draw_diagrams(METHODS, SCENES[:1])
    rows = stability_table([Extreme("ζ = 0.99, r = 2", Design(0.99, 2.0))])
    report = {
        "created": "2026-01-01T00:00:00+00:00",
        "version": "0",
        "diagrams": [one.document() for one in diagrams],
        "stability": [one.document() for one in rows],
        "passed": all(one.passed for one in rows),
    }
    kept = keep_report(service.log.parent / "data", report)
    try:
        page = open_page(viewport={"width": 390, "height": 900}).go("#/accuracy")
        page.wait_for_selector(".js-plotly-plot")
        expect(page.get_by_text("Every extreme case passed.")).to_be_visible()
        expect(page.get_by_role("row").nth(1)).to_contain_text("ζ = 0.99, r = 2")
        expect(page.get_by_role("row").nth(1)).to_contain_text("passed")
        curves = page.evaluate("document.querySelector('.plot').data.map((one) => one.x.length)")
        assert curves == [len([p for p in one.points if p.error is not None]) for one in diagrams[0].curves]
        assert serious(page) == []
        assert page.evaluate("document.documentElement.scrollWidth") <= 390
    finally:
        kept.unlink()


def test_a_record_of_ones_own_is_put_up_and_a_bad_one_refused(
    open_page: Callable[..., Any], small_map: dict[str, Any], tmp_path: Path
) -> None:
    watched = open_page()
    watched.allowed = ("422 (Unprocessable",)
    page = watched.go(f"#/studies/{small_map['id']}/earthquake")
    page.wait_for_selector(".records option >> nth=1", state="attached")
    page.get_by_text("Upload your own record").click()
    bad = tmp_path / "bad.csv"
    bad.write_text("time (s), acceleration (g)\n0, much\n")
    page.get_by_label("File", exact=True).set_input_files(bad)
    expect(page.locator(".records .faults")).to_contain_text("Line 2")
    expect(page.get_by_role("region", name="Comparison under the record").get_by_role("row")).to_have_count(6)
    expect(page.locator(".records .faults")).to_contain_text("Line 2")
    good = tmp_path / "mine.txt"
    # samples that no other test puts up: the same ones would be known by the name that came first
    good.write_text("time (s), acceleration (g)\n0, 0\n0.01, 0.1\n0.02, -0.07\n0.03, 0\n")
    page.get_by_label("File", exact=True).set_input_files(good)
    expect(page.locator(".records select").first.locator("option:checked")).to_contain_text("mine.txt (0.1 g")
    expect(page.get_by_role("region", name="Comparison under the record").get_by_role("row")).to_have_count(6)
