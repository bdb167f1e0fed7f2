"""The bouncing ball and the shaken box against simulation, and against the two-impact solution."""

from __future__ import annotations

import math

import numpy as np
import pytest
from tests.oracles import bouncing_ball, impact_pair, shaken_box
from tests.reference.simulator import simulate
from tests.reference.state import State


@pytest.mark.parametrize("shaking", [1.1, 1.5])
def test_stable_bounces_attract_a_followed_ball(shaking: float) -> None:
    e = 0.5
    low, high = bouncing_ball.stable_shaking(e)
    assert low < shaking < high
    phase = bouncing_ball.impact_phase(shaking, e)
    assert phase is not None
    ball = (phase + 0.01, math.pi)
    for _ in range(300):
        ball = bouncing_ball.next_impact(*ball, shaking, e)
    # Multipliers of modulus below 0.92 leave nothing of 0.01 after 300 bounces; what is left is that the
    # phase has grown to 2000 and carries 2000 ulps.
    assert ball[0] % (2 * math.pi) == pytest.approx(phase, abs=1e-11)
    assert ball[1] == pytest.approx(math.pi, abs=1e-11)


def test_bounces_double_their_period_beyond_the_bound() -> None:
    e = 0.5
    _, high = bouncing_ball.stable_shaking(e)
    assert abs(bouncing_ball.multipliers(high, e)[1] + 1) < 1e-12 or (
        abs(bouncing_ball.multipliers(high, e)[0] + 1) < 1e-12
    )
    shaking = 1.02 * high
    phase = bouncing_ball.impact_phase(shaking, e)
    assert phase is not None
    ball = (phase + 1e-3, math.pi)
    speeds = []
    for _ in range(400):
        ball = bouncing_ball.next_impact(*ball, shaking, e)
        speeds.append(ball[1])
    assert speeds[-1] == pytest.approx(speeds[-3], abs=1e-9)
    assert abs(speeds[-1] - speeds[-2]) > 0.1


def test_ball_multipliers_are_those_of_the_followed_map() -> None:
    e, shaking, h = 0.6, 1.0, 1e-5
    phase = bouncing_ball.impact_phase(shaking, e)
    assert phase is not None
    columns = []
    for step in ((h, 0.0), (0.0, h)):
        ahead = bouncing_ball.next_impact(phase + step[0], math.pi + step[1], shaking, e)
        behind = bouncing_ball.next_impact(phase - step[0], math.pi - step[1], shaking, e)
        columns.append([(a - b) / (2 * h) for a, b in zip(ahead, behind, strict=True)])
    found = np.sort_complex(np.linalg.eigvals(np.array(columns).T))
    # Central differences: h^2 times a third derivative of order 10, and rounding 1e-15/h.
    expected = np.sort_complex(np.array(bouncing_ball.multipliers(shaking, e)))
    np.testing.assert_allclose(found, expected, atol=1e-8)


def test_chatter_duration_is_the_sum_of_the_flights() -> None:
    speed, e, total = 0.7, 0.6, 0.0
    for _ in range(100):
        total += 2 * speed / 1.3
        speed *= e
    assert bouncing_ball.chatter_duration(0.7, 1.3, 0.6) == pytest.approx(total, rel=1e-14)


def test_plastic_box_orbit_is_reached_by_a_locked_mass() -> None:
    r, delta = 0.9, 0.5
    orbit = shaken_box.plastic_orbit(r, delta)
    # Friction above r^2 and a mass ratio of nothing: the mass never moves. The orbit is reached in one cycle.
    run = simulate(0.0038, r, 1.2, (delta, 0.0, 1e-20), cycles=3, digits=30)
    again = simulate(0.0038, r, 1.2, (delta, 0.0, 1e-20), cycles=1, digits=30, start=run["end"])
    assert again["attachments"] == 2
    assert float(again["max_impact_speed"]) == pytest.approx(orbit.impact_speed, rel=1e-14)


def test_rebound_box_orbit_is_reached_by_a_locked_mass() -> None:
    r, delta, e = 0.9, 2.0, 0.6
    orbit = next(o for o in shaken_box.rebound_orbits(r, delta, e) if abs(o.multipliers[0]) < 1)
    # Left at rest the particle would never be met, delta being above 1: set out as on the orbit, 1 % too fast.
    flown = -orbit.phase % (2 * math.pi)
    gap = -(math.sin(orbit.phase) - delta + orbit.particle_speed / r * flown)
    on_orbit = State(0.0, 0.0, 0.0, gap, 1.01 * orbit.particle_speed)
    run = simulate(0.0038, r, 1.2, (delta, e, 1e-20), cycles=60, digits=None, start=on_orbit)
    again = simulate(0.0038, r, 1.2, (delta, e, 1e-20), cycles=1, digits=None, start=run["end"])
    assert again["impacts"] == 2
    # The multipliers' modulus, e^2 = 0.36, to the power 60 leaves nothing but rounding.
    assert again["max_impact_speed"] == pytest.approx(orbit.impact_speed, rel=1e-12)


@pytest.mark.parametrize(("delta", "e"), [(2.0, 0.3), (2.0, 0.8), (5.0, 0.6)])
def test_box_is_the_weightless_limit_of_the_impact_pair(delta: float, e: float) -> None:
    r = math.sqrt(2)  # where the undamped structure moves by exactly the base's amplitude
    boxes = shaken_box.rebound_orbits(r, delta, e)
    pairs = impact_pair.two_impacts_per_cycle(0.0, r, delta, e, 0.0)
    assert len(boxes) == len(pairs) == 2
    for box, pair in zip(boxes, pairs, strict=True):
        assert pair.particle_speed == pytest.approx(box.particle_speed, rel=1e-13)
        assert pair.impact_speed == pytest.approx(box.impact_speed, rel=1e-13)
        assert pair.amplitude_ratio == pytest.approx(1.0, rel=1e-13)
        for multiplier in box.multipliers:  # the other two are the structure's own, on the unit circle
            miss = min(abs(multiplier - other) for other in pair.multipliers)
            assert miss < 1e-11 * max(1, abs(multiplier))
