"""Designs on the page, in a real browser: asked for in a form, followed, answered in drawing values."""

import json
import re
from collections.abc import Callable
from typing import Any

import httpx
import pytest
from playwright.sync_api import expect
from tests.service.conftest import SPECIFICATION, ended, wait_for_design
from tests.service.page.looking import serious

pytestmark = pytest.mark.night


def form_of(open_page: Callable[..., Any], document: dict[str, Any]) -> tuple[Any, Callable[[], Any]]:
    """Open the form of a specification; with what it comes to."""
    watched = open_page()
    watched.allowed = ("422",)
    page = watched.go("#/designs/new")
    text = page.get_by_label("The specification as JSON")
    text.fill(json.dumps(document))
    return page, lambda: json.loads(text.input_value())


@pytest.mark.parametrize(("width", "schemes"), [(390, ("dark",)), (1440, ("light", "dark"))])
def test_an_answered_design_has_no_serious_fault_of_accessibility_and_nothing_wider_than_the_screen(
    open_page: Callable[..., Any], client: httpx.Client, width: int, schemes: tuple[str, ...]
) -> None:
    # enough for other amplitudes
    asked = client.post("/api/v1/designs", json=SPECIFICATION | {"budget_points": 2000}).json()
    answer = wait_for_design(client, asked["id"], ended)["answer"]
    page = open_page(viewport={"width": width, "height": 900}).go(f"#/designs/{asked['id']}")
    page.wait_for_selector(".plot .main-svg", state="attached")
    assert len(answer["amplitudes"]) > 1
    for title, of in (("Response over the frequency", "amplitudes"), ("The best response found", "masses")):
        figure = page.get_by_role("img", name=re.compile(f"^{title}"))
        expect(figure).to_have_count(int(len(answer[of]) > 1))
    assert serious(page, schemes) == []
    assert page.evaluate("document.documentElement.scrollWidth") <= width


def test_every_fault_stands_at_its_field(open_page: Callable[..., Any]) -> None:
    wrong = {"restitution": 2, "choose": {"friction_force_n": {"start": 60, "stop": 5}}, "nonsense": 1}
    wrong["tolerances"] = {"clearance_m": 0.006}
    page, _ = form_of(open_page, SPECIFICATION | wrong)
    expect(page.locator(".estimate")).to_contain_text("faults to fix")
    expect(page.locator('[data-field="restitution"] .faults').first).to_contain_text("0 to 1")
    expect(page.locator('[data-field="choose.friction_force_n"] .faults')).to_contain_text("from")
    # 6 mm of 5 mm, in the unit of the field
    tolerance = page.locator('[data-field="tolerances.clearance_m"] .faults')
    expect(tolerance).to_contain_text("at most 2.5, not 6")
    expect(page.get_by_role("region", name="Budget")).to_contain_text("nonsense")


def test_a_quantity_is_given_or_chosen_from_a_range_or_a_list(open_page: Callable[..., Any]) -> None:
    page = open_page().go("#/designs/new?specification=antenna-mast")
    text = page.get_by_label("The specification as JSON")

    def asked() -> Any:
        return json.loads(text.input_value())

    restitution = page.get_by_role("group", name="Coefficient of restitution")
    values = restitution.get_by_label("Values")
    expect(values).to_have_value("rubber 0.3, polyurethane 0.5, steel 0.8")
    values.fill("soft rubber 0.25 (4 ms), 0.9")
    soft = {"name": "soft rubber", "restitution": 0.25, "contact_time_s": 0.004}
    assert asked()["choose"]["restitution"] == [soft, 0.9]
    # it is read back as it was written
    text.fill(text.input_value())
    expect(values).to_have_value("soft rubber 0.25 (4 ms), 0.9")
    restitution.get_by_label("It is").select_option("range")
    assert asked()["choose"]["restitution"] == {"start": 0.25, "stop": 0.9}
    restitution.get_by_label("It is").select_option("given")
    assert (asked()["restitution"], "restitution" in asked()["choose"]) == (0.25, False)
    page.get_by_role("group", name="Contact").get_by_role("spinbutton").fill("2.5")
    assert asked()["contact_time_s"] == 0.0025
    page.get_by_label("Constant over the band").select_option("base_acceleration_m_per_s2")
    assert asked()["excitation"].keys() == {"base_acceleration_m_per_s2", "frequency_hz"}


def test_excitations_are_added_named_and_removed_in_the_form(open_page: Callable[..., Any]) -> None:
    watched = open_page()
    watched.allowed = ("422",)
    page = watched.go("#/designs/new?specification=prototype")
    text = page.get_by_label("The specification as JSON")

    def excitation() -> Any:
        return json.loads(text.input_value())["excitation"]

    alone = excitation()
    add = page.get_by_role("button", name="Add another excitation")
    add.click()
    assert excitation() == [alone, alone]
    second = page.get_by_role("group", name="Excitation 2", exact=True)
    second.get_by_label("Name").fill("starting")
    second.get_by_label("Constant over the band").select_option("base_velocity_m_per_s")
    band = {key: value for key, value in alone.items() if key.startswith("frequency")}
    assert excitation() == [alone, {"name": "starting", "base_velocity_m_per_s": 1, **band}]
    expect(page.locator(".estimate")).to_contain_text("To be chosen")
    first = page.get_by_role("group", name="Excitation 1", exact=True)
    first.get_by_label("Name").fill("starting")
    expect(page.locator('[data-field="excitation.1.name"] .faults')).to_contain_text("another excitation")
    first.get_by_role("button", name="Remove").click()
    assert excitation() == {"base_velocity_m_per_s": 1, **band}
    expect(page.get_by_role("group", name="Excitation", exact=True)).to_be_visible()
    for _ in range(7):
        add.click()
    expect(add).to_have_count(0)
    assert len(excitation()) == 8


def test_a_sweep_random_vibration_and_a_shock_are_asked_for_in_the_form(
    open_page: Callable[..., Any],
) -> None:
    page, asked = form_of(open_page, SPECIFICATION | {"limits": {}})

    def field(name: str) -> Any:
        return page.locator(f'[data-field="excitation.{name}"]')

    kind, estimate = page.get_by_label("Kind of excitation"), page.locator(".estimate")
    kind.select_option("sweep")
    page.get_by_label("Constant in the sweep").select_option("base_velocity_m_per_s")
    page.get_by_label("How fast").select_option("rate_octaves_per_minute")
    field("sweep.rate_octaves_per_minute").locator("input").fill("2")
    page.get_by_label("Scales").fill("0.5, 1")
    swept = {"start_hz": 2, "stop_hz": 3, "rate_octaves_per_minute": 2, "base_velocity_m_per_s": 0.05}
    assert asked()["excitation"] == {"sweep": swept, "scales": [0.5, 1]}
    expect(estimate).to_contain_text("200")
    expect(page.get_by_label("Minimise").locator("option")).to_have_count(6)
    field("sweep.stop_hz").locator("input").fill("2")
    expect(field("sweep.stop_hz").locator(".faults")).to_contain_text("at which the sweep begins")
    # a run-down of its own beside it, then a band
    page.get_by_role("button", name="Add a sweep").click()
    page.get_by_role("button", name="Add another excitation").click()
    assert [next(iter(each)) for each in asked()["excitation"]] == ["sweep", "sweep", "base_amplitude_m"]
    expect(page.get_by_role("group", name="Excitation 2: sweep")).to_be_visible()
    expect(page.get_by_label("Minimise").locator("option")).to_have_count(5)

    for _ in range(2):
        page.get_by_role("button", name="Remove excitation 1").click()
    kind.select_option("random_vibration")
    field("random_vibration.frequency_hz").locator("input").fill("1, 5, 50")
    page.get_by_label("Unit of the levels").select_option("psd_m2_per_s3")
    levels = field("random_vibration.psd_m2_per_s3")
    levels.locator("input").fill("0.01, 0.02")
    expect(levels.locator(".faults")).to_contain_text("2 levels for 3 frequencies")
    levels.locator("input").fill("0.01, 0.02, 0.001")
    shaken = {"frequency_hz": [1, 5, 50], "psd_m2_per_s3": [0.01, 0.02, 0.001], "duration_s": 30, "seeds": 4}
    assert asked()["excitation"] == {"random_vibration": shaken}
    page.get_by_role("button", name="Add a shock").click()
    page.get_by_label("Shape of the pulse").select_option("sawtooth")
    field("1.shock.peak_g").locator("input").fill("8")
    struck = {"shape": "sawtooth", "peak_g": 8, "duration_ms": 11}
    assert asked()["excitation"][1] == {"shock": struck}
    expect(page.get_by_role("group", name="Excitation 2: shock")).to_be_visible()
    expect(estimate).to_contain_text("200")


def test_records_are_chosen_in_the_form_and_the_answer_is_shown_under_each(
    open_page: Callable[..., Any], client: httpx.Client
) -> None:
    page, asked = form_of(open_page, SPECIFICATION | {"limits": {}, "name": "shaken"})
    page.get_by_label("Kind of excitation").select_option("records")
    assert asked()["excitation"] == {"records": ["el-centro-180"], "scales": 1}
    pacoima = page.get_by_label("San Fernando 1971, Pacoima Dam, 164°")
    pacoima.check()
    page.get_by_label("Scales").fill("0.25, 0.5")
    page.get_by_label("Minimise").select_option("worst_acceleration")
    chosen = {"records": ["el-centro-180", "san-fernando-164"], "scales": [0.25, 0.5]}
    assert (asked()["excitation"], asked()["measure"]) == (chosen, "worst_acceleration")
    expect(page.locator(".estimate")).to_contain_text("200")
    page.get_by_role("button", name="Find the damper").click()
    recommended = page.get_by_role("region", name="Recommended damper")
    expect(recommended).to_be_visible(timeout=1_800_000)
    expect(recommended).to_contain_text("m/s² under san-fernando-164 × 0.5")
    expect(page.get_by_text("Under each record, as drawn")).to_be_visible()
    # every evaluation is a stored ground-motion suite
    listed = client.get("/api/v1/studies", params={"limit": 200, "name": "shaken"}).json()["studies"]
    record = client.get(f"/api/v1/studies/{listed[0]['id']}").json()
    assert len(record["definition"]["records"]) == 2
    page.get_by_role("link", name="Change and ask again").click()
    expect(page.get_by_label("Kind of excitation")).to_have_value("records")
    expect(pacoima).to_be_checked()


def test_records_stand_beside_a_band_in_the_form(open_page: Callable[..., Any]) -> None:
    more = {"limits": {}, "name": "both", "measure": "worst_rms_displacement"}
    page, asked = form_of(open_page, SPECIFICATION | more)
    page.get_by_role("button", name="Add ground-motion records").click()
    expect(page.get_by_role("button", name="Add ground-motion records")).to_have_count(0)
    quake = page.get_by_role("group", name="Excitation 2: ground-motion records")
    quake.get_by_label("Name").fill("quake")
    quake.get_by_label("Scales").fill("0.3")
    limits = page.get_by_role("group", name="Limits")
    limits.get_by_label(re.compile("^Acceleration of the structure")).fill("50")
    # what is over the band alone is no longer among them
    over_the_band = page.get_by_label("Minimise").locator("option[value=worst_rms_relative_displacement]")
    expect(over_the_band).to_have_count(0)
    page.get_by_label("Minimise").select_option("worst_displacement")
    assert asked()["excitation"] == [
        SPECIFICATION["excitation"],
        {"records": ["el-centro-180"], "scales": [0.3], "name": "quake"},
    ]
    assert asked()["limits"] == {"acceleration_m_per_s2": 50}
    expect(page.locator(".estimate")).to_contain_text("200")
    # without its band it is about the records alone, and what no band has is offered again
    page.get_by_role("button", name="Remove excitation 1").click()
    expect(page.get_by_label("Kind of excitation")).to_have_value("records")
    expect(over_the_band).to_have_count(1)
    assert "name" not in asked()["excitation"]
