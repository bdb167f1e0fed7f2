"""Integrates the contact model `compliant` with short Taylor steps in absolute coordinates, as a check on the solver.

This module imports nothing from the project. The steps are short: a fifth of the inverse of the fastest rate, or less.
Every event function is evaluated at the end of each step, and a change of sign is located by bisection. Numbers are
floats, or numbers of mpmath for a reference in extended precision.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import cos, pi, sin
from typing import Any

_FREE_STEP = 0.01
_CONTACT_STEP = 0.2
_SIMPSON = (1, 4, 2, 4, 2, 4, 2, 4, 1)


@dataclass(frozen=True)
class Numbers:
    """A number type, with its constructor, sine, cosine and π.

    `terms` and `bisections` are the numbers of Taylor terms and of bisections that reach the precision of the type.
    """

    of: Callable[[Any], Any]
    sin: Callable[[Any], Any]
    cos: Callable[[Any], Any]
    pi: Any
    terms: int
    bisections: int


FLOATS = Numbers(float, sin, cos, pi, 16, 60)


@dataclass(frozen=True)
class Scene:
    """Ratios of a design point, with wall stiffness relative to k and wall damping relative to k/ω_n.

    The friction ratio may be 0. The excitation is a motion of the base or, if `forced`, a force on the structure.
    """

    damping_ratio: float
    frequency_ratio: float
    friction_ratio: float
    clearance_ratio: float
    mass_ratio: float
    stiffness: float
    damping: float
    forced: bool = False


class March:
    """An integration from rest.

    The particle flies, is pushed by a wall, or is inside a wall that exerts no force. The mass slips or sticks.
    """

    def __init__(self, scene: Scene, numbers: Numbers = FLOATS) -> None:
        of = numbers.of
        self.numbers = numbers
        self.zeta, self.r, self.gamma = (
            of(x) for x in (scene.damping_ratio, scene.frequency_ratio, scene.friction_ratio)
        )
        self.d, self.beta = of(scene.clearance_ratio), of(scene.mass_ratio)
        self.k, self.c = of(scene.stiffness), of(scene.damping)
        mass = self.beta / (1 + self.beta)
        fastest = 1.0 + 2.0 * scene.damping_ratio
        self.free_step = of(_FREE_STEP / max(1.0, scene.frequency_ratio) / fastest)
        rate = max(float((self.k / mass) ** 0.5), float(self.c / mass))
        self.contact_step = min(self.free_step, of(_CONTACT_STEP / rate))
        self.t = of(0)
        self.u, self.u_rate, self.p, self.p_rate = of(0), of(0), of(0), of(0)
        self.side = 0  # wall that the particle penetrates
        self.pushed = False
        self.forced = scene.forced
        self.slip = -1 if self.gamma and not self.forced else 0
        self.held = bool(self.gamma) and self.forced
        self.impacts = self.turns = 0
        self.loss = of(0)

    def _base(self) -> list[Any]:
        """Return the Taylor coefficients of the base displacement."""
        return [self.numbers.of(0)] * self.numbers.terms if self.forced else self._sine()

    def _force(self) -> list[Any]:
        """Return the Taylor coefficients of the exciting force on the mass."""
        return self._sine() if self.forced else [self.numbers.of(0)] * self.numbers.terms

    def _sine(self) -> list[Any]:
        phase = self.r * self.t
        base = [self.numbers.sin(phase), self.r * self.numbers.cos(phase)]
        for n in range(self.numbers.terms - 2):
            base.append(-self.r * self.r * base[n] / ((n + 1) * (n + 2)))
        return base

    def _expand(self) -> tuple[list[Any], list[Any], list[Any], list[Any]]:
        """Return the Taylor coefficients of u, p, the base displacement and the force of the wall."""
        base, pull_on, u, p = self._base(), self._force(), [self.u, self.u_rate], [self.p, self.p_rate]
        force = []
        for n in range(self.numbers.terms - 2):
            below = (n + 1) * (n + 2)
            push = self.numbers.of(0)
            if self.pushed:
                depth = self.side * (u[n] - p[n]) - (self.d if n == 0 else 0)
                push = self.k * depth + self.c * self.side * (n + 1) * (u[n + 1] - p[n + 1])
            force.append(push)
            pull = pull_on[n] - 2 * self.zeta * (n + 1) * (u[n + 1] - base[n + 1]) - (u[n] - base[n])
            if n == 0:
                pull -= self.slip * self.gamma
            u.append(base[n + 2] if self.held else (pull - self.side * push) / below)
            p.append(self.side * push / (self.beta * below))
        return u, p, base, force

    def _judge(self, force: Any) -> None:
        """Decide whether a mass at rest on the base sticks or slips."""
        base = self._base()
        load = self._force()[0] - 2 * base[2] - (self.u - base[0]) - self.side * force
        self.held = bool(abs(load) <= self.gamma)
        self.slip = 0 if self.held else (1 if load > 0 else -1)

    def _watches(
        self, u: list[Any], p: list[Any], base: list[Any], force: list[Any]
    ) -> dict[str, Callable[[Any], Any]]:
        """Return the functions that become negative at an event, by the name of the event."""
        watches: dict[str, Callable[[Any], Any]] = {}
        if self.gamma and self.held:
            pull_on = self._force()

            def load(h: Any) -> Any:
                rest = _value(pull_on, h) - _curvature(base, h) - (_value(u, h) - _value(base, h))
                return self.gamma - abs(rest - self.side * _value(force, h))

            watches["onset"] = load
        elif self.gamma:
            watches["turn"] = lambda h: self.slip * (_slope(u, h) - _slope(base, h))
        if self.pushed:
            watches["release"] = lambda h: _value(force, h)
        elif self.side:
            side = self.side
            watches["clear"] = lambda h: side * (_value(u, h) - _value(p, h)) - self.d
            watches["push"] = lambda h: (
                -(
                    self.k * (side * (_value(u, h) - _value(p, h)) - self.d)
                    + self.c * side * (_slope(u, h) - _slope(p, h))
                )
            )
        else:
            watches["near"] = lambda h: self.d - (_value(u, h) - _value(p, h))
            watches["far"] = lambda h: self.d + (_value(u, h) - _value(p, h))
        return watches

    def step_to(self, end: Any) -> None:
        """Take one step up to `end` or to the first event, and apply the event."""
        u, p, base, force = self._expand()
        pull_on = self._force()
        in_wall = self.side != 0
        h = min(end - self.t, self.contact_step if in_wall else self.free_step)
        what = ""
        for name, watch in self._watches(u, p, base, force).items():
            if watch(h) < 0:
                low, high = self.numbers.of(0), h
                for _ in range(self.numbers.bisections):
                    middle = (low + high) / 2
                    if watch(middle) < 0:
                        high = middle
                    else:
                        low = middle
                h, what = high, name
        self.t += h
        self.u, self.u_rate, self.p, self.p_rate = _value(u, h), _slope(u, h), _value(p, h), _slope(p, h)
        push = _value(force, h) if self.pushed else 0
        if what == "release":
            self.pushed = False
            if not self.c:
                self.side = 0
        elif what == "clear":
            self.side = 0
        elif what == "push":
            self.pushed = True
        elif what in ("near", "far"):
            self.side, self.pushed = (1 if what == "near" else -1), True
            self.impacts += 1
            if self.held:
                self._judge(self.c * self.side * (self.u_rate - self.p_rate))
        elif what in ("turn", "onset"):
            self.turns += what == "turn"
            self._judge(push)
            if what == "onset" and self.held:  # the load equals the limit up to rounding
                load = (
                    _value(pull_on, h) - _curvature(base, h) - (self.u - _value(base, h)) - self.side * push
                )
                self.held, self.slip = False, (1 if load > 0 else -1)


def _value(p: list[Any], h: Any) -> Any:
    total = p[-1]
    for one in p[-2::-1]:
        total = total * h + one
    return total


def _slope(p: list[Any], h: Any) -> Any:
    total = (len(p) - 1) * p[-1]
    for n in range(len(p) - 2, 0, -1):
        total = total * h + n * p[n]
    return total


def _curvature(p: list[Any], h: Any) -> Any:
    total = (len(p) - 1) * (len(p) - 2) * p[-1]
    for n in range(len(p) - 2, 1, -1):
        total = total * h + n * (n - 1) * p[n]
    return total


class Measured(March):
    """An integration that also computes the peaks of v and u'' and the integrals of their squares.

    Each step is divided into eight parts.
    """

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self.peak = self.acceleration_peak = self.square = self.acceleration_square = 0.0

    def measure_to(self, end: float) -> None:
        """Integrate to a time, and update peaks and integrals, the latter by Simpson's rule."""
        while self.t < end:
            u, _, base, _ = self._expand()
            began = self.t
            self.step_to(end)
            span = self.t - began
            for i, weight in enumerate(_SIMPSON):
                h = span * i / 8
                v = _value(u, h) - _value(base, h)
                acceleration = _curvature(u, h)
                self.peak = max(self.peak, abs(v))
                self.acceleration_peak = max(self.acceleration_peak, abs(acceleration))
                self.square += span / 24 * weight * v * v
                self.acceleration_square += span / 24 * weight * acceleration * acceleration


class Accelerated(Measured):
    """An integration over whole cycles."""

    def begin(self, start: Sequence[float]) -> None:
        """Set the initial state u, u', p, p', in which the particle touches no wall."""
        self.u, self.u_rate, self.p, self.p_rate = start
        if self.gamma:
            sliding = self.u_rate - _slope(self._base(), 0.0)
            if sliding == 0.0:
                self._judge(0.0)
            else:
                self.held, self.slip = False, 1 if sliding > 0.0 else -1

    def run(self, cycles: int) -> None:
        """Integrate a number of whole cycles."""
        self.measure_to(2 * pi * cycles / self.r)


class Recorded(Measured):
    """An integration over a record, whose base acceleration is linear between samples."""

    def __init__(self, scene: Scene, samples: Sequence[float], step: float) -> None:
        super().__init__(scene)
        self.samples, self.sample_step = samples, step
        self.start = [0.0, 0.0]
        self.sample = 0
        if self.gamma:
            self._judge(0.0)

    def _base(self) -> list[Any]:
        """Return the Taylor coefficients of the base displacement in the present sample interval."""
        h = self.t - self.sample * self.sample_step
        a = self.samples[self.sample]
        jerk = (self.samples[self.sample + 1] - a) / self.sample_step
        z, rate = self.start
        here = [
            z + h * (rate + h * (a / 2 + h * jerk / 6)),
            rate + h * (a + h * jerk / 2),
            (a + jerk * h) / 2,
            jerk / 6,
        ]
        return here + [0.0] * (self.numbers.terms - 4)

    def run(self) -> None:
        """Integrate over the whole record."""
        for sample in range(len(self.samples) - 1):
            self.sample = sample
            self.measure_to((sample + 1) * self.sample_step)
            a, b, h = self.samples[sample], self.samples[sample + 1], self.sample_step
            z, rate = self.start
            self.start = [z + h * rate + h * h * (2 * a + b) / 6, rate + h * (a + b) / 2]


def end_state(
    scene: Scene, cycles: int, numbers: Numbers = FLOATS, start: Sequence[Any] = (0, 0, 0, 0)
) -> tuple[list[Any], March]:
    """Return u, u', p, p' after whole cycles, and the integration.

    The initial state is rest by default. In any other initial state, the particle must touch no wall.
    """
    march = March(scene, numbers)
    march.u, march.u_rate, march.p, march.p_rate = (numbers.of(x) for x in start)
    if march.gamma and march.u_rate > march.r:
        march.slip = 1
    end = 2 * numbers.pi * cycles / march.r
    while march.t < end:
        march.step_to(end)
    return [march.u, march.u_rate, march.p, march.p_rate], march
