"""The Explore tab in a real browser: every number on it is the service's, and what is chosen in one view moves the others."""

from collections.abc import Callable
from typing import Any

import httpx
import pytest
from playwright.sync_api import expect
from tests.service.page.looking import until

pytestmark = pytest.mark.night

DRAWN = "() => [...document.querySelectorAll('.plot')].map((plot) => plot.data?.map((one) => one.y) ?? [])"


def test_slices_designs_importance_and_pins_are_views_of_one_point(
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

    matters = client.get(f"{study}/importance").json()
    rows = page.get_by_role("region", name="Importance of each parameter").locator("tbody tr")
    expect(rows).to_have_count(3)
    for row, share in enumerate([*matters["share"], matters["interactions"]]):
        text = rows.nth(row).locator("td").first.inner_text()
        assert float(text.removesuffix(" %")) == pytest.approx(100 * share, rel=0.05)

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
