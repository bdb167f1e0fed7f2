"""The simulator gives the kept records again with half as many digits more."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from tests.reference.make import COUNTS, NAMES
from tests.reference.numbers import ExtendedNumbers
from tests.reference.points import point_of
from tests.reference.simulator import simulate
from tests.worker.forms import night

RECORDS: list[dict[str, Any]] = json.loads(Path(__file__).with_name("states.json").read_text())["points"]


@pytest.mark.parametrize("scene", ["hybrid-stick", *map(night, ("slip", "stick", "hybrid"))])
def test_records_are_reproduced(scene: str) -> None:
    record = next(record for record in RECORDS if record["scene"] == scene)
    _, *point = point_of(record)
    run = simulate(*point, digits=60)
    numbers = ExtendedNumbers(60)
    for name in NAMES:
        assert abs(run[name] - numbers.convert(record["state"][name])) < 1e-22
    assert {name: run[name] for name in COUNTS} == record["events"]
