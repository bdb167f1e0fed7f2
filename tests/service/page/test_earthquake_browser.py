"""Dampers of a study under an earthquake: their motion is the service's, and no word is explained that is not used."""

from collections.abc import Callable
from typing import Any

import httpx
import pytest
from playwright.sync_api import expect
from tests.service.page.looking import run_the_lines_of_python, serious, until

pytestmark = pytest.mark.night

TRACES = """(label) => [...document.querySelectorAll(".plot")]
  .find((plot) => plot.getAttribute("aria-label") === label)
  ?.data?.map(({ name, x, y }) => ({ name, x: [...x], y: [...y] })) ?? []"""
DRIFT = "Displacement against the base over time"
SPECTRUM = "Spectrum of the displacement against the base"


def test_the_motion_under_an_earthquake_is_drawn_and_sensitivity_explained_where_there_is_some(
    open_page: Callable[..., Any], client: httpx.Client, small_map: dict[str, Any]
) -> None:
    watched = open_page()
    page = watched.go(f"#/studies/{small_map['id']}/earthquake?clearance_ratio=10&friction_ratio=0.4")
    drawn = until(page, TRACES, lambda traces: len(traces) == 3, DRIFT)
    assert [trace["name"] for trace in drawn] == ["no damper", "tuned mass damper", "particle and friction"]
    asked = [
        one.post_data_json
        for one in watched.requests
        if "earthquake-comparisons?samples" in one.url and "dry_run" not in one.url
    ][-1]
    found = client.post("/api/v1/earthquake-comparisons", json=asked, params={"samples": 6000}).json()
    for trace, name in zip(drawn, ("none", "tmd", "hybrid"), strict=True):
        history = found["histories"][name]
        assert trace["x"] == history["time_s"]
        assert trace["y"] == pytest.approx([1000 * value for value in history["relative_displacement_m"]])
    lines = until(page, TRACES, lambda traces: len(traces) == 3, SPECTRUM)
    peak = max(zip(lines[0]["y"], lines[0]["x"], strict=True))
    assert peak[1] == pytest.approx(asked["natural_frequency_hz"], rel=0.02)  # no damper rings at its own

    assert run_the_lines_of_python(page) == 1  # all three figures are of one comparison

    page.get_by_text("What the record looks like").click()
    record = client.get(f"/api/v1/records/{asked['record']}").raise_for_status().json()
    (motion,) = until(page, TRACES, bool, "Acceleration of the base over time")
    assert motion["x"] == record["time_s"]
    assert max(map(abs, motion["y"])) == pytest.approx(record["peak_acceleration_g"])
    (shown,) = until(page, TRACES, bool, "Response spectrum of the record")
    assert shown["y"] == pytest.approx([value / 9.80665 for value in record["pseudo_acceleration_m_s2"]])

    rows = page.get_by_role("region", name="Comparison under the record")
    note = page.locator(".left .note")
    expect(rows).to_contain_text("particle and friction")
    sensitive = ", sensitive" in rows.inner_text()
    assert ("Sensitive:" in note.inner_text()) == sensitive
    assert serious(page) == []
