"""The kernels against end states that were computed in forty digits (`tests/reference/states.json`)."""

import json
from math import pi
from pathlib import Path
from typing import Any

import pytest

from damperlab.worker.point import Design
from damperlab.worker.simulate import simulate
from damperlab.worker.solver.particle import Particle

STATES = Path(__file__).parents[1] / "reference" / "states.json"
RECORDS: list[dict[str, Any]] = json.loads(STATES.read_text())["points"]
ROUNDING = 1e-11
"""Of a march of tens of cycles, whose motion is at most about 100: thousands of roundings of 1e-14."""
SPREAD = 2e-13
"""Rounding of the start of a march, and of its parts, that the motion then amplifies."""


def design_of(record: dict[str, Any]) -> Design:
    particle = record["particle"]
    return Design(
        record["damping_ratio"],
        record["frequency_ratio"],
        record["friction_ratio"],
        None if particle is None else Particle(**particle),
    )


def name_of(record: dict[str, Any]) -> str:
    particle = record["particle"]
    inputs = [record[name] for name in ("damping_ratio", "frequency_ratio", "friction_ratio")]
    return f"{record['scene']} {[*inputs, *(particle.values() if particle else ()), record['cycles']]}"


@pytest.mark.parametrize("record", RECORDS, ids=name_of)
def test_end_state_agrees_with_extended_precision(record: dict[str, Any]) -> None:
    design = design_of(record)
    end = simulate(design, record["cycles"])
    allowed = ROUNDING + SPREAD * record["amplification"]
    for name, digits in record["state"].items():
        if name.startswith("p") and design.particle is None:
            assert end.state[name] is None
        else:
            assert end.state[name] == pytest.approx(float(digits), rel=0.0, abs=allowed), name
    assert end.cycles == record["cycles"]
    if not record["chaotic"] and not record["events"]["attachments"]:
        # Impacts within a chatter are counted until it is cut, which each program does at its own depth.
        assert end.events["impacts"] == record["events"]["impacts"]


TAME = [one for one in RECORDS if one["scene"] in ("slip", "hybrid") and one["amplification"] < 100.0]


@pytest.mark.parametrize("record", TAME, ids=name_of)
def test_paper_method_comes_as_near_as_its_step_allows(record: dict[str, Any]) -> None:
    """Every event is noticed up to a step late, at speeds of order one, and the motion amplifies what that moves."""
    design = design_of(record)
    steps = 32_000
    end = simulate(design, record["cycles"], method="rk4", steps_per_cycle=steps)
    names = [name for name in record["state"] if end.state[name] is not None]
    error = max(abs(float(record["state"][name]) - (end.state[name] or 0.0)) for name in names)
    events = record["events"]["impacts"] + record["events"]["turns"]
    step = 2.0 * pi / record["frequency_ratio"] / steps
    assert 0.0 < error < step * events * max(1.0, record["amplification"])
