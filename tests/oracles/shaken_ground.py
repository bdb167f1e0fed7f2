"""Computes responses to a piecewise linear base acceleration independently of the solver.

All values are in SI units. The motion is the closed form of a damped oscillator under a linear force, and roots are
bracketed on a dense scan. For linear systems, SciPy's matrix exponential is used. The solver shares no code with this
module; it uses dimensionless values and power series, and proves that no root is missed.
"""

import itertools
from dataclasses import dataclass
from math import cos, exp, inf, sin, sqrt

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm
from scipy.optimize import brentq, minimize_scalar

_SCAN = 24  # number of parts of a sample interval
_JOIN = 1e-7  # rebound speed below which a chatter ends [m/s]; the error is proportional to its square


@dataclass
class End:
    """Final state and measures of a run, in SI units."""

    relative_displacement: float
    relative_velocity: float
    peak_relative_displacement: float
    impacts: int = 0
    impact_speed_max: float = 0.0
    stuck: float = 0.0


def linear_end(
    omega: float,
    zeta: float,
    samples: NDArray[np.float64],
    step: float,
    absorber: tuple[float, float, float] | None = None,
) -> dict[str, float]:
    """Return final displacement and velocity, peak displacement and peak acceleration of a linear structure.

    `absorber` is (mass ratio, frequency, damping). Displacements x of the structure and y of the absorber are relative
    to the base. The state also contains the base acceleration and its constant rate of change, so that the matrix
    exponential is exact over an interval.
    """
    mu, omega_a, zeta_a = absorber or (0.0, omega, 0.0)
    k, c = omega**2, 2 * zeta * omega
    ka, ca = mu * omega_a**2, 2 * zeta_a * mu * omega_a
    m = np.zeros((6, 6))
    m[0, 1] = m[2, 3] = m[4, 5] = 1.0
    m[1] = [-(k + ka), -(c + ca), ka, ca, -1.0, 0.0]
    if mu > 0:
        m[3] = [ka / mu, ca / mu, -ka / mu, -ca / mu, -1.0, 0.0]
    whole = expm(m * step)
    parts = [expm(m * step * i / 32) for i in range(33)]
    state = np.zeros(6)
    rows = (np.eye(6)[0], m[1] + np.eye(6)[4])  # relative displacement; absolute acceleration
    best: list[tuple[float, NDArray[np.float64], int]] = [(-1.0, state, 0)] * 2
    for a, b in itertools.pairwise(samples):
        state[4], state[5] = a, (b - a) / step
        inside = np.array([part @ state for part in parts])
        for which, row in enumerate(rows):
            values = np.abs(inside @ row)
            top = int(values.argmax())
            if values[top] > best[which][0]:
                best[which] = (float(values[top]), state.copy(), top)
        state = whole @ state
    peaks = []
    for which, row in enumerate(rows):
        value, at, top = best[which]
        span = (step * max(top - 1, 0) / 32, step * min(top + 1, 32) / 32)
        found = minimize_scalar(
            lambda t, at=at, row=row: -abs(row @ expm(m * t) @ at),
            bounds=span,
            method="bounded",
            options={"xatol": 1e-10},
        )
        peaks.append(max(value, -found.fun))
    return {"x": state[0], "x_rate": state[1], "peak": peaks[0], "peak_acceleration": peaks[1]}


class Shaken:
    """One run of a structure with friction, a particle, or both, from rest.

    Parameters
    ----------
    omega, zeta : float
        Natural angular frequency ω_n [rad/s] and damping ratio ζ.
    friction : float
        Friction F_f/M [m/s²]; 0 without friction.
    particle : (float, float, float) or None
        Clearance d [m], restitution e and mass ratio m/M; None without a particle.
    """

    def __init__(
        self, omega: float, zeta: float, friction: float, particle: tuple[float, float, float] | None
    ) -> None:
        self.omega, self.zeta, self.friction, self.particle = omega, zeta, friction, particle
        self.v = self.w = self.z_rate = self.gap = self.p_rate = 0.0
        self.wall = 0
        self.slip = 0
        self.out = End(0.0, 0.0, 0.0)

    def run(self, samples: NDArray[np.float64], step: float) -> End:
        """Integrate over a record [m/s²]."""
        self.decide(samples[0])
        for a, b in itertools.pairwise(samples):
            self.interval(a, (b - a) / step, step)
        self.out.relative_displacement, self.out.relative_velocity = self.v, self.w
        return self.out

    # the closed form between events

    def motion(self, a: float, j: float, h: float) -> tuple[float, float, float]:
        """Return v, v' and the absolute acceleration after a time h, if no event occurs."""
        if self.held:
            return self.v, 0.0, a + j * h
        k, c = self.omega**2 / self.mass, 2 * self.zeta * self.omega / self.mass
        force = -a - self.slip * self.friction / self.mass
        # particular solution B + Ch of v'' + c v' + k v = force − j h
        C = -j / k
        B = (force - c * C) / k
        decay = c / 2
        fast = sqrt(k - decay**2)
        P = self.v - B
        Q = (self.w - C + decay * P) / fast
        e, co, si = exp(-decay * h), cos(fast * h), sin(fast * h)
        v = B + C * h + e * (P * co + Q * si)
        w = C + e * ((fast * Q - decay * P) * co - (fast * P + decay * Q) * si)
        return v, w, -c * w - k * v - self.slip * self.friction / self.mass

    @property
    def held(self) -> bool:
        return self.friction > 0 and self.slip == 0

    @property
    def mass(self) -> float:
        """Of what moves, over that of the structure."""
        return 1.0 + (self.particle[2] if self.wall and self.particle else 0.0)

    def room(self, sign: int, a: float, j: float, h: float) -> float:
        """Return the distance of the particle from a wall after a time h, computed from the present distance."""
        assert self.particle is not None
        now = self.particle[0] - sign * self.gap
        moved = self.motion(a, j, h)[0] - self.v + (self.z_rate - self.p_rate + a * h / 2 + j * h * h / 6) * h
        return now - sign * moved

    def closes(self, name: str, a: float, j: float, h: float) -> bool:
        """Return whether mass and particle approach each other at a wall.

        At a wall that the particle has just left, rounding may cause a root without such an approach.
        """
        relative = self.motion(a, j, h)[1] + self.z_rate + a * h + j * h * h / 2 - self.p_rate
        return (relative > 0) == (name == "wall+")

    def hold(self, acceleration: float) -> float:
        return -self.mass * acceleration - self.omega**2 * self.v

    def decide(self, acceleration: float) -> None:
        """Decide whether the mass slips or sticks at v' = 0, and whether the particle remains in contact."""
        if self.friction > 0:
            force = self.hold(acceleration)
            self.slip = 0 if abs(force) <= self.friction else (1 if force > 0 else -1)
        if self.wall and self.wall * self.motion(acceleration, 0.0, 0.0)[2] < 0:
            self.p_rate, self.wall = self.w + self.z_rate, 0
            self.decide(acceleration)

    def watches(self, a: float, j: float):
        found = []
        if self.held:
            found += [
                ("loose", lambda h, s=sign: self.friction - s * self.hold(a + j * h)) for sign in (1, -1)
            ]
        elif self.friction > 0:
            found.append(("turn", lambda h: self.slip * self.motion(a, j, h)[1]))
        else:
            sign = self.heading
            found.append(("extremum", lambda h: sign * self.motion(a, j, h)[1]))
        if self.particle and self.wall:
            found.append(("release", lambda h: self.wall * self.motion(a, j, h)[2]))
        elif self.particle:
            found += [
                ("wall+" if sign > 0 else "wall-", lambda h, s=sign: self.room(s, a, j, h))
                for sign in (1, -1)
            ]
        return found

    def interval(self, a: float, j: float, step: float) -> None:
        """Integrate over one sample interval, from event to event."""
        left = step
        while left > 0:
            w0, a0 = self.motion(a, j, 0.0)[1:]
            relative = a0 - a
            self.heading = 1 if w0 > 0 or (w0 == 0 and relative >= 0) else -1
            watches = self.watches(a, j)
            early = left / _SCAN * 0.5 ** np.arange(20, 0, -1)  # flights of a chatter are short
            scan = np.arange(1, _SCAN + 1) * left / _SCAN
            first, event = inf, ""
            for name, function in watches:
                start = early if name.startswith("wall") else [1e-13 * step]
                grid = np.concatenate((start, scan))
                before = function(grid[0])
                for low, high in itertools.pairwise(grid):
                    after = function(high)
                    if before > 0 >= after and (not name.startswith("wall") or self.closes(name, a, j, high)):
                        root = brentq(function, low, high, xtol=1e-18, rtol=9e-16)
                        if root < first:
                            first, event = root, name
                        break
                    before = after
                    if high > first:
                        break
            h = min(first, left)
            self.advance(a, j, h)
            a, left = a + j * h, left - h
            if event and first <= h:
                self.carry_out(event, a)
            if event == "" or first > h:
                return

    def advance(self, a: float, j: float, h: float) -> None:
        if self.held:
            self.out.stuck += h
        v, w, _ = self.motion(a, j, h)
        self.gap += v - self.v + (self.z_rate - self.p_rate + a * h / 2 + j * h * h / 6) * h
        self.z_rate += a * h + j * h * h / 2
        self.v, self.w = v, w
        if self.wall and self.particle:
            self.gap, self.p_rate = self.wall * self.particle[0], w + self.z_rate
        if self.particle and not self.wall:
            assert abs(self.gap) <= self.particle[0] * (1 + 1e-6), "the scan missed an impact"
        self.out.peak_relative_displacement = max(self.out.peak_relative_displacement, abs(v))

    def carry_out(self, event: str, acceleration: float) -> None:
        if event == "turn":
            self.w = 0.0
            self.decide(acceleration)
        elif event == "loose":
            self.slip = 1 if self.hold(acceleration) > 0 else -1
        elif event == "release":
            self.wall = 0
        elif event.startswith("wall"):
            assert self.particle is not None
            d, e, beta = self.particle
            wall = 1 if event == "wall+" else -1
            u_rate = self.w + self.z_rate
            approach = u_rate - self.p_rate
            self.out.impacts += 1
            self.out.impact_speed_max = max(self.out.impact_speed_max, abs(approach))
            joined = (u_rate + beta * self.p_rate) / (1 + beta)
            self.gap = wall * d
            after = joined - beta * e * approach / (1 + beta)
            self.p_rate = joined + e * approach / (1 + beta)
            if e * abs(approach) < _JOIN:
                after = self.p_rate = joined
                self.wall = wall
            self.w = after - self.z_rate
            if self.friction > 0 and self.w != 0:
                self.slip = 1 if self.w > 0 else -1
            if self.wall and self.wall * self.motion(acceleration, 0.0, 0.0)[2] < 0:
                self.wall = 0
