"""A ground-motion suite on the page: from the form to a fragility curve, in a real browser before a real service."""

import json
import math
import re
from collections.abc import Callable
from typing import Any

import httpx
import numpy as np
import pytest
from playwright.sync_api import expect
from tests.service.page.looking import KNOWN_POINTS, TRACES, run_the_lines_of_python, serious, until

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


def spectrum_of(history: dict[str, Any], highest: float) -> list[float]:
    """Amplitudes of the drift [mm] over multiples of one over its length, by numpy's transform."""
    time, x = np.array(history["time_s"]), 1000 * np.array(history["relative_displacement_m"])
    span = time[-1] - time[0]
    count = min(8192, max(256, math.ceil(4 * highest * span)))
    even = np.interp(time[0] + span * np.arange(count) / count, time, x)
    lines = 2 * np.abs(np.fft.rfft(even)) / count
    return list(lines[1 : int(highest * span) + 1])


@pytest.mark.parametrize(("width", "scheme"), [(390, "light"), (1440, "dark")])
def test_a_survey_from_the_form_to_a_fragility_curve(
    open_page: Callable[..., Any], client: httpx.Client, width: int, scheme: str
) -> None:
    scales = [0.5, 1, 1.5, 2 if width == 390 else 2.5]  # each its own study
    other = {"light": "dark", "dark": "light"}[scheme]
    watched = open_page(viewport={"width": width, "height": 900}, color_scheme=scheme)
    watched.allowed = ("422 (Unprocessable",)  # a survey without records is refused
    page = watched.go("#/new")
    page.get_by_label("Start from").select_option("ground-motion suite")
    boxes = page.get_by_role("group", name="Records").get_by_role("checkbox")
    expect(boxes.first).to_be_attached()
    assert boxes.count() >= len(builtin_ids())
    for box in boxes.all():
        box.set_checked(False)
    expect(page.locator("[data-field=records] .faults").last).to_contain_text("records")
    assert serious(page, (scheme, other)) == []
    for name in ("El Centro 1940, array 9, 180", "Northridge 1994, aftershock of 18 January, Sylmar, 360"):
        page.get_by_role("group", name="Records").get_by_label(name).check()
    page.get_by_label("Name").fill(f"survey at {width}")
    clearance = page.get_by_role("group", name="Clearance d")
    clearance.get_by_label("how it is given").select_option("list")
    clearance.get_by_label("values, separated").fill("5, 20")
    page.get_by_role("group", name="Friction force").get_by_label("values, separated").fill("0.2, 0.8, 3")
    scale = page.get_by_role("group", name="Factor on the records")
    scale.get_by_label("how it is given").select_option("list")
    scale.get_by_label("values, separated").fill(", ".join(map(str, scales)))
    cavity = {"particle_friction_coefficient": 0.05} if width == 390 else {}
    if cavity:
        page.get_by_text("Cavity, contact").click()
        page.get_by_label("Coefficient μ_i").fill("0.05")
    asked = json.loads(page.locator("textarea").input_value())
    assert {name: asked[name] for name in cavity} == cavity
    assert asked["axes"]["clearance_m"] == [0.005, 0.02]
    assert sorted(asked["records"]) == ["el-centro-180", "northridge-360"]
    assert "clearance_ratio" not in asked["axes"]
    expect(page.locator(".estimate")).to_contain_text("48")
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    page.get_by_role("button", name="Run the study").click()

    expect(page.locator(".head .badge")).to_contain_text("done", timeout=1_800_000)
    until(page, KNOWN_POINTS, lambda known: known == 6)
    study = re.search(r"#/studies/(\w+)", page.url).group(1)  # type: ignore[union-attr]
    page.locator(".plot").first.scroll_into_view_if_needed()
    page.mouse.click(*page.evaluate(PLACE_OF_CELL, [20, 0.8]))
    panel = page.get_by_role("region", name="The damper")
    expect(panel.get_by_role("heading", level=2)).to_contain_text("clearance 20 mm, friction force 0.8 N")
    at = {"clearance_m": 0.02, "friction_force_n": 0.8}
    assert "clearance_m=0.02" in page.url

    # every record over the scale, as the service has it, in millimetres
    told = {"x": "scale", "y": "damping_ratio", **at}
    asked_for = {
        record: client.get(f"/api/v1/studies/{study}/resonance-map", params={**told, "record": record}).json()
        for record in ("el-centro-180", "northridge-360")
    }
    expected = {
        record: pytest.approx([1000 * value for value in answer["values"][0]], rel=1e-12)
        for record, answer in asked_for.items()
    }
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
    case = client.post(
        "/api/v1/earthquake-comparisons",
        json={
            "record": "northridge-360", "scale": 1.5, "cases": ["hybrid"], "starts": 0, "mass_kg": 1.605,
            "natural_frequency_hz": 2.5, "damping_ratio": 0.0038, "restitution": 0.47, "particle_mass_kg": 0.1605,
            **at, **cavity,
        },
        params={"samples": 6000},
    ).json()  # fmt: skip
    x = [1000 * value for value in case["histories"]["hybrid"]["relative_displacement_m"]]
    drawn = until(page, TRACES, lambda traces: len(traces) == 2 and len(traces[1]["y"]) == len(x), DRIFT)
    assert drawn[1]["y"] == pytest.approx(x, rel=1e-12)
    lost = case["cases"]["hybrid"]["loss_impact_j"]
    expect(motion.locator("dd").nth(3)).to_contain_text(f"{lost:.4g} J")
    spectrum = until(page, TRACES, lambda traces: len(traces) == 2, "Spectrum of the drift")
    assert spectrum[1]["y"] == pytest.approx(
        spectrum_of(case["histories"]["hybrid"], 10.0), rel=1e-6, abs=1e-9
    )

    # the map, the curves over the scale, the fragility and the motion each have a line of their own
    assert run_the_lines_of_python(page) == 4

    # the address holds it all: the damper, the limit and the case
    other_page = open_page(viewport={"width": width, "height": 900}).go(f"#{page.url.partition('#')[2]}")
    expect(other_page.get_by_role("region", name="The damper").get_by_role("spinbutton")).to_have_value(
        str(limit)
    )
    until(other_page, TRACES, lambda traces: traces == drawn, DRIFT)

    panel.get_by_text("All cases as a table").click()
    expect(panel.get_by_role("row")).to_have_count(3)
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    assert serious(page, (scheme, other)) == []
