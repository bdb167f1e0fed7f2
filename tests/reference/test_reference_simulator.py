"""The kept records are those of the points, and the simulator gives them again with half as many digits more."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from tests.reference.make import COUNTS, NAMES
from tests.reference.numbers import ExtendedNumbers
from tests.reference.points import POINTS
from tests.reference.simulator import simulate
from tests.worker.forms import night

RECORDS: list[dict[str, Any]] = json.loads(Path(__file__).with_name("states.json").read_text())["points"]


def test_records_are_those_of_the_points() -> None:
    assert len(RECORDS) == len(POINTS)
    for record, point in zip(RECORDS, POINTS, strict=True):
        particle = None if record["particle"] is None else tuple(record["particle"].values())
        assert (record["scene"], record["cycles"], particle) == (point.scene, point.cycles, point.particle)
        assert record["chaotic"] == (record["amplification"] > 1e8)


@pytest.mark.parametrize("scene", ["hybrid-stick", *map(night, ("slip", "stick", "hybrid"))])
def test_records_are_reproduced(scene: str) -> None:
    record = next(record for record in RECORDS if record["scene"] == scene)
    particle = None if record["particle"] is None else tuple(record["particle"].values())
    ratios = [record[name] for name in ("damping_ratio", "frequency_ratio", "friction_ratio")]
    run = simulate(*ratios, particle, record["cycles"], digits=60)
    numbers = ExtendedNumbers(60)
    for name in NAMES:
        assert abs(run[name] - numbers.convert(record["state"][name])) < 1e-22
    assert {name: run[name] for name in COUNTS} == record["events"]
