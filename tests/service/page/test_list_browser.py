"""The list of studies in a real browser: tags, notes, ranges, small pictures; and searches that go on from a study."""

import re
from collections.abc import Callable
from typing import Any

import httpx
import numpy as np
import pytest
from playwright.sync_api import Page, expect
from tests.service.conftest import computed, ended, wait_for
from tests.service.page.looking import serious, until

pytestmark = pytest.mark.night

COMMON = {"particle": False, "steady": {"max_cycles": 40}}


def test_a_tag_is_written_and_leads_to_its_studies(
    open_page: Callable[..., Any], own_service: Callable[..., Any]
) -> None:
    running = own_service()
    for name, frictions in (("low", [0.1, 0.2]), ("high", [0.5, 0.6])):
        axes = {"friction_ratio": frictions, "frequency_ratio": [0.9, 1.1]}
        record = computed(running, {"name": name, "damping_ratio": 0.02, "axes": axes} | COMMON)
    watched = open_page(running.url, viewport={"width": 390, "height": 900})
    page = watched.go(f"#/studies/{record['id']}/data")
    page.get_by_label("Tags, separated by commas").fill("Rig 2")
    page.get_by_role("button", name="Save name, tags and note").click()
    expect(page.get_by_role("alert")).to_contain_text("lower-case letters")
    page.get_by_label("Tags, separated by commas").fill("steel, rig-2")
    page.get_by_label("Note", exact=True).fill("measured\ntwice")
    page.get_by_label("Name", exact=True).fill("high friction")
    page.get_by_role("button", name="Save name, tags and note").focus()
    page.keyboard.press("Enter")
    expect(page.get_by_text("Saved.", exact=True)).to_be_visible()
    expect(page.get_by_role("heading", level=1)).to_have_text("high friction")
    page = watched.go(f"#/studies/{record['id']}/data")
    expect(page.get_by_label("Tags, separated by commas")).to_have_value("rig-2, steel")
    expect(page.get_by_label("Note", exact=True)).to_have_value("measured\ntwice")
    assert serious(page) == []

    page = watched.go("")
    cards = page.locator(".card")
    expect(cards).to_have_count(2)
    page.get_by_role("button", name="Studies with the tag rig-2").click()
    expect(cards).to_have_count(1)
    page.reload()  # as from a link that somebody sent
    tag, lowest = page.get_by_label("Tag", exact=True), page.get_by_label("from", exact=True)
    expect(cards).to_have_count(1)
    expect(cards).to_contain_text("high friction")
    expect(tag).to_have_value("rig-2")
    tag.fill("Rig")
    expect(page.get_by_text("No study has such a tag")).to_be_visible()
    assert serious(page) == []
    tag.fill("")
    page.get_by_label("Values of").select_option("friction_ratio")
    lowest.fill("0.15")
    page.get_by_label("to", exact=True).fill("0.3")
    expect(cards).to_have_count(1)
    expect(cards).to_contain_text("low")
    lowest.fill("0.35")
    expect(page.get_by_text("The range is empty")).to_be_visible()
    lowest.fill("0.25")
    expect(page.get_by_text("No study matches the search.")).to_be_visible()
    assert page.evaluate("document.documentElement.scrollWidth") <= 390


@pytest.fixture(scope="module")
def frictions(service: Any) -> dict[str, Any]:
    """A study of friction alone over a band; its best friction lies inside."""
    axes = {
        "friction_ratio": {"start": 0.3, "stop": 0.8, "num": 11},
        "frequency_ratio": {"start": 0.9, "stop": 1.1, "num": 5},
    }
    study = {"name": "frictions", "particle": False, "damping_ratio": 0.021, "axes": axes}
    found: dict[str, Any] = computed(service, study)
    return found


def test_a_search_goes_on_until_the_best_is_known(
    open_page: Callable[..., Any], client: httpx.Client, frictions: dict[str, Any]
) -> None:
    page = open_page().go(f"#/studies/{frictions['id']}")
    page.get_by_text("Refine: is a better design nearby?").click()
    button = page.get_by_role("button", name="Search around the best design")
    button.focus()
    page.keyboard.press("Enter")
    panel = page.locator("details", has=button)
    expect(panel).to_contain_text("Known: ")
    expect(button).to_be_enabled()
    told = re.search(r"Known: ([\d.]+).* at γF = ([\d.]+)", panel.inner_text().replace("\n", ""))
    assert told
    # asked again with everything that was computed, the service says the same and has nothing more to compute
    follow_ups = [
        one["id"]
        for one in client.get("/api/v1/studies", params={"name": "frictions, refined"}).json()["studies"]
    ]
    assert follow_ups
    asked = {"with": ",".join(reversed(follow_ups)), "objective": "peak"}
    answer = client.post(f"/api/v1/studies/{frictions['id']}/refine", params=asked, json={}).json()
    assert answer["known"]
    assert float(told[1]) == pytest.approx(answer["found"]["value"], rel=1e-4)
    assert float(told[2]) == pytest.approx(answer["found"]["friction_ratio"], rel=1e-4)
    assert serious(page, ("light",)) == []


PIXELS = """(id) => {
  const canvas = document.querySelector(`[data-study="${id}"] canvas.thumbnail`);
  if (!canvas || canvas.width < 2) return null;
  const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
  const box = canvas.getBoundingClientRect();
  return { size: [canvas.width, canvas.height], shown: [box.width, box.height], data: [...data] };
}"""


def asked_for(watched: Any) -> list[str]:
    return [
        match[1]
        for request in watched.requests
        if (match := re.search(r"/studies/([\w-]+)/resonance-map", request.url))
    ]


def looked_at(page: Page, study_id: str) -> np.ndarray[Any, Any]:
    found = until(page, PIXELS, lambda pixels: pixels is not None, study_id)
    assert found["shown"] == [96, 64]
    columns, rows = found["size"]
    return np.array(found["data"]).reshape(rows, columns, 4)


def test_a_finished_study_shows_its_map_small(
    open_page: Callable[..., Any], client: httpx.Client, small_map: dict[str, Any]
) -> None:
    watched = open_page()
    page = watched.go("")
    study_id = small_map["id"]
    page.get_by_label("Search").fill("small map")  # of the many that other tests have left
    pixels = looked_at(page, study_id)
    page.get_by_label("Choose small map").first.check()
    assert serious(page, ("light",)) == []
    address = next(r.url for r in watched.requests if f"{study_id}/resonance-map" in r.url)
    first, second = re.findall(r"[?&][xy]=(\w+)", address)
    answer = client.get(f"/api/v1/studies/{study_id}/resonance-map", params={"x": first, "y": second}).json()
    values = np.array(answer["values"], float)[::-1]
    assert pixels.shape[:2] == values.shape
    assert np.all(pixels[..., 3] == 255)
    # cividis: the greater the value the more red, and the same value the same colour
    red = pixels[..., 0].ravel()[np.argsort(values, axis=None)]
    assert np.all(np.diff(red) >= 0)
    assert red[0] < red[-1]


def test_a_long_list_asks_for_what_is_seen_once(
    open_page: Callable[..., Any], own_service: Callable[..., Any]
) -> None:
    running = own_service()
    axes = {"friction_ratio": [0.1, 0.3], "frequency_ratio": [0.9, 1.1]}
    many = [
        COMMON | {"name": f"one of many {i}", "damping_ratio": 0.02 + 0.001 * i, "axes": axes}
        for i in range(30)
    ]
    many.append(COMMON | {"name": "one point", "axes": {"friction_ratio": 0.1, "frequency_ratio": 1.0}})
    with httpx.Client(base_url=running.url, timeout=300) as client:
        records = client.post("/api/v1/studies", json=many).raise_for_status().json()["studies"]
        for record in records:
            assert wait_for(client, record["id"], ended)["state"] == "done"
    watched = open_page(running.url, viewport={"width": 390, "height": 800})
    page = watched.go("")
    looked_at(page, records[29]["id"])
    page.wait_for_timeout(500)
    page.get_by_label("Search").fill("nothing like this")
    page.get_by_text("No study").first.wait_for()
    page.get_by_label("Search").fill("")
    looked_at(page, records[29]["id"])
    seen = asked_for(watched)
    assert 0 < len(set(seen)) < 15
    assert len(seen) == len(set(seen))
    assert records[30]["id"] not in seen
    last = page.locator(f'[data-study="{records[0]["id"]}"]')
    last.scroll_into_view_if_needed()
    looked_at(page, records[0]["id"])
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
    expect(page.locator(f'[data-study="{records[30]["id"]}"] .thumbnail')).to_have_text("one axis, no map")
    assert serious(page) == []
