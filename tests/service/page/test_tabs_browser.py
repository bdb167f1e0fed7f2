"""Tabs of a study in a real browser: every number on them is the service's, and what is chosen in one view moves the others."""

from collections.abc import Callable
from typing import Any

import httpx
import numpy as np
import pytest
from playwright.sync_api import expect
from tests.service.conftest import computed
from tests.service.page.looking import TRACES, one_step, run_the_lines_of_python, serious, until

pytestmark = pytest.mark.night

DRAWN = "() => [...document.querySelectorAll('.plot')].map((plot) => plot.data?.map((one) => one.y) ?? [])"


def test_slices_designs_and_pins_are_views_of_one_point(
    open_page: Callable[..., Any], client: httpx.Client, small_map: dict[str, Any]
) -> None:
    study = f"/api/v1/studies/{small_map['id']}"
    page = open_page().go(f"#/studies/{small_map['id']}/explore?clearance_ratio=10&friction_ratio=0.4")
    slices = until(page, DRAWN, lambda drawn: len(drawn) >= 4 and all(drawn))
    asked = {"x": "clearance_ratio", "y": "damping_ratio", "friction_ratio": 0.4}
    worst = client.get(f"{study}/resonance-map", params=asked).json()["values"][0]
    assert slices[0] == [worst, [worst[1]]]
    curve = client.get(
        f"{study}/frequency-response", params={"clearance_ratio": 10, "friction_ratio": 0.4}
    ).json()["values"]
    assert slices[2] == [curve]
    assert slices[3] == [curve]

    ranked = client.get(f"{study}/optimal-designs", params={"top": 2000}).json()["designs"]
    panel = page.locator("section").filter(has=page.get_by_role("heading", name="All designs"))
    said = panel.locator("p[role=status]")
    expect(said).to_contain_text(f"{len(ranked)} of {len(ranked)} designs")
    panel.get_by_text("Limit the axes by sliders").click()
    least = panel.get_by_label("d/Z, at least")
    least.focus()
    page.keyboard.press("End")
    inside = [one for one in ranked if one["clearance_ratio"] == 15]
    expect(said).to_contain_text(f"{len(inside)} of {len(ranked)} designs")
    page.reload()  # the brush is in the address
    expect(said).to_contain_text(f"{len(inside)} of {len(ranked)} designs")
    struck = [one for one in inside if one["impact_share"] > 0]
    best = struck[0] if struck and inside[0]["impact_share"] == 0 else inside[0]

    page.get_by_role("button", name="Pin this point").click()
    page.get_by_role("button", name="Go to the best of them").click()
    expect(page.get_by_label("Clearance ratio of the point")).to_have_attribute("aria-valuetext", "15")
    at = {name: best[name] for name in ("clearance_ratio", "friction_ratio")}
    moved = client.get(f"{study}/frequency-response", params=at).json()["values"]
    until(page, DRAWN, lambda drawn: drawn[3:4] == [[moved, curve]])
    assert "pins=" in page.url
    fast = panel.get_by_label("Impact speed at most")
    fast.fill("0")
    speed = {"top": 2000, "max_impact_speed": 0}
    slow = client.get(f"{study}/optimal-designs", params=speed).json()["designs"]
    expect(said).to_contain_text(f"of {len(slow)} designs" if slow else "No design is left.")


def test_the_exact_curves_are_drawn_where_the_service_has_them(
    open_page: Callable[..., Any], client: httpx.Client, small_map: dict[str, Any]
) -> None:
    at = "clearance_ratio=10&friction_ratio=0.4"
    page = open_page().go(f"#/studies/{small_map['id']}/tmd?{at}")
    expect(page.locator("#tmd-ratio")).to_be_visible()
    traces = (
        "() => document.querySelector('.plot')?.data?.map(({ name, x, y }) => [name, [...x], [...y]]) ?? []"
    )
    drawn = {name: (x, y) for name, x, y in until(page, traces, lambda found: len(found) == 3)}
    answer = client.get(f"/api/v1/studies/{small_map['id']}/tmd-comparison?{at}").json()
    exact = answer["exact"]
    assert drawn["this study"][0] == answer["frequency_ratio"]
    assert len(exact["frequency_ratio"]) > 5 * len(answer["frequency_ratio"])
    for title, name in (("tuned mass damper", "tmd"), ("no damper", "no_damper")):
        assert drawn[title] == (exact["frequency_ratio"], exact[name])


DRIFT = "Displacement against the base over time"
SPECTRUM = "Spectrum of the displacement against the base"


def test_the_motion_under_an_earthquake_is_drawn_and_sensitivity_explained_where_there_is_some(
    open_page: Callable[..., Any], client: httpx.Client, small_map: dict[str, Any]
) -> None:
    watched = open_page()
    page = watched.go(f"#/studies/{small_map['id']}/earthquake?clearance_ratio=10&friction_ratio=0.4")
    drawn = until(page, TRACES, lambda traces: len(traces) == 3, DRIFT)
    assert [trace["name"] for trace in drawn] == ["no damper", "tuned mass damper", "particle and friction"]
    *_, asked = (
        one.post_data_json
        for one in watched.requests
        if "earthquake-comparisons?samples" in one.url and "dry_run" not in one.url
    )
    found = client.post("/api/v1/earthquake-comparisons", json=asked, params={"samples": 6000}).json()
    for trace, name in zip(drawn, ("none", "tmd", "hybrid"), strict=True):
        history = found["histories"][name]
        assert trace["x"] == history["time_s"]
        assert trace["y"] == pytest.approx([1000 * value for value in history["relative_displacement_m"]])
    lines = until(page, TRACES, lambda traces: len(traces) == 3, SPECTRUM)
    _, peak = max(zip(lines[0]["y"], lines[0]["x"], strict=True))
    assert peak == pytest.approx(asked["natural_frequency_hz"], rel=0.02)  # no damper rings at its own
    assert len(run_the_lines_of_python(page)) == 1  # all three figures are of one comparison

    page.get_by_text("Figures of the record").click()
    record = client.get(f"/api/v1/records/{asked['record']}").raise_for_status().json()
    (motion,) = until(page, TRACES, bool, "Acceleration of the base over time")
    assert motion["x"] == record["time_s"]
    assert max(map(abs, motion["y"])) == pytest.approx(record["peak_acceleration_g"])
    (shown,) = until(page, TRACES, bool, "Response spectrum of the record")
    assert shown["y"] == pytest.approx([value / 9.80665 for value in record["pseudo_acceleration_m_s2"]])
    rows = page.get_by_role("region", name="Comparison under the record")
    expect(rows).to_contain_text("particle and friction")
    sensitive = ", sensitive" in rows.inner_text()
    assert ("Sensitive:" in page.locator(".left .note").inner_text()) == sensitive
    assert serious(page) == []


DRAWN_BESIDE = """() => [...document.querySelectorAll(".beside-study .plot")].map((plot) => {
  const map = plot.data?.find((one) => one.type === "heatmap");
  if (!map) return null;
  return { values: map.customdata, y: [...map.y], low: map.zmin, high: map.zmax, bar: map.colorbar.title.text };
})"""
PHYSICAL = {"mass_kg": 1.605, "natural_frequency_hz": 2.5, "base_amplitude_m": 0.0015}


@pytest.fixture
def pair(service: Any) -> list[dict[str, Any]]:
    """Two structures of different damping in units, a third on another grid, and their records."""

    def study(name: str, damping: float, friction: list[float]) -> dict[str, Any]:
        axes = {"friction_ratio": friction, "frequency_ratio": {"start": 0.5, "stop": 1.5, "num": 11}}
        document = {"name": name, "particle": False, "damping_ratio": damping, "axes": axes}
        return computed(service, document | {"physical": PHYSICAL})

    return [study("light", 0.0038, [0, 2]), study("damped", 0.05, [0, 2]), study("three", 0.05, [0, 1, 2])]


def cube(client: httpx.Client, study: str) -> np.ndarray:
    """X [mm] over friction and frequency, from the exported table."""
    rows = client.get(f"/api/v1/studies/{study}/export", params={"format": "csv"}).text.splitlines()
    place = rows[0].split(",").index("amplitude_m")
    return 1000 * np.array([float(row.split(",")[place]) for row in rows[1:]]).reshape(-1, 11)


def test_two_studies_in_units_are_shown_on_one_scale_with_the_difference_of_their_cubes(
    open_page: Callable[..., Any], client: httpx.Client, pair: list[dict[str, Any]]
) -> None:
    light, damped, _ = (record["id"] for record in pair)
    page = open_page(viewport={"width": 390, "height": 900}, color_scheme="dark").go(f"#/studies/{light}/map")
    page.get_by_role("link", name="Compare").click()
    expect(page.get_by_role("status").filter(has_text="Choose a study")).to_be_visible()
    page.get_by_label("Beside").select_option(damped)
    first, second, apart = until(page, DRAWN_BESIDE, lambda drawn: len(drawn) == 3 and all(drawn))
    ours, theirs = cube(client, light), cube(client, damped)
    for drawn, expected in ((first, ours), (second, theirs), (apart, ours - theirs)):
        # friction is shown across, frequency up
        np.testing.assert_allclose(np.array(drawn["values"]), expected.T, rtol=1e-9, atol=1e-12)
        assert drawn["y"] == pytest.approx([2.5 * r for r in np.linspace(0.5, 1.5, 11)])
        assert "amplitude X [mm]" in drawn["bar"]
    both = np.log10([min(ours.min(), theirs.min()), max(ours.max(), theirs.max())])
    assert [first["low"], first["high"]] == [second["low"], second["high"]] == pytest.approx(list(both))
    assert apart["high"] == -apart["low"] == pytest.approx(np.abs(ours - theirs).max())
    note = page.locator(".beside-study p[role=status]")
    expect(note).to_contain_text("ζ (0.0038 and 0.05)")
    expect(note).to_contain_text(f"{(ours - theirs).max():.4g} mm (F_f = 0 N and f = 2.5 Hz)")
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
    assert serious(page, ("dark",)) == []
    one_step(page, lambda: page.get_by_label("Shown").select_option("amplitude_ratio_max"))
    until(
        page,
        DRAWN_BESIDE,
        lambda drawn: len(drawn) == 3 and all(one and "largest amplitude" in one["bar"] for one in drawn),
    )
    page.go_back()
    expect(page.get_by_label("Shown")).not_to_have_value("amplitude_ratio_max")


def test_a_study_on_another_grid_is_refused_with_what_differs(
    open_page: Callable[..., Any], pair: list[dict[str, Any]]
) -> None:
    light, _, three = (record["id"] for record in pair)
    watched = open_page()
    watched.allowed = ("422 (Unprocessable",)
    page = watched.go(f"#/studies/{light}/beside?minus={three}")
    box = page.locator(".beside-study .fault")
    expect(box).to_contain_text("2 values from 0 to")
    expect(box).to_contain_text("3 values from 0 to")
    expect(page.locator(".beside-study .sides")).to_be_hidden()
