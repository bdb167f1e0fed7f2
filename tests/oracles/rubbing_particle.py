"""Integrates a structure on a moving base, with a particle that has friction and weight in its cavity.

SciPy's DOP853 integrates the equations of motion between events in absolute coordinates. To find which of the two
bodies slip, every combination is tried, and the combination with the smallest contradiction is taken. The module
shares no code with the solver.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from functools import cached_property
from itertools import product
from math import cos, inf, pi, sin

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

Floats = NDArray[np.float64]

TIE = 1e-7
"""Delay after an event with equal velocities, before the slipping bodies are determined."""
STEP = 1e-4
"""Delay after an event with equal velocities, before events are searched again."""


@dataclass(frozen=True)
class Mode:
    """Directions of slip of the structure on its base and of the particle in its cavity, 0 for a body that sticks.

    `wall` is the wall that pushes the particle, 0 without contact.
    """

    slip: float
    slide: float
    wall: float = 0.0


@dataclass(frozen=True)
class RubbingParticle:
    """Ratios of a design point. `gravity` acts towards negative u."""

    damping_ratio: float
    frequency_ratio: float
    friction: float
    clearance: float
    restitution: float
    mass: float
    rubs: float
    gravity: float = 0.0

    LONGEST = 0.05
    FIRST = 2e-4
    """First step of the integrator. A flight that ends within this step is missed."""
    AHEAD = 0.0
    """Delay with which the mode of bodies without relative velocity is determined."""
    SLOWEST = -1.0
    """Rebound speed up to which the integration fails."""

    def start(self) -> tuple[Floats, float]:
        """Return u, u', p, p' at rest, and the wall that supports the particle."""
        if self.gravity > 0.0:
            return np.array([0.0, 0.0, -self.clearance, 0.0]), 1.0
        return np.zeros(4), 0.0

    def base(self, t: float) -> tuple[float, float, float]:
        """Return displacement, velocity and acceleration of the base."""
        r = self.frequency_ratio
        return sin(r * t), r * cos(r * t), -r * r * sin(r * t)

    def spring(self, t: float, y: Floats) -> float:
        """Return the force of spring and dashpot on the structure."""
        s, rate, _ = self.base(t)
        return -float(2.0 * self.damping_ratio * (y[1] - rate) + (y[0] - s))

    def accelerations(self, t: float, y: Floats, mode: Mode) -> tuple[float, float]:
        """Return the accelerations u'' and p'' in a mode."""
        carried = mode.slide == 0.0
        inertia = 1.0 + self.mass if carried else 1.0
        of_particle = 0.0 if carried else self.mass * (self.gravity - self.rubs * mode.slide)
        held = self.friction > 0.0 and mode.slip == 0.0
        force = self.spring(t, y) - self.friction * mode.slip + of_particle
        u = self.base(t)[2] if held else force / inertia
        return u, u if carried else self.rubs * mode.slide - self.gravity

    def contradiction(self, t: float, y: Floats, mode: Mode, slips: bool, slides: bool) -> float:
        """Return a number that is positive if the mode is impossible.

        `slips` and `slides` state whether the relative velocity of the structure and of the particle differs from 0.
        """
        u, p = self.accelerations(t, y, mode)
        found = -inf
        if self.friction > 0.0 and mode.slip == 0.0:
            inertia = 1.0 + self.mass if mode.slide == 0.0 else 1.0
            pull = 0.0 if mode.slide == 0.0 else self.mass * (self.gravity - self.rubs * mode.slide)
            found = max(found, abs(self.spring(t, y) + pull - inertia * u) - self.friction)
        elif self.friction > 0.0 and not slips:
            found = max(found, -mode.slip * (u - self.base(t)[2]))
        if mode.slide == 0.0:
            found = max(found, self._torn(u, mode))
        elif not slides:
            found = max(found, -mode.slide * (u - p), inf if mode.slide == mode.wall else -inf)
        return found

    def _torn(self, u: float, mode: Mode) -> float:
        if mode.wall:
            return -(mode.wall * (u + self.gravity) + self.rubs)
        return abs(u + self.gravity) - self.rubs

    def mode(self, t: float, y: Floats, at_rest: bool, together: bool, wall: float) -> Mode:
        """Return the mode of the motion after an event."""
        slips = (0.0, 1.0, -1.0) if at_rest else (float(np.sign(y[1] - self.base(t)[1])),)
        slides = (0.0, 1.0, -1.0) if together else (float(np.sign(y[1] - y[3])),)
        modes = [Mode(a if self.friction > 0.0 else 1.0, b, wall) for a, b in product(slips, slides)]
        return min(modes, key=lambda mode: self.contradiction(t, y, mode, not at_rest, not together))

    def flow(self, mode: Mode) -> Callable[[float, Floats], list[float]]:
        """Return the right-hand side of the equations of motion in a mode."""

        def rates(t: float, y: Floats) -> list[float]:
            u, p = self.accelerations(t, y, mode)
            return [y[1], u, y[3], p]

        return rates

    def events(self, mode: Mode) -> dict[str, Callable[[float, Floats], float]]:
        """Return the functions that fall through zero at the end of a mode, by the name of the event."""
        found: dict[str, Callable[[float, Floats], float]] = {}
        if self.friction > 0.0:
            if mode.slip == 0.0:
                found["onset"] = lambda t, y: (
                    -self.contradiction(t, y, Mode(0.0, mode.slide, mode.wall), True, True)
                )
            else:
                found["turn"] = lambda t, y: mode.slip * (y[1] - self.base(t)[1])
        if mode.slide == 0.0:
            found["torn"] = lambda t, y: -self._torn(self.accelerations(t, y, mode)[0], mode)
        else:
            found["rest"] = lambda t, y: mode.slide * (y[1] - y[3])
            found["behind"] = lambda t, y: self.clearance - (y[0] - y[2])
            found["ahead"] = lambda t, y: self.clearance + (y[0] - y[2])
        return found

    def march(self, cycles: int) -> tuple[Floats, int]:
        """Integrate whole cycles from rest; return u, u', p, p' at the end, and the number of impacts."""
        return self._through([2.0 * pi * cycles / self.frequency_ratio])

    def _through(self, ends: Iterable[float]) -> tuple[Floats, int]:
        """Integrate from rest, in pieces that end at the given times."""
        y, wall = self.start()
        t, impacts, at_rest, together = 0.0, 0, y[1] == self.base(0.0)[1], True
        for end in ends:
            while t < end - 1e-12:
                ahead = self.AHEAD if at_rest or together else 0.0
                mode = self.mode(t + ahead, y, at_rest, together, wall)
                t, y, event = self._step(t, end, y, mode)
                at_rest, together = mode.slip == 0.0, mode.slide == 0.0
                if event == "turn":
                    at_rest, y[1] = True, self.base(t)[1]
                elif event == "rest":
                    together, y[3], wall = True, y[1], 0.0
                elif event in ("behind", "ahead"):
                    wall = 1.0 if event == "behind" else -1.0
                    impacts += 1
                    at_rest, together = False, self.restitution == 0.0
                    y = self._struck(y, wall)
                elif event in ("onset", "torn"):
                    after = self.mode(t + TIE, self._on(t, TIE, y, mode), at_rest, together, wall)
                    y, t = self._on(t, STEP, y, after), t + STEP
                    at_rest, together = after.slip == 0.0, after.slide == 0.0
                    wall = wall if together else 0.0
        return y, impacts

    def _struck(self, y: Floats, wall: float) -> Floats:
        e, b = self.restitution, self.mass
        assert e * abs(y[1] - y[3]) > self.SLOWEST, "the particle chatters"
        u = ((1.0 - b * e) * y[1] + b * (1.0 + e) * y[3]) / (1.0 + b)
        p = ((1.0 + e) * y[1] + (b - e) * y[3]) / (1.0 + b)
        return np.array([y[0], u, y[0] - wall * self.clearance, u if e == 0.0 else p])

    def _on(self, t: float, time: float, y: Floats, mode: Mode) -> Floats:
        found = solve_ivp(self.flow(mode), (t, t + time), y, method="DOP853", rtol=1e-13, atol=1e-15)
        return np.asarray(found.y[:, -1])

    def _step(self, t: float, end: float, y: Floats, mode: Mode) -> tuple[float, Floats, str]:
        """Integrate a mode until the first event or until `end`."""
        named = self.events(mode)
        functions = list(named.values())
        for function in functions:
            function.terminal, function.direction = True, -1  # type: ignore[attr-defined]
        found = solve_ivp(
            self.flow(mode),
            (t, end),
            y,
            method="DOP853",
            rtol=3e-14,
            atol=1e-14,
            events=functions,
            max_step=self.LONGEST,
            first_step=min(self.FIRST, (end - t) / 2),
        )
        hit = [name for name, times in zip(named, found.t_events, strict=True) if len(times)]
        return float(found.t[-1]), found.y[:, -1].copy(), hit[0] if hit else ""


@dataclass(frozen=True)
class UnderRecord(RubbingParticle):
    """A design point under a base acceleration that is linear between samples. Chatter is not supported.

    Parameters
    ----------
    acceleration : ndarray, shape (samples,)
        Base acceleration s'' at the samples; the first sample is 0.
    step : float
        Time between samples.
    """

    acceleration: Floats = field(default_factory=lambda: np.zeros(2))
    step: float = 1.0

    AHEAD = 1e-9
    SLOWEST = 2e-3

    @cached_property
    def sampled(self) -> tuple[Floats, Floats]:
        """Displacement and velocity of the base at the samples."""
        a, h = self.acceleration, self.step
        rate = np.concatenate(([0.0], np.cumsum(h * (a[:-1] + a[1:]) / 2)))
        return np.concatenate(([0.0], np.cumsum(h * (rate[:-1] + h * (2 * a[:-1] + a[1:]) / 6)))), rate

    def base(self, t: float) -> tuple[float, float, float]:
        """Return displacement, velocity and acceleration of the base."""
        k = min(int(t / self.step + 1e-9), self.acceleration.size - 2)
        h, a, (place, rate) = t - k * self.step, self.acceleration[k], self.sampled
        jerk = (self.acceleration[k + 1] - a) / self.step
        moved = place[k] + h * (rate[k] + h * (a / 2 + jerk * h / 6))
        return moved, rate[k] + h * (a + jerk * h / 2), a + jerk * h

    def run(self) -> tuple[Floats, int]:
        """Integrate from rest to the last sample, in pieces over which the acceleration is linear."""
        return self._through(self.step * np.arange(1, self.acceleration.size))
