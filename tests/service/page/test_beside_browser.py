"""A study beside another one, in a real browser before a real service: what is drawn is what the cubes hold."""

from collections.abc import Callable
from typing import Any

import httpx
import numpy as np
import pytest
from playwright.sync_api import expect
from tests.service.page.looking import one_step, serious, until

pytestmark = pytest.mark.night

DRAWN = """() => [...document.querySelectorAll(".beside-study .plot")].map((plot) => {
  const map = plot.data?.find((one) => one.type === "heatmap");
  if (!map) return null;
  return { values: map.customdata, y: [...map.y], low: map.zmin, high: map.zmax, bar: map.colorbar.title.text };
})"""
PHYSICAL = {"mass_kg": 1.605, "natural_frequency_hz": 2.5, "base_amplitude_m": 0.0015}


@pytest.fixture
def pair(client: httpx.Client, helpers: Any) -> list[dict[str, Any]]:
    """Two structures of different damping in units, a third on another grid, and their records."""

    def study(name: str, damping: float, friction: list[float]) -> dict[str, Any]:
        axes = {"friction_ratio": friction, "frequency_ratio": {"start": 0.5, "stop": 1.5, "num": 11}}
        document = {
            "name": name,
            "particle": False,
            "damping_ratio": damping,
            "axes": axes,
            "physical": PHYSICAL,
        }
        record = client.post("/api/v1/studies", json=document).raise_for_status().json()
        finished: dict[str, Any] = helpers.wait_for(client, record["id"], helpers.ended)
        return finished

    return [study("light", 0.0038, [0, 2]), study("damped", 0.05, [0, 2]), study("three", 0.05, [0, 1, 2])]


def cube(client: httpx.Client, study: str) -> np.ndarray:
    """X [mm] over friction and frequency, from the exported table."""
    rows = client.get(f"/api/v1/studies/{study}/export", params={"format": "csv"}).text.splitlines()
    place = rows[0].split(",").index("amplitude_m")
    return 1000 * np.array([float(row.split(",")[place]) for row in rows[1:]]).reshape(-1, 11)


@pytest.mark.parametrize(("width", "scheme"), [(390, "dark"), (1440, "light")])
def test_two_studies_in_units_are_shown_on_one_scale_with_the_difference_of_their_cubes(
    open_page: Callable[..., Any], client: httpx.Client, pair: list[dict[str, Any]], width: int, scheme: str
) -> None:
    light, damped, _ = (record["id"] for record in pair)
    watched = open_page(viewport={"width": width, "height": 900}, color_scheme=scheme)
    page = watched.go(f"#/studies/{light}/map")
    page.get_by_role("link", name="Beside another").click()
    expect(page.get_by_role("status").filter(has_text="Choose a study")).to_be_visible()
    page.get_by_label("Beside").select_option(damped)
    first, second, apart = until(page, DRAWN, lambda drawn: len(drawn) == 3 and all(drawn))
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
    expect(note).to_contain_text("differ in structural damping ratio ζ (0.0038 and 0.05)")
    expect(note).to_contain_text(f"at most {(ours - theirs).max():.4g} mm at F_f = 0 N and f = 2.5 Hz")
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    assert serious(page, (scheme,)) == []

    one_step(page, lambda: page.get_by_label("Shown").select_option("amplitude_ratio_max"))
    until(
        page,
        DRAWN,
        lambda drawn: len(drawn) == 3 and all(one and "largest amplitude" in one["bar"] for one in drawn),
    )
    other = open_page(viewport={"width": width, "height": 900}).go(f"#{page.url.partition('#')[2]}")
    until(
        other,
        DRAWN,
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
    expect(box).to_contain_text("the second 3 values")
    expect(page.locator(".beside-study .sides")).to_be_hidden()
