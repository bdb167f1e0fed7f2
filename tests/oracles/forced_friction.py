"""Exact steady states of a base-excited oscillator with Coulomb and viscous damping.

The relative displacement v obeys Den Hartog's equation of a forced oscillator with force amplitude r^2: v'' + 2 zeta v'
+ v + gamma Sgn(v') = r^2 cos(r t + phi), where t = 0 is the upper turning point. J. P. Den Hartog, Forced vibrations
with combined Coulomb and viscous friction, Trans. ASME 53 (1931); base-excited form: M. S. Hundal, J. Sound and
Vibration 64 (1979). The solution is derived from the half-period symmetry v(t + pi/r) = -v(t).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq  # type: ignore[import-untyped]
from tests.oracles.extrema import largest_magnitude, zeros


@dataclass(frozen=True)
class FrictionResponse:
    """A steady state in which each half period mirrors the previous half period."""

    amplitude_ratio: float  # X/Z, true peak of |u|
    relative_amplitude_ratio: float  # peak of |v|
    stick_fraction: float  # share of the period spent at v' = 0


@dataclass(frozen=True)
class _Slip:
    """Downward slip: v = gamma + a cos rt + b sin rt + exp(-zeta t)(c cos wt + d sin wt)."""

    zeta: float
    r: float
    gamma: float
    a: float
    b: float
    c: float
    d: float

    @property
    def omega(self) -> float:
        return math.sqrt(1 - self.zeta**2)

    def v(self, t: np.ndarray) -> np.ndarray:
        free = np.exp(-self.zeta * t) * (self.c * np.cos(self.omega * t) + self.d * np.sin(self.omega * t))
        return self.gamma + self.a * np.cos(self.r * t) + self.b * np.sin(self.r * t) + free

    def v_rate(self, t: np.ndarray) -> np.ndarray:
        w, z = self.omega, self.zeta
        free = (w * self.d - z * self.c) * np.cos(w * t) - (w * self.c + z * self.d) * np.sin(w * t)
        forced = self.b * np.cos(self.r * t) - self.a * np.sin(self.r * t)
        return self.r * forced + np.exp(-z * t) * free

    @property
    def phase(self) -> float:
        """Return phi, from the forced part a cos rt + b sin rt = r^2 R cos(r t + phi - lag)."""
        lag = math.atan2(2 * self.zeta * self.r, 1 - self.r**2)
        return lag - math.atan2(self.b, self.a)


def _forced_amplitude(zeta: float, r: float) -> float:
    return r**2 / math.hypot(1 - r**2, 2 * zeta * r)


def _absolute_peak(slip: _Slip, slip_end: float) -> float:
    """Return max |u| over half a period, in which the mass slips until `slip_end` and then sticks until pi/r."""
    r, phase = slip.r, slip.phase

    def base(t: np.ndarray) -> np.ndarray:
        return np.cos(r * t + phase)

    def base_rate(t: np.ndarray) -> np.ndarray:
        return -r * np.sin(r * t + phase)

    peak = largest_magnitude(
        lambda t: slip.v(t) + base(t), lambda t: slip.v_rate(t) + base_rate(t), 0.0, slip_end
    )
    half = math.pi / r
    if slip_end < half:
        held = slip.v(np.asarray(slip_end))
        peak = max(peak, largest_magnitude(lambda t: held + base(t), base_rate, slip_end, half))
    return peak


def non_stop(zeta: float, r: float, gamma: float) -> FrictionResponse | None:
    """Return the steady state that never sticks (Den Hartog), or None if there is no such state.

    The conditions are v = A and v' = 0 at t = 0, and v = -A, v' = 0 at t = pi/r. These conditions give the homogeneous
    part of the solution:

        2 gamma + c + E(c C + d S) = 0,
        (w d - zeta c)(1 + E C) - E S (w c + zeta d) = 0.

    E, C and S are the decay, cosine and sine over half a period. Then b = (zeta c - w d)/r,
    a = sqrt(r^4 R^2 - b^2) and A = gamma + a + c.

    The solution is valid (Den Hartog's exact bound) if b^2 <= r^4 R^2, and v' < 0 throughout the half period. For
    zeta = 0 there is no solution at r = 1/n. If n is odd, the response grows without bound; if n is even, the velocity
    reverses within the half period.
    """
    w = math.sqrt(1 - zeta**2)
    half = math.pi / r
    decay, cos_half, sin_half = math.exp(-zeta * half), math.cos(w * half), math.sin(w * half)
    matrix = np.array(
        [
            [1 + decay * cos_half, decay * sin_half],
            [
                -zeta * (1 + decay * cos_half) - decay * sin_half * w,
                w * (1 + decay * cos_half) - decay * sin_half * zeta,
            ],
        ]
    )
    if abs(np.linalg.det(matrix)) < 1e-14:
        return None
    c, d = (float(x) for x in np.linalg.solve(matrix, [-2 * gamma, 0.0]))
    forced = _forced_amplitude(zeta, r)
    b = (zeta * c - w * d) / r
    if b * b > forced**2:
        return None
    a = math.sqrt(forced**2 - b * b)
    slip = _Slip(zeta, r, gamma, a, b, c, d)
    inside = np.linspace(0, half, 4001)[1:-1]
    if np.any(slip.v_rate(inside) >= 0):
        return None
    return FrictionResponse(_absolute_peak(slip, half), gamma + a + c, 0.0)


def one_stop(zeta: float, r: float, gamma: float) -> FrictionResponse | None:
    """Return the steady state that sticks once in each half period, or None if there is no such state.

    Slip starts from rest at v = A when the force falls to the friction limit, r^2 cos(phi) - A = -gamma, and ends at
    v = -A, v' = 0, before half a period is over. The mass then sticks until the mirrored slip starts. The slip has a
    closed form for each phi, and phi is the zero of v(end) + A.

    The solution is valid if 0 < end <= pi/r, v' < 0 during the slip, and |r^2 cos(r t + phi) - v| <= gamma while stuck.
    """
    half = math.pi / r
    found: list[FrictionResponse] = []

    def slip_from(phi: float) -> tuple[_Slip, float | None]:
        forced, lag = _forced_amplitude(zeta, r), math.atan2(2 * zeta * r, 1 - r**2)
        a, b = forced * math.cos(phi - lag), -forced * math.sin(phi - lag)
        start = gamma + r**2 * math.cos(phi)
        c = start - gamma - a
        slip = _Slip(zeta, r, gamma, a, b, c, (zeta * c - r * b) / math.sqrt(1 - zeta**2))
        turns = zeros(slip.v_rate, 1e-3 * half, 1.2 * half, 1201)  # 1.2, to bracket a root near half a cycle
        return slip, turns[0] if turns else None

    def miss(phi: float) -> float:
        slip, end = slip_from(phi)
        if end is None:
            return math.nan
        return float(slip.v(np.asarray(end)) + slip.v(np.asarray(0.0)))

    phases = np.linspace(1e-3, math.pi - 1e-3, 400)
    misses = [miss(float(phi)) for phi in phases]
    for i in range(len(phases) - 1):
        if not misses[i] * misses[i + 1] < 0:  # also False next to a nan
            continue
        phi = float(brentq(miss, phases[i], phases[i + 1], xtol=1e-14))
        slip, end = slip_from(phi)
        if end is None or end > half or abs(miss(phi)) > 1e-9:
            continue
        stuck = np.linspace(end, half, 500)
        force = r**2 * np.cos(r * stuck + phi) - slip.v(np.asarray(end))
        amplitude = gamma + r**2 * math.cos(phi)
        if amplitude > 0 and np.all(np.abs(force) <= gamma * (1 + 1e-9) + 1e-12):
            found.append(FrictionResponse(_absolute_peak(slip, end), amplitude, 1 - end / half))
    if len(found) > 1:
        raise ArithmeticError(f"{len(found)} solutions with one stop at zeta={zeta}, r={r}, gamma={gamma}")
    return found[0] if found else None
