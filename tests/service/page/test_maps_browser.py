"""Maps in a real browser: contours within their values, small pictures in the list."""

import re
from collections.abc import Callable
from typing import Any

import httpx
import numpy as np
import pytest
from playwright.sync_api import Page, expect
from tests.service.page.looking import serious, until

pytestmark = pytest.mark.night


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
    open_page: Callable[..., Any], own_service: Callable[..., Any], helpers: Any
) -> None:
    running = own_service()
    axes = {"friction_ratio": [0.1, 0.3], "frequency_ratio": [0.9, 1.1]}
    common = {"particle": False, "steady": {"max_cycles": 40}}
    many = [
        common | {"name": f"one of many {i}", "damping_ratio": 0.02 + 0.001 * i, "axes": axes}
        for i in range(30)
    ]
    many.append(common | {"name": "one point", "axes": {"friction_ratio": 0.1, "frequency_ratio": 1.0}})
    with httpx.Client(base_url=running.url, timeout=300) as client:
        records = client.post("/api/v1/studies", json=many).raise_for_status().json()["studies"]
        for record in records:
            assert helpers.wait_for(client, record["id"], helpers.ended)["state"] == "done"
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
