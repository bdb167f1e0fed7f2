"""Symmetric motion of a particle impact damper with two impacts per excitation cycle.

S. F. Masri and T. K. Caughey, On the stability of the impact damper, J. Appl. Mech. 33 (1966); C. N. Bapat and S.
Sankar, Single unit impact damper in free and forced vibration, J. Sound and Vibration 99 (1985). Here the motion is
derived for base excitation. u is absolute, with u'' + 2 zeta u' + u = s + 2 zeta s', s = sin(r tau).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from tests.oracles.extrema import largest_magnitude
from tests.oracles.transmissibility import absolute_amplitude


@dataclass(frozen=True)
class ImpactPair:
    """A symmetric motion with impacts half a period apart.

    ``multipliers`` are the four eigenvalues of the monodromy matrix over a full period, the largest first.
    """

    amplitude_ratio: float
    relative_amplitude_ratio: float
    impact_speed: float  # |u' - p'| before an impact
    multipliers: tuple[complex, ...]

    @property
    def floquet_multiplier(self) -> float:
        """Return the largest modulus of the multipliers."""
        return abs(self.multipliers[0])


def two_impacts_per_cycle(
    zeta: float, r: float, delta: float, restitution: float, mass_ratio: float
) -> list[ImpactPair]:
    """Return the symmetric motions with two impacts per cycle, of which at most two exist.

    Let q = p' after the impact at u - p = +delta, so p' = -q before this impact. Momentum and restitution give
    u'(+) = q (1 - e - 2 beta e)/(1 + e), u'(-) = u'(+) + 2 beta q. The flight over half a period gives
    u_0 = delta - pi q/(2 r). Between impacts u = a cos rt + b sin rt + exp(-zeta t)(c cos wt + d sin wt) with
    a^2 + b^2 = H^2, H the transmissibility. Antisymmetry over half a period makes c, d and b proportional to
    q, and a = u_0 - c. The remaining equation is quadratic in q.

    A motion is valid if q > 0, and |u - p| < delta between the impacts; other solutions are left out. H must be
    finite (not zeta = 0 with r = 1), friction must be 0, and the multipliers require restitution > 0.
    """
    e, beta = restitution, mass_ratio
    w = math.sqrt(1 - zeta**2)
    half = math.pi / r
    height = absolute_amplitude(zeta, r)
    decay, cos_half, sin_half = math.exp(-zeta * half), math.cos(w * half), math.sin(w * half)
    after = (1 - e - 2 * beta * e) / (1 + e)
    one, two = 1 + decay * cos_half, decay * sin_half
    c1, d1 = np.linalg.solve([[one, two], [-zeta * one - w * two, w * one - zeta * two]], [0.0, -2 * beta])
    b1 = (after + zeta * c1 - w * d1) / r
    k = math.pi / (2 * r) + c1
    roots = np.roots([b1**2 + k**2, -2 * delta * k, delta**2 - height**2])
    found = []
    for root in roots:
        q = float(root.real)
        if abs(root.imag) > 1e-12 * abs(root) or q <= 0:
            continue
        u_start = delta - math.pi * q / (2 * r)
        coefficients = (u_start - c1 * q, b1 * q, c1 * q, d1 * q)
        motion = _check(zeta, r, delta, e, beta, q, coefficients)
        if motion is not None:
            found.append(motion)
    return found


def _check(
    zeta: float,
    r: float,
    delta: float,
    e: float,
    beta: float,
    q: float,
    coefficients: tuple[float, float, float, float],
) -> ImpactPair | None:
    """Return the motion with the given coefficients, or None if the particle would leave its cavity."""
    a, b, c, d = (float(x) for x in coefficients)
    w = math.sqrt(1 - zeta**2)
    half = math.pi / r

    def u(t: np.ndarray) -> np.ndarray:
        free = np.exp(-zeta * t) * (c * np.cos(w * t) + d * np.sin(w * t))
        return a * np.cos(r * t) + b * np.sin(r * t) + free

    def u_rate(t: np.ndarray) -> np.ndarray:
        free = (w * d - zeta * c) * np.cos(w * t) - (w * c + zeta * d) * np.sin(w * t)
        return r * (b * np.cos(r * t) - a * np.sin(r * t)) + np.exp(-zeta * t) * free

    # a cos rt + b sin rt is the response to sin(rt + phase): H sin(rt + phase - lag) with H, lag from
    # (1 + 2 zeta i r) / (1 - r^2 + 2 zeta i r).
    drag = 2 * zeta * r
    lag = math.atan2(drag, 1 - r**2) - math.atan2(drag, 1.0)
    phase = math.atan2(a, b) + lag
    inside = np.linspace(0, half, 4001)[1:-1]
    gap = u(inside) - (a + c - delta + q * inside)
    if np.any(np.abs(gap) >= delta):
        return None
    u_before = -float(u_rate(np.asarray(half)))  # velocity before the impact at t = 0, from antisymmetry
    u_after = float(u_rate(np.asarray(0.0)))

    def acceleration(u_rate_now: float) -> float:
        base, base_rate = math.sin(phase), r * math.cos(phase)
        return -2 * zeta * (u_rate_now - base_rate) - ((a + c) - base)

    before = np.array([u_before, acceleration(u_before), -q, 0.0])
    behind = np.array([u_after, acceleration(u_after), q, 0.0])
    jump = np.eye(4)
    jump[1, 1], jump[1, 3] = (1 - beta * e) / (1 + beta), beta * (1 + e) / (1 + beta)
    jump[3, 1], jump[3, 3] = (1 + e) / (1 + beta), (beta - e) / (1 + beta)
    normal = np.array([1.0, 0.0, -1.0, 0.0])
    saltation = jump + np.outer(behind - jump @ before, normal) / (normal @ before)
    flow = np.eye(4)
    decay, cos_half, sin_half = math.exp(-zeta * half), math.cos(w * half), math.sin(w * half)
    flow[0, 0], flow[0, 1] = decay * (cos_half + zeta / w * sin_half), decay * sin_half / w
    flow[1, 0], flow[1, 1] = -decay * sin_half / w, decay * (cos_half - zeta / w * sin_half)
    flow[2, 3] = half
    # The system is odd, so both half periods have the same matrix.
    multipliers = np.linalg.eigvals(saltation @ flow) ** 2
    multipliers = multipliers[np.argsort(-np.abs(multipliers))]

    def v(t: np.ndarray) -> np.ndarray:
        return u(t) - np.sin(r * t + phase)

    return ImpactPair(
        amplitude_ratio=largest_magnitude(u, u_rate, 0.0, half),
        relative_amplitude_ratio=largest_magnitude(
            v, lambda t: u_rate(t) - r * np.cos(r * t + phase), 0.0, half
        ),
        impact_speed=u_before + q,
        multipliers=tuple(complex(x) for x in multipliers),
    )
