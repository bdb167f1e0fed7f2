"""The reference simulator against its own equations, digits and records."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import pytest
from tests.reference.make import COUNTS, NAMES
from tests.reference.motion import Motion
from tests.reference.numbers import ExtendedNumbers
from tests.reference.points import POINTS
from tests.reference.roots import first_zero
from tests.reference.simulator import simulate

RECORDS: list[dict[str, Any]] = json.loads(Path(__file__).with_name("states.json").read_text())["points"]


@pytest.mark.parametrize(
    ("zeta", "r", "mu"), [("0.0038", 1, 1), (0, "0.7", 1), (0, 1, 1), (0, "0.5", 4), ("0.9", 20, "1.1")]
)
def test_closed_form_solves_the_equation_of_motion(zeta: object, r: object, mu: object) -> None:
    numbers = ExtendedNumbers(40)
    z, f, m, load = (numbers.convert(x) for x in (zeta, r, mu, "0.3"))
    start = (numbers.convert("1.7"), numbers.convert("-0.4"))
    motion = Motion(numbers, z, f, m, load, numbers.convert("2.3"), start)
    begun, *_ = motion.at(numbers.convert(0))
    assert abs(begun[0] - start[0]) + abs(begun[1] - start[1]) < 1e-36
    h, step = numbers.convert("1.9"), numbers.convert("1e-12")
    v, base, push = motion.at(h)
    size = 10 * max(1, abs(v[2]), f * f)
    assert abs(m * v[2] + 2 * z * v[1] + v[0] + load - push[0]) < size * 1e-37
    ahead, behind = motion.at(h + step), motion.at(h - step)
    for k in range(4):  # derivatives against central differences: error step^2 times the third derivative
        for which in (0, 1):
            slope = (ahead[which][k] - behind[which][k]) / (2 * step)
            now = (v, base)[which]
            assert abs(slope - now[k + 1]) < 1e-20 * max(1, f**6)


@pytest.mark.parametrize(("depth", "expected"), [(1e-9, True), (-1e-9, False)])
def test_a_touch_between_samples_is_found(depth: float, expected: bool) -> None:
    def function(x: float) -> tuple[float, float, float]:
        return 10 * (x - 0.37) ** 2 - depth, 20 * (x - 0.37), 20.0

    root = first_zero(function, 0.0, function(0.0), 1.0, function(1.0), (1e-16, 1e-16, 1e-16))
    if expected:
        assert root == pytest.approx(0.37 - math.sqrt(depth / 10), abs=1e-10)
    else:
        assert root is None


@pytest.mark.parametrize(
    "scene",
    [
        (0.0038, 1.0, 0.4, (5.0, 0.47, 0.1)),
        (0.0038, 0.9, 0.6, (0.5, 0.1, 0.1)),  # chatter and attachment
        (0.0038, 0.5, 0.2, (0.5, 0.0, 0.1)),  # attached to a stuck mass
    ],
)
def test_energy_is_balanced_and_digits_agree(scene: Any) -> None:
    zeta, r, gamma, particle = scene
    run = simulate(zeta, r, gamma, particle, 2, energy=True)
    # Set by the quadrature of work and viscous loss, order 10 in a step of 2 pi/200.
    assert run["energy_residual"] < 1e-22
    more = simulate(zeta, r, gamma, particle, 2, digits=60)
    # Chatter is cut at 1e-15 with 40 digits and at 1e-22 with 60: what the cut moves is of order 1e-30.
    assert max(abs(float(run[name] - more[name])) for name in NAMES) < 1e-26


def test_a_run_can_be_taken_up_at_any_cycle() -> None:
    scene = (0.0038, 0.9, 0.8, (0.3, 0.1, 0.1))
    whole = simulate(*scene, cycles=4, digits=30)
    half = simulate(*scene, cycles=2, digits=30)
    rest = simulate(*scene, cycles=2, digits=30, start=half["end"])
    assert max(abs(float(whole[name] - rest[name])) for name in NAMES) < 1e-20


def test_records_are_those_of_the_points() -> None:
    assert len(RECORDS) == len(POINTS)
    for record, point in zip(RECORDS, POINTS, strict=True):
        particle = None if record["particle"] is None else tuple(record["particle"].values())
        assert (record["scene"], record["cycles"], particle) == (point.scene, point.cycles, point.particle)
        assert record["chaotic"] == (record["amplification"] > 1e8)


@pytest.mark.parametrize("scene", ["slip", "stick", "hybrid", "hybrid-stick"])
def test_records_are_reproduced(scene: str) -> None:
    record = next(record for record in RECORDS if record["scene"] == scene)
    particle = None if record["particle"] is None else tuple(record["particle"].values())
    ratios = [record[name] for name in ("damping_ratio", "frequency_ratio", "friction_ratio")]
    run = simulate(ratios[0], ratios[1], ratios[2], particle, record["cycles"])
    numbers = ExtendedNumbers(40)
    for name in NAMES:
        assert abs(run[name] - numbers.convert(record["state"][name])) < 1e-22
    assert {name: run[name] for name in COUNTS} == record["events"]


def test_double_precision_is_as_good_as_the_sensitivity_allows() -> None:
    for record in RECORDS:
        # Some hundred roundings of numbers up to 60, and the coarser cut of chatter (1e-6, squared).
        assert record["double_error"] < 1e-11 + 2e-13 * record["amplification"], record
