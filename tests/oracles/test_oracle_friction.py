"""Forced and free friction oracles, and the bare structure, against the simulator."""

from __future__ import annotations

import math

import pytest
from tests.oracles import forced_friction
from tests.oracles.forced_friction import FrictionResponse
from tests.reference.march import Simulation
from tests.reference.numbers import ExtendedNumbers
from tests.reference.state import State

NUMBERS = ExtendedNumbers(40)


def half_period_from(scene: tuple[float, float, float], orbit: FrictionResponse) -> Simulation:
    """Return a run started at the orbit's upper turn (or the end of its upper stick), half a period later."""
    run = Simulation(NUMBERS, *scene, None)
    begun = NUMBERS.convert(orbit.phase % (2 * math.pi)) / run.r
    amplitude = NUMBERS.convert(orbit.relative_amplitude_ratio)
    zero = NUMBERS.convert(0)
    run.state = State(begun, amplitude, zero, zero, zero)
    end = begun + NUMBERS.pi / run.r
    while end - run.state.time > NUMBERS.rounding * 100:
        run.run_segment(end - run.state.time)
    return run


@pytest.mark.parametrize(
    "scene", [(0.0038, 1.0, 0.6), (0.05, 0.8, 0.2), (0.0, 1.5, 0.5), (0.3, 1.0, 0.2), (0.0038, 3.0, 1.0)]
)
def test_non_stop_orbit_returns_mirrored(scene: tuple[float, float, float]) -> None:
    orbit = forced_friction.non_stop(*scene)
    assert orbit is not None
    run = half_period_from(scene, orbit)
    # Double-precision oracle, amplitude up to 31: a hundred ulps.
    assert float(run.state.v) == pytest.approx(-orbit.relative_amplitude_ratio, rel=1e-12)
    assert run.sticks == 0
    assert forced_friction.one_stop(*scene) is None


@pytest.mark.parametrize("scene", [(0.0038, 1.0, 0.8), (0.0038, 0.9, 0.7), (0.0038, 0.5, 0.2)])
def test_one_stop_orbit_returns_mirrored(scene: tuple[float, float, float]) -> None:
    orbit = forced_friction.one_stop(*scene)
    assert orbit is not None
    run = half_period_from(scene, orbit)
    assert float(run.state.v) == pytest.approx(-orbit.relative_amplitude_ratio, rel=1e-12)
    assert run.state.stuck or "loose-" in [name for _, name in run.events]
    assert float(run.stuck_time * run.r / NUMBERS.pi) == pytest.approx(orbit.stick_fraction, abs=1e-10)
    assert forced_friction.non_stop(*scene) is None


def test_slip_and_stop_solutions_do_not_overlap_and_meet() -> None:
    for gamma in [0.05 * k for k in range(1, 20)]:
        slip = forced_friction.non_stop(0.0038, 0.9, gamma)
        stop = forced_friction.one_stop(0.0038, 0.9, gamma)
        assert slip is None or stop is None, gamma
    # The bound at r = 0.9 lies in this bracket; the response is continuous through it.
    low, high = 0.3, 0.75
    for _ in range(40):
        middle = (low + high) / 2
        low, high = (
            (middle, high) if forced_friction.non_stop(0.0038, 0.9, middle) is not None else (low, middle)
        )
    below = forced_friction.non_stop(0.0038, 0.9, low)
    above = forced_friction.one_stop(0.0038, 0.9, high + 1e-6)
    assert below is not None
    assert above is not None
    # X/Z falls by about 28 per unit of gamma here.
    assert above.amplitude_ratio == pytest.approx(below.amplitude_ratio, abs=1e-4)
