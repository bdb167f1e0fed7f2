"""A ball under gravity on a table that moves as A sin(omega t).

P. J. Holmes, The dynamics of repeated impacts with a sinusoidally vibrating table, J. Sound and Vibration 84
(1982); N. B. Tufillaro, T. Abbott and J. Reilly, An Experimental Approach to Nonlinear Dynamics and Chaos
(1992), chapter 1. Here exact: the table's displacement during the flight is not neglected. Gravity and
frequency are 1; `shaking` is A omega^2/g.
"""

from __future__ import annotations

import math

import numpy as np


def impact_phase(shaking: float, restitution: float, periods: int = 1) -> float | None:
    """Return the phase [rad] of the impacts that recur after `periods` table periods, or None.

    Every flight ends where it began, so it lasts 2 v/g = 2 pi n/omega; restitution then asks for
    cos(phase) = pi n (1 - e) / ((1 + e) A omega^2/g). The stable branch is the one on the rising table with
    sin(phase) > 0. Valid if the ball clears the table on the way, which holds for the stable branch.
    """
    cosine = math.pi * periods * (1 - restitution) / ((1 + restitution) * shaking)
    return math.acos(cosine) if cosine <= 1 else None


def multipliers(shaking: float, restitution: float, periods: int = 1) -> tuple[complex, complex]:
    """Return the eigenvalues of the impact map at `impact_phase`.

    Its trace is 1 + e^2 - (1 + e)^2 Gamma sin(phase), Gamma = A omega^2/g; its determinant e^2.
    """
    phase = impact_phase(shaking, restitution, periods)
    if phase is None:
        raise ValueError(f"no motion of {periods} periods at shaking = {shaking}")
    trace = 1 + restitution**2 - (1 + restitution) ** 2 * shaking * math.sin(phase)
    root = np.sqrt(complex(trace**2 / 4 - restitution**2))
    return complex(trace / 2 + root), complex(trace / 2 - root)


def stable_shaking(restitution: float, periods: int = 1) -> tuple[float, float]:
    """Return the range of A omega^2/g in which the motion of `periods` periods exists and is stable.

    From |trace| < 1 + det: 0 < Gamma sin(phase) < 2 (1 + e^2)/(1 + e)^2, with Gamma cos(phase) =
    pi n (1 - e)/(1 + e). At the upper end it doubles its period.
    """
    low = math.pi * periods * (1 - restitution) / (1 + restitution)
    return low, math.hypot(low, 2 * (1 + restitution**2) / (1 + restitution) ** 2)


def chatter_duration(speed: float, deceleration: float, restitution: float) -> float:
    """Return the time until a ball that leaves with `speed` under constant `deceleration` rests on the table.

    Flights of 2 v/a, each e times the last: 2 v/(a (1 - e)). Valid for e < 1 and a constant acceleration.
    """
    return 2 * speed / (deceleration * (1 - restitution))


def next_impact(phase: float, speed: float, shaking: float, restitution: float) -> tuple[float, float]:
    """Return phase [rad] and take-off speed of the next impact, by following one flight.

    Independent of the formulas above: brackets and bisects the ball's height over the table. Speeds are in
    g/omega.
    """

    def height(t: float) -> float:
        return shaking * (math.sin(phase) - math.sin(phase + t)) + speed * t - t * t / 2

    step = 1e-3
    t = step
    while height(t) > 0:
        t += step
    low, high = t - step, t
    for _ in range(80):
        middle = (low + high) / 2
        low, high = (middle, high) if height(middle) > 0 else (low, middle)
    table = shaking * math.cos(phase + high)
    return phase + high, (1 + restitution) * table - restitution * (speed - high)
