"""Contour lines of maps that are barely known: round levels within the values, or none."""

import itertools
import json
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

pytestmark = pytest.mark.night

DRAWN = """async ([maps, module]) => {
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
    drawn = page.evaluate(DRAWN, [[a_map(values) for values in maps], page.evaluate(MODULE)])
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
