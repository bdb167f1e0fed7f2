"""Forced and free friction oracles, and the bare structure, against the simulator."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise

import pytest
from tests.oracles import forced_friction, free_decay, transmissibility
from tests.oracles.forced_friction import FrictionResponse
from tests.reference.march import Simulation
from tests.reference.numbers import ExtendedNumbers
from tests.reference.simulator import simulate
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


def test_known_friction_amplitudes() -> None:
    # Independent computations given with the model.
    slip = forced_friction.non_stop(0.0038, 1.0, 0.6)
    stop = forced_friction.one_stop(0.0038, 1.0, 0.8)
    assert slip is not None
    assert slip.relative_amplitude_ratio == pytest.approx(31.059792, abs=5e-7)
    assert stop is not None
    assert stop.amplitude_ratio == pytest.approx(0.895646, abs=5e-7)


@pytest.mark.parametrize(
    ("scene", "cycles", "oracle"),
    [
        ((0.05, 0.8, 0.2), 90, forced_friction.non_stop),
        ((0.3, 1.0, 0.2), 20, forced_friction.non_stop),
        ((0.0038, 0.9, 0.7), 40, forced_friction.one_stop),
    ],
)
def test_friction_orbit_is_reached_from_rest(
    scene: tuple[float, float, float],
    cycles: int,
    oracle: Callable[[float, float, float], FrictionResponse | None],
) -> None:
    orbit = oracle(*scene)
    assert orbit is not None
    run = simulate(*scene, None, cycles, digits=None, peaks=True)
    u, v = run["peaks"][-1]
    # Cycles are enough for exp(-2 pi zeta n/r), or one stick's contraction each, to fall below 1e-15.
    assert u == pytest.approx(orbit.amplitude_ratio, rel=1e-12)
    assert v == pytest.approx(orbit.relative_amplitude_ratio, rel=1e-12)


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


@pytest.mark.parametrize("zeta", [0.0, 0.05])
def test_free_decay_is_reproduced(zeta: float) -> None:
    gamma, start = 0.1, 1.05
    expected = free_decay.turning_points(zeta, gamma, start)
    # Shaken so slowly that the base's pull, r^2 sin(r t), is below 1e-39.
    run = Simulation(NUMBERS, zeta, 1e-20, gamma, None)
    zero = NUMBERS.convert(0)
    run.state = State(zero, NUMBERS.convert(start), zero, zero, zero)
    found, times = [start], [0.0]
    while not run.state.stuck and len(found) < 20:
        run.run_segment(NUMBERS.convert(4))
        found.append(abs(float(run.state.v)))
        times.append(float(run.state.time))
        run.settle()
    assert found == pytest.approx([abs(x) for x in expected], abs=1e-14)
    assert times == pytest.approx([k * free_decay.half_period(zeta) for k in range(len(found))], rel=1e-14)


def test_amplitude_loss_per_half_cycle_is_two_gamma() -> None:
    points = free_decay.turning_points(0.0, 0.1, 1.05)
    assert [a - b for a, b in pairwise(points)] == pytest.approx([0.2] * 5, abs=1e-15)


@pytest.mark.parametrize("r", [0.7, 1.0, 1.6])
def test_bare_structure_settles_to_the_transmissibility(r: float) -> None:
    zeta = 0.3
    run = simulate(zeta, r, 0.0, cycles=30, digits=None, peaks=True)
    u, v = run["peaks"][-1]
    # exp(-2 pi 0.3 30/1.6) is 5e-16.
    assert u == pytest.approx(transmissibility.absolute_amplitude(zeta, r), rel=1e-13)
    assert v == pytest.approx(transmissibility.relative_amplitude(zeta, r), rel=1e-13)
