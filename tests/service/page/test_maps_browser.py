"""Maps in a real browser: contours within their values, small pictures in the list."""

import itertools
import json
import math
import re
from collections.abc import Callable
from typing import Any

import httpx
import numpy as np
import pytest
from playwright.sync_api import Page, expect
from tests.service.page.looking import serious, until

pytestmark = pytest.mark.night

CONTOURS = """async ([maps, module]) => {
  const { mapTraces, mapLayout } = await import(module.replace("main.js", "map_figure.js"));
  const nothing = { best: null, idle: null, pareto: [], point: null };
  const plot = document.body.appendChild(document.createElement("div"));
  const drawn = [];
  for (const map of maps) {
    const traces = mapTraces(map, { contours: true, classes: false }, nothing, { variables: [] });
    await window.Plotly.react(plot, traces, { height: 300, ...mapLayout(map) }, {});
    drawn.push(traces.find((trace) => trace.type === "contour")?.contours ?? null);
  }
  plot.remove();
  return drawn;
}"""
MODULE = "document.querySelector('script[type=module]').src"


def a_map(values: "np.ndarray[Any, Any]") -> dict[str, Any]:
    """What the service answers, as far as a figure needs it, with JSON's null where nothing is known."""
    rows, columns = values.shape
    known = [[None if math.isnan(value) else value for value in row] for row in values.tolist()]
    axes = {"x": [0.9 + 0.01 * i for i in range(columns)], "y": [1.0 + j for j in range(rows)]}
    titles = {"x_title": "r", "y_title": "d/Z", "metric": "amplitude_ratio", "long_name": "X/Z"}
    return json.loads(json.dumps({**axes, **titles, "values": known}))  # type: ignore[no-any-return]


def test_maps_of_few_and_of_nearly_equal_values_are_drawn(
    open_page: Callable[..., Any], small_map: dict[str, Any]
) -> None:
    draws = np.random.default_rng(5)
    maps = [np.full((6, 7), np.nan), np.full((6, 7), 1.0)]
    for exponent, share in itertools.product(range(0, 17, 2), (0.05, 0.3, 1.0)):
        for _ in range(3):  # the one after the other: a figure remembers levels of the map before
            values = 10.0 ** draws.uniform(-3, 3) * (1 + 10.0**-exponent * draws.integers(0, 4, (6, 7)))
            maps.append(np.where(draws.random((6, 7)) < share, values, np.nan))
    page = open_page().go(f"#/studies/{small_map['id']}")
    page.wait_for_selector(".plot .main-svg")
    drawn = page.evaluate(CONTOURS, [[a_map(values) for values in maps], page.evaluate(MODULE)])
    assert any(drawn)
    for values, levels in zip(maps, drawn, strict=True):
        known = values[~np.isnan(values)]
        if known.size and known.max() > 20 * known.min():
            known = np.log10(known)
        if known.size == 0 or np.ptp(known) <= 1e-9 * np.abs(known).max():
            assert levels is None
        elif levels:
            count = round((levels["end"] - levels["start"]) / levels["size"]) + 1
            assert 1 <= count <= 12
            assert known.min() < levels["start"] <= levels["end"] < known.max()


PIXELS = """(id) => {
  const canvas = document.querySelector(`[data-study="${id}"] canvas.thumbnail`);
  if (!canvas || canvas.width < 2) return null;
  const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
  const box = canvas.getBoundingClientRect();
  return { size: [canvas.width, canvas.height], shown: [box.width, box.height], data: [...data] };
}"""
SHORT_STEADY = {"max_cycles": 40}


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
    first, second = re.findall(
        r"[?&][xy]=(\w+)", next(r.url for r in watched.requests if f"{study_id}/resonance-map" in r.url)
    )
    answer = client.get(f"/api/v1/studies/{study_id}/resonance-map", params={"x": first, "y": second}).json()
    values = np.array(answer["values"], float)[::-1]
    assert pixels.shape[:2] == values.shape
    assert np.all(pixels[..., 3] == 255)
    # cividis: the greater the value the more red, and the same value the same colour
    order = np.argsort(values, axis=None)
    red = pixels[..., 0].ravel()[order]
    assert np.all(np.diff(red) >= 0)
    assert len({tuple(pixel) for pixel in pixels.reshape(-1, 4).tolist()}) > 1
    before = asked_for(watched).count(study_id)  # a view that is opened is loaded twice here
    page.get_by_label("Search").fill("nothing like this")
    page.get_by_text("No study").first.wait_for()
    page.get_by_label("Search").fill("small map")
    looked_at(page, study_id)
    assert 1 <= asked_for(watched).count(study_id) == before <= 2
    assert serious(page) == []


def test_a_long_list_asks_for_what_is_seen(
    open_page: Callable[..., Any], own_service: Callable[..., Any], helpers: Any
) -> None:
    running = own_service()
    with httpx.Client(base_url=running.url, timeout=300) as client:
        axes = {"friction_ratio": [0.1, 0.3], "frequency_ratio": [0.9, 1.1]}
        many = [
            {
                "name": f"one of many {i}",
                "particle": False,
                "damping_ratio": 0.02 + 0.001 * i,
                "axes": axes,
                "steady": SHORT_STEADY,
            }
            for i in range(30)
        ]
        many.append(
            {
                "name": "one point",
                "particle": False,
                "damping_ratio": 0.5,
                "axes": {"friction_ratio": 0.1, "frequency_ratio": 1.0},
            }
        )
        records = client.post("/api/v1/studies", json=many).raise_for_status().json()["studies"]
        for record in records:
            assert helpers.wait_for(client, record["id"], helpers.ended)["state"] == "done"
    watched = open_page(running.url, viewport={"width": 390, "height": 800})
    page = watched.go("")
    looked_at(page, records[29]["id"])
    page.wait_for_timeout(500)
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
