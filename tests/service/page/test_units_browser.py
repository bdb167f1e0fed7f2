"""A hybrid damper in units on every view of the page: no text and no figure has a ratio that stands for a quantity."""

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import httpx
import pytest
from tests.service.page.looking import until

STUDY: dict[str, Any] = {
    "name": "damper in units",
    "damping_ratio": 0.02,
    "physical": {
        "mass_kg": 1.605, "natural_frequency_hz": 2.5, "base_amplitude_m": 0.0015, "particle_mass_kg": 0.1605,
        "clearance_m": [0.006, 0.012], "friction_force_n": [0.06, 0.12], "excitation_frequency_hz": [2.25, 2.5, 2.75],
    },
    "axes": {"restitution": 0.47},
}  # fmt: skip
RATIO = re.compile(
    r".{0,40}(?:\bd/Z|γ_F|X/Z|Z·ω|\br = |/ Z\b|(?<!\w)β|\w+(?<!damping)_ratio(?:_at| = )|amplitude ratio).{0,20}"
)
VIEWS = ("map", "explore", "tmd", "earthquake", "beside", "data")
SHOWN = "() => document.querySelector('main').innerText"
QUIET = "() => document.querySelectorAll('.plot:empty').length"


def test_no_view_of_a_study_in_units_has_a_ratio(
    open_page: Callable[..., Any], client: httpx.Client, helpers: Any
) -> None:
    other = STUDY | {"name": "the other", "axes": {"restitution": 0.3}}
    first, second = (
        client.post("/api/v1/studies", json=each).raise_for_status().json()["id"] for each in (STUDY, other)
    )
    for study in (first, second):
        helpers.wait_for(client, study, helpers.ended)
    point = f"clearance_ratio=4&friction_ratio=0.1&pins=0.0&minus={second}&pareto=impact_speed"
    watched = open_page()
    found = {}
    for view in VIEWS:
        page = watched.go(f"#/studies/{first}/{view}?{point}")
        until(page, SHOWN, lambda text: "damper in units" in text and "Computing" not in text)
        if view != "earthquake":
            until(page, QUIET, lambda empty: empty == 0)
        text = page.evaluate(SHOWN)
        if view == "data":  # the definition and the names of files are what was submitted
            text = text.partition("Definition")[0]
        found[view] = RATIO.findall(text)
    assert found == {view: [] for view in VIEWS}


@pytest.mark.night
def test_a_map_as_a_table_is_in_units_and_its_axes_are_without_what_conversion_leaves(
    open_page: Callable[..., Any], client: httpx.Client, helpers: Any
) -> None:
    # there and back, 9 mm over a base of 1.5 mm are 8.999999999999998 mm
    physical = STUDY["physical"] | {"clearance_m": [0.003, 0.006, 0.009], "friction_force_n": [0.05, 0.11]}
    metrics = ["amplitude_ratio", "acceleration_ratio", "acceleration_ratio_rms"]
    study = STUDY | {"name": "felt", "physical": physical, "metrics": metrics}
    record = client.post("/api/v1/studies", json=study).raise_for_status().json()
    helpers.wait_for(client, record["id"], helpers.ended)
    asked = {"x": "clearance_m", "y": "friction_force_n", "metric": "acceleration_m_per_s2"}
    address = f"/api/v1/studies/{record['id']}/resonance-map"
    answer = client.get(address, params=asked).raise_for_status().json()
    page = open_page().go(f"#/studies/{record['id']}?metric=acceleration_ratio")
    until(page, QUIET, lambda empty: empty == 0)
    with page.expect_download() as download:
        page.get_by_role("button", name="Download as CSV: Resonance map of felt").click()
    head, *rows = Path(download.value.path()).read_text().splitlines()
    assert head == "Clearance d [mm],Friction force F_f [N],acceleration of the structure [m/s²]"
    places = [",".join(row.split(",")[:2]) for row in rows]
    assert places == ["3,0.05", "6,0.05", "9,0.05", "3,0.11", "6,0.11", "9,0.11"]
    # the page multiplies in another order
    shown = [float(row.split(",")[2]) for row in rows]
    assert shown == pytest.approx([value for row in answer["values"] for value in row], rel=1e-9)
