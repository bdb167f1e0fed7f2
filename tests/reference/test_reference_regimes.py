"""The simulator's regimes against a method that knows none: Moreau's time-stepping."""

from __future__ import annotations

import math

import pytest
from tests.reference.simulator import simulate
from tests.worker.forms import night

Scene = tuple[float, float, float, tuple[float, float, float]]


def time_stepping(scene: Scene, cycles: int, steps_per_cycle: int) -> tuple[float, float, float, float]:
    """Return u, u', p, p' by first-order steps that decide stick, contact and release by impulses alone.

    In each step the friction impulse is the one in [-gamma h, gamma h] that stops the slip if it can, and the
    wall's impulse is the one >= 0 that turns the approach speed w into at least -e w (J. J. Moreau, Unilateral
    contact and dry friction in finite freedom dynamics, 1988).
    """
    zeta, r, gamma, (delta, e, beta) = scene
    h = 2 * math.pi / r / steps_per_cycle
    u = u_rate = p = p_rate = 0.0
    for step in range(cycles * steps_per_cycle):
        u += h / 2 * u_rate
        p += h / 2 * p_rate
        phase = 2 * math.pi * (step + 0.5) / steps_per_cycle
        base, base_rate = math.sin(phase), r * math.cos(phase)
        after = r * math.cos(phase + r * h / 2)
        free = u_rate - h * (2 * zeta * (u_rate - base_rate) + u - base)
        wall = 1 if u - p >= delta else -1 if u - p <= -delta else 0
        approach = wall * (u_rate - p_rate)
        blow = friction = 0.0
        for _ in range(60):
            old = friction
            friction = min(gamma * h, max(-gamma * h, free - wall * blow - after))
            if wall:
                speed = wall * (free - friction - p_rate)
                blow = max(0.0, (speed + e * max(approach, 0.0)) * beta / (1 + beta))
            if friction == old:
                break
        u_rate = free - friction - wall * blow
        p_rate += wall * blow / beta
        u += h / 2 * u_rate
        p += h / 2 * p_rate
    return u, u_rate, p, p_rate


@pytest.mark.parametrize(
    "scene",
    [
        (0.0038, 0.9, 0.8, (0.3, 0.1, 0.1)),  # chatter, attached while slipping and stuck
        night((0.0038, 0.5, 0.2, (0.5, 0.0, 0.1))),  # plastic impacts, attached to a stuck mass
        night((0.05, 0.8, 0.5, (0.3, 0.47, 0.3))),  # chatter to attachment while slipping
        night((0.0038, 0.5, 0.22, (0.2, 0.1, 1.0))),  # a heavy particle
        night((0.0038, 0.9, 1.2, (0.5, 0.1, 0.1))),  # a mass moved by blows alone
    ],
)
def test_time_stepping_converges_to_the_reference(scene: Scene) -> None:
    truth = simulate(*scene, 2, digits=None)
    assert truth["attachments"] > 0
    steps = 40_000
    found = time_stepping(scene, 2, steps)
    error = max(abs(a - truth[name]) for a, name in zip(found, ("u", "u_rate", "p", "p_rate"), strict=True))
    # First order in the step; the forces that it holds still for a step are of order 1.
    assert error < 2 * math.pi / scene[1] / steps
