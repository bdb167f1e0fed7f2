"""The address of a survey's view: opened elsewhere it shows the same, and Back goes one step back."""

from collections.abc import Callable
from typing import Any

import httpx
import pytest
from playwright.sync_api import Page, expect
from tests.service.page.looking import one_step, until

pytestmark = pytest.mark.night

SURVEY: dict[str, Any] = {
    "name": "survey of two",
    "records": ["el-centro-180", "northridge-360"],
    "mass_kg": 1.605,
    "axes": {
        "natural_frequency_hz": 2.5,
        "damping_ratio": 0.0038,
        "scale": [0.5, 1, 1.5],
        "restitution": 0.47,
        "particle_mass_kg": 0.1605,
        "clearance_m": [0.005, 0.01, 0.02],
        "friction_force_n": [0.2, 0.8],
    },
}
SHOWN = """() => ({
  pickers: [...document.querySelectorAll(".controls select")].map((one) => one.value),
  limit: document.querySelector(".survey input")?.value,
  map: document.querySelector(".plot")?.data?.[0]?.customdata,
})"""


def pick(page: Page, label: str, value: str) -> None:
    field = page.locator("label.field").filter(has=page.get_by_text(label, exact=True))
    one_step(page, lambda: field.locator("select").select_option(value))


def test_an_address_of_a_survey_holds_axes_measure_limit_and_case_and_back_goes_one_step_back(
    open_page: Callable[..., Any], client: httpx.Client, helpers: Any
) -> None:
    record = client.post("/api/v1/studies", json=SURVEY).raise_for_status().json()
    helpers.wait_for(client, record["id"], helpers.ended)
    page = open_page().go(f"#/studies/{record['id']}")
    until(page, SHOWN, lambda shown: shown["map"] and shown["limit"])
    ticks = "() => [...document.querySelector('.plot').querySelectorAll('.xtick text')].map((one) => one.textContent)"
    assert page.evaluate(ticks) == ["5", "10", "20"]  # an octave each: on a logarithmic axis
    pick(page, "Up", "scale")
    pick(page, "Shown", "peak_absolute_acceleration_m_s2")
    pick(page, "Record", "northridge-360")
    until(page, SHOWN, lambda shown: shown["limit"])
    one_step(page, lambda: page.locator(".survey input").fill("7.5"))
    pick(page, "Motion under", "northridge-360")
    pick(page, "times", "0.5")
    expected = page.evaluate(SHOWN)
    assert {"scale", "peak_absolute_acceleration_m_s2", "northridge-360", "0.5"} <= set(expected["pickers"])
    assert expected["limit"] == "7.5"

    other = open_page().go(f"#{page.url.partition('#')[2]}")
    until(other, SHOWN, lambda shown: shown == expected)
    expect(other.locator(".survey p[role=status]")).to_contain_text("7.5")

    def went_back(shown: Any) -> bool:
        return "0.5" not in shown["pickers"] and "northridge-360" in shown["pickers"]

    page.go_back()
    until(page, SHOWN, went_back)
    for _ in range(3):  # the motion, the limit, the case
        page.go_back()
    until(page, SHOWN, lambda shown: shown["limit"] not in ("", "7.5"))
    page.go_back()
    until(page, SHOWN, lambda shown: shown["pickers"][1:4:2] == ["scale", ""])
    page.go_back()
    until(page, SHOWN, lambda shown: shown["pickers"][2:3] == ["peak_relative_displacement_m"])
    # another measure has another limit, so none is kept for it
    forward = open_page().go(f"#{other.url.partition('#')[2]}")
    until(forward, SHOWN, lambda shown: shown == expected)
    pick(forward, "Shown", "peak_relative_displacement_m")
    assert "limit=" not in forward.url
