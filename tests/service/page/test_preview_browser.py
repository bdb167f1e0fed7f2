"""The map of a large study after seconds: its coarse grid, shown as the preview that it is."""

import re
from collections.abc import Callable
from typing import Any

import httpx
import pytest
from playwright.sync_api import expect
from tests.service.page.looking import serious, until

pytestmark = pytest.mark.night

DRAWN = """() => {
  const plots = [...document.querySelectorAll('.plot')];
  const map = plots.find((one) => one.getAttribute('aria-label').startsWith('Resonance map'))?.data ?? [];
  return map.filter((one) => one.type === 'heatmap').map((one) => ({ opacity: one.opacity ?? 1, values: one.customdata }));
}"""
LARGE = {
    "name": "takes minutes",
    "damping_ratio": 0.0113,
    "axes": {
        "clearance_ratio": {"start": 0.5, "stop": 20, "num": 80},
        "friction_ratio": {"start": 0.0, "stop": 0.7, "num": 50},
        "frequency_ratio": {"start": 0.9, "stop": 1.1, "num": 50},
        "restitution": 0.47,
        "mass_ratio": 0.1,
    },
}


def test_a_large_study_has_a_map_before_its_first_tenth_is_computed(
    open_page: Callable[..., Any], client: httpx.Client, helpers: Any
) -> None:
    estimate = client.post("/api/v1/studies?dry_run=true", json=LARGE).raise_for_status().json()
    assert estimate["seconds"] > 60
    study_id = client.post("/api/v1/studies", json=LARGE).raise_for_status().json()["id"]
    page = open_page().go(f"#/studies/{study_id}/map")
    try:
        # all of the coarse grid is computed before the first block of the study is
        record = helpers.wait_for(client, study_id, lambda record: record["points_done"] > 0)
        assert record["points_done"] < 0.1 * record["points_total"]
        beneath, above = until(page, DRAWN, lambda traces: len(traces) == 2)
        asked = {"x": "clearance_ratio", "y": "friction_ratio"}
        answer = (
            client.get(f"/api/v1/studies/{study_id}/resonance-map", params=asked).raise_for_status().json()
        )
        preview = answer["preview"]
        assert preview["complete"] == 1.0
        its_own = client.get(f"/api/v1/studies/{preview['study']}/resonance-map", params=asked).json()
        assert "preview" not in its_own
        assert [preview[key] for key in ("x", "y", "values")] == [
            its_own[key] for key in ("x", "y", "values")
        ]
        assert set(preview["x"]) < set(answer["x"])
        assert beneath["opacity"] < above["opacity"] == 1
        assert beneath["values"] == preview["values"]
        expect(page.locator(".note").first).to_contain_text(
            re.compile(r"paler rest is a preview: a coarse grid of \d+ × \d+")
        )
        assert serious(page, ("light",)) == []
        # its own record, and no card beside that of its study
        assert client.get(f"/api/v1/studies/{preview['study']}").raise_for_status().json()["state"] == "done"
        named = {"name": LARGE["name"]}
        listed = client.get("/api/v1/studies", params=named).json()["studies"]
        assert [one["id"] for one in listed] == [study_id]
        listed = client.get("/api/v1/studies", params=named | {"coarse": True}).json()["studies"]
        assert {one["id"] for one in listed} == {study_id, preview["study"]}
        # the coarse grid deleted, the study shows what it has itself
        client.delete(f"/api/v1/studies/{preview['study']}").raise_for_status()
        again = client.get(f"/api/v1/studies/{study_id}/resonance-map", params=asked).json()
        assert again["complete"] < 1
        assert "preview" not in again
    finally:
        client.post(f"/api/v1/studies/{study_id}/cancel").raise_for_status()
        helpers.wait_for(client, study_id, helpers.ended)
