"""A ground-motion suite on the page: from the form to a fragility curve, in a real browser before a real service."""

import json
import re
from collections.abc import Callable
from typing import Any

import httpx
import pytest
from playwright.sync_api import expect
from tests.service.page.looking import KNOWN_POINTS, TRACES, pick, run_the_lines_of_python, serious, until

from damperlab.studies.ground.builtin import builtin_ids

pytestmark = pytest.mark.night

PLACE_OF_CELL = """([x, y]) => {
  const plot = document.querySelector(".plot");
  const { xaxis, yaxis } = plot._fullLayout;
  const box = plot.getBoundingClientRect();
  return [box.x + xaxis._offset + xaxis.l2p(x), box.y + yaxis._offset + yaxis.l2p(y)];
}"""
RISING = "Result over the scale of each record"
DRIFT = "Drift of the structure under the record"
CURVE = "Probability of exceeding the limit"


def test_a_survey_from_the_form_to_a_fragility_curve(
    open_page: Callable[..., Any], client: httpx.Client
) -> None:
    scales = [0.5, 1, 1.5, 2]
    watched = open_page(viewport={"width": 390, "height": 900})
    watched.allowed = ("422 (Unprocessable",)  # a survey without records is refused
    page = watched.go("#/new")
    page.get_by_label("Start from").select_option("ground-motion suite")
    records = page.get_by_role("group", name="Records")
    boxes = records.get_by_role("checkbox")
    expect(boxes.first).to_be_attached()
    assert boxes.count() >= len(builtin_ids())
    for box in boxes.all():
        box.set_checked(False)
    expect(page.locator("[data-field=records] .faults").last).to_contain_text("records")
    assert serious(page) == []
    for name in ("El Centro 1940, array 9, 180", "Northridge 1994, aftershock of 18 January, Sylmar, 360"):
        records.get_by_label(name).check()
    page.get_by_label("Name").fill("a survey")
    for group, values in (("Clearance d", "5, 20"), ("Factor on the records", "0.5, 1, 1.5, 2")):
        page.get_by_role("group", name=group).get_by_label("how it is given").select_option("list")
        page.get_by_role("group", name=group).get_by_label("values, separated").fill(values)
    page.get_by_role("group", name="Friction force").get_by_label("values, separated").fill("0.2, 0.8, 3")
    page.get_by_text("Cavity, contact").click()
    page.get_by_label("Coefficient μ_i").fill("0.05")
    asked = json.loads(page.locator("textarea").input_value())
    assert asked["particle_friction_coefficient"] == 0.05
    assert asked["axes"]["clearance_m"] == [0.005, 0.02]
    assert sorted(asked["records"]) == ["el-centro-180", "northridge-360"]
    expect(page.locator(".estimate")).to_contain_text("48")
    page.get_by_role("button", name="Run the study").click()

    expect(page.locator(".head .badge")).to_contain_text("done", timeout=1_800_000)
    tabs = page.get_by_role("navigation", name="Parts of the study").get_by_role("link")
    expect(tabs).to_have_text(["Map and dampers", "Compare", "Data"])
    until(page, KNOWN_POINTS, lambda known: known == 6)
    study = re.search(r"#/studies/(\w+)", page.url).group(1)  # type: ignore[union-attr]
    best = client.get(f"/api/v1/studies/{study}/optimal-designs").json()["designs"][0]
    cells = page.locator(".designs tbody tr").first.locator("td")
    expect(cells.first).to_have_text(f"{1000 * best['clearance_m']:g}")
    pick(page, "Record", "northridge-360")
    expect(cells.nth(3)).to_have_text("northridge-360")
    expect(page.locator(".left .note")).to_contain_text("record = northridge-360")
    pick(page, "Record", "")
    expect(cells.nth(3)).to_have_text(best["record"])
    page.locator(".plot").first.scroll_into_view_if_needed()
    page.mouse.click(*page.evaluate(PLACE_OF_CELL, [20, 0.8]))
    panel = page.get_by_role("region", name="The damper")
    expect(panel.get_by_role("heading", level=2)).to_contain_text("clearance 20 mm, friction force 0.8 N")
    at = {"clearance_m": 0.02, "friction_force_n": 0.8}

    # every record over the scale, as the service has it, in millimetres
    def over_the_scale(record: str) -> list[float]:
        told = {"x": "scale", "y": "damping_ratio", **at, "record": record}
        values = client.get(f"/api/v1/studies/{study}/resonance-map", params=told).json()["values"]
        return [1000 * value for value in values[0]]

    expected = {name: pytest.approx(over_the_scale(name), rel=1e-12) for name in asked["records"]}
    rising = until(
        page, TRACES, lambda traces: {one["name"]: one["y"] for one in traces[:2]} == expected, RISING
    )
    assert [trace["x"] for trace in rising[:2]] == [scales, scales]

    peaks = sorted(value for trace in rising[:2] for value in trace["y"])
    limit = float(f"{0.5 * (peaks[3] + peaks[4]):.4g}")
    panel.get_by_role("spinbutton").fill(str(limit))
    fitted = client.get(f"/api/v1/studies/{study}/fragility", params={"threshold": limit / 1000, **at}).json()
    expect(panel.get_by_role("status")).to_have_text(fitted["note"])
    curve = until(page, TRACES, lambda traces: traces and traces[0]["y"] == fitted["exceeded"], CURVE)
    if "median_scale" in fitted:
        assert curve[1]["y"] == pytest.approx(fitted["probability"])
    assert until(page, TRACES, lambda traces: traces[-1]["y"] == [limit, limit], RISING)
    # the motion of one case, as the service computes it
    motion = page.get_by_role("region", name="Motion of one case")
    motion.get_by_label("Motion under").select_option("northridge-360")
    motion.get_by_label("times").select_option("1.5")
    given = {"mass_kg": 1.605, "natural_frequency_hz": 2.5, "damping_ratio": 0.0038, "restitution": 0.47}
    given |= {"particle_mass_kg": 0.1605, "particle_friction_coefficient": 0.05, **at}
    one_case = {"record": "northridge-360", "scale": 1.5, "cases": ["hybrid"], "starts": 0, **given}
    case = client.post("/api/v1/earthquake-comparisons?samples=6000", json=one_case).json()
    x = [1000 * value for value in case["histories"]["hybrid"]["relative_displacement_m"]]
    drawn = until(page, TRACES, lambda traces: len(traces) == 2 and len(traces[1]["y"]) == len(x), DRIFT)
    assert drawn[1]["y"] == pytest.approx(x, rel=1e-12)
    lost = case["cases"]["hybrid"]["loss_impact_j"]
    expect(motion.locator("dd").nth(3)).to_contain_text(f"{lost:.4g} J")
    assert until(page, TRACES, lambda traces: len(traces) == 2, "Spectrum of the drift")

    # the map, the curves over the scale, the fragility and the motion each have a line of their own
    assert len(run_the_lines_of_python(page)) == 4

    # the address holds it all: the damper, the limit and the case
    other_page = open_page(viewport={"width": 390, "height": 900}).go(f"#{page.url.partition('#')[2]}")
    limit_there = other_page.get_by_role("region", name="The damper").get_by_role("spinbutton")
    expect(limit_there).to_have_value(str(limit))
    until(other_page, TRACES, lambda traces: traces == drawn, DRIFT)

    panel.get_by_text("All cases as a table").click()
    expect(panel.get_by_role("row")).to_have_count(3)
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
    assert serious(page) == []
    pick(page, "Shown", "status")
    expect(page.locator(".designs tbody tr")).to_have_count(0)
    tabs.nth(2).click()
    expect(page.get_by_role("region", name="Definition as JSON")).to_contain_text("northridge-360")
