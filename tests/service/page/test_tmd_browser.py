"""A study's damper beside a tuned mass damper: what has a closed form is drawn between the study's frequencies too."""

from collections.abc import Callable
from typing import Any

import httpx
import pytest
from playwright.sync_api import expect
from tests.service.page.looking import until

pytestmark = pytest.mark.night

TRACES = """() => document.querySelector(".plot")?.data
  ?.map(({ name, x, y }) => ({ name, x: [...x], y: [...y] })) ?? []"""


def test_the_exact_curves_are_drawn_where_the_service_has_them(
    open_page: Callable[..., Any], client: httpx.Client, small_map: dict[str, Any]
) -> None:
    chosen = {"clearance_ratio": 10, "friction_ratio": 0.4}
    at = "&".join(f"{name}={value}" for name, value in chosen.items())
    page = open_page().go(f"#/studies/{small_map['id']}/tmd?{at}")
    expect(page.locator("#tmd-ratio")).to_be_visible()
    drawn = {trace["name"]: trace for trace in until(page, TRACES, lambda traces: len(traces) == 3)}
    answer = client.get(f"/api/v1/studies/{small_map['id']}/tmd-comparison", params=chosen).json()
    exact = answer["exact"]
    assert drawn["this study"]["x"] == answer["frequency_ratio"]
    for title, name in (("tuned mass damper", "tmd"), ("no damper", "no_damper")):
        assert drawn[title]["x"] == exact["frequency_ratio"]
        assert drawn[title]["y"] == exact[name]
    assert len(exact["frequency_ratio"]) > 5 * len(answer["frequency_ratio"])
    # two formulas: a hundred roundings of 1e-16 each, and the curve's loses a digit and a half in 1 − λ²
    assert max(drawn["tuned mass damper"]["y"]) == pytest.approx(answer["tmd_peak"], rel=1e-12)
