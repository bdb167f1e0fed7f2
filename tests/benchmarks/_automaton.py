"""The model as a hybrid automaton for general-purpose integrators: modes, their right-hand sides, events, what they change.

Written for the comparison alone, and sharing nothing with the solver. An integrator gets a mode and must march to the
first zero of one of its event functions, each of which falls through zero when its event happens.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import cos, pi, sin
from typing import NamedTuple

from damperlab.worker.accuracy.cases import State
from damperlab.worker.point import Design

Vector = tuple[float, float, float, float]
"""v, v', p, p'."""
NUDGE = 1e-13
"""Gap that is left after an impact: a root finder that starts at zero finds the impact that has just been carried out."""
JOIN_SPEED = 1e-6
"""A particle that would leave slower than this, with the wall following, joins it; the error goes as its square."""
MOST_EVENTS = 20_000


class Mode(NamedTuple):
    """Which terms act: slip direction (0 without friction or while stuck), stuck, wall that the particle rides on or is in.

    A compliant wall that the particle is in may push it, or have let it go.
    """

    slip: int
    stuck: bool
    wall: int
    pushed: bool = False


@dataclass(frozen=True)
class Model:
    """Equation (1) in relative form, equation (3), and the laws at their switches."""

    design: Design

    def inertia(self, mode: Mode) -> float:
        particle = self.design.particle
        return 1.0 + particle.mass_ratio if mode.wall and particle is not None else 1.0

    def rates(self, t: float, y: Vector, mode: Mode) -> Vector:
        """Time derivative of the state."""
        v, w, _, q = y
        r = self.design.frequency_ratio
        shaking = r * r * sin(r * t)
        w_rate = 0.0
        if not mode.stuck:
            force = -2.0 * self.design.damping_ratio * w - v - self.design.friction_ratio * mode.slip
            w_rate = force / self.inertia(mode) + shaking
        q_rate = w_rate - shaking if mode.wall else 0.0
        return (0.0 if mode.stuck else w), w_rate, q, q_rate

    def hold_force(self, t: float, y: Vector, mode: Mode) -> float:
        r = self.design.frequency_ratio
        return self.inertia(mode) * r * r * sin(r * t) - y[0]

    def events(self, mode: Mode) -> list[Callable[[float, Vector], float]]:
        """Functions that fall through zero at the events of a mode."""
        friction = self.design.friction_ratio
        r = self.design.frequency_ratio
        found: list[Callable[[float, Vector], float]] = []
        if mode.slip:
            found.append(lambda t, y: mode.slip * y[1])
        if mode.stuck:
            found.append(lambda t, y: friction - self.hold_force(t, y, mode))
            found.append(lambda t, y: friction + self.hold_force(t, y, mode))
        if mode.wall:
            found.append(lambda t, y: mode.wall * self.rates(t, y, mode)[3])
        elif self.design.particle is not None:
            d = self.design.particle.clearance_ratio
            found.append(lambda t, y: d - (y[0] + sin(r * t) - y[2]))
            found.append(lambda t, y: d + (y[0] + sin(r * t) - y[2]))
        return found

    def names(self, mode: Mode) -> list[str]:
        """What the functions of `events` mean."""
        found = ["turn"] if mode.slip else []
        found += ["slip+", "slip-"] if mode.stuck else []
        if mode.wall:
            return [*found, "release"]
        return found + (["wall+", "wall-"] if self.design.particle is not None else [])

    def after_rest(self, t: float, y: Vector, wall: int) -> Mode:
        """Stick or slip of a mass at rest on the base, alone or with the particle on its wall."""
        for on in (wall, 0) if wall else (0,):
            mode = Mode(0, True, on)
            force = self.hold_force(t, y, mode)
            if abs(force) > self.design.friction_ratio:
                mode = Mode(1 if force > 0.0 else -1, False, on)
            if not on or self.push(t, y, mode) > 0.0:
                return mode
        raise AssertionError("a free mass is always consistent")

    def push(self, t: float, y: Vector, mode: Mode) -> float:
        """Acceleration with which the wall pushes the particle."""
        r = self.design.frequency_ratio
        return mode.wall * (self.rates(t, y, mode)[1] - r * r * sin(r * t))

    def slipping(self, w: float, mode: Mode) -> Mode:
        if self.design.friction_ratio > 0.0 and w != 0.0:
            return mode._replace(slip=1 if w > 0.0 else -1, stuck=False)
        return mode

    def carry_out(self, event: str, t: float, y: Vector, mode: Mode) -> tuple[Vector, Mode]:
        """State and mode after an event."""
        v, w, p, q = y
        if event == "turn":
            y = (v, 0.0, p, q)
            return y, self.after_rest(t, y, mode.wall)
        if event in ("slip+", "slip-"):
            return y, mode._replace(slip=1 if event == "slip+" else -1, stuck=False)
        if event == "release":
            return y, mode._replace(wall=0)
        particle = self.design.particle
        assert particle is not None
        wall = 1 if event == "wall+" else -1
        e, beta, r = particle.restitution, particle.mass_ratio, self.design.frequency_ratio
        base_rate = r * cos(r * t)
        speed = wall * (w + base_rate - q)
        p = v + sin(r * t) - wall * (particle.clearance_ratio - NUDGE)
        if speed <= 0.0:
            return (v, w, p, q), mode
        if e * speed < JOIN_SPEED:
            together = (w + base_rate + beta * q) / (1.0 + beta)
            joined = (v, together - base_rate, p, together)
            riding = self.slipping(joined[1], mode._replace(wall=wall))
            if self.push(t, joined, riding) > 0.0:
                return joined, riding
        share = beta / (1.0 + beta) * (1.0 + e) * wall * speed
        w, q = w - share, q + share / beta
        return (v, w, p, q), self.slipping(w, mode._replace(wall=0))


class CompliantModel(Model):
    """The same with walls that push by spring and dashpot, and never pull."""

    def inertia(self, mode: Mode) -> float:
        return 1.0

    def depth(self, t: float, y: Vector, mode: Mode) -> float:
        """How far the particle is in the wall."""
        particle = self.design.particle
        assert particle is not None
        return mode.wall * (y[0] + sin(self.design.frequency_ratio * t) - y[2]) - particle.clearance_ratio

    def force(self, t: float, y: Vector, mode: Mode) -> float:
        """What spring and dashpot would push with."""
        particle, r = self.design.particle, self.design.frequency_ratio
        assert particle is not None
        assert particle.wall is not None
        rate = mode.wall * (y[1] + r * cos(r * t) - y[3])
        return particle.wall.stiffness * self.depth(t, y, mode) + particle.wall.damping * rate

    def contact(self, t: float, y: Vector, mode: Mode) -> float:
        """Force on the particle."""
        return mode.wall * self.force(t, y, mode) if mode.pushed else 0.0

    def rates(self, t: float, y: Vector, mode: Mode) -> Vector:
        particle = self.design.particle
        assert particle is not None
        push = self.contact(t, y, mode)
        v_rate, w_rate, p_rate, _ = super().rates(t, y, mode._replace(wall=0))
        return v_rate, (0.0 if mode.stuck else w_rate - push), p_rate, push / particle.mass_ratio

    def hold_force(self, t: float, y: Vector, mode: Mode) -> float:
        return super().hold_force(t, y, mode) - self.contact(t, y, mode)

    def events(self, mode: Mode) -> list[Callable[[float, Vector], float]]:
        if not mode.wall:
            return super().events(mode)
        found = super().events(mode)[: 2 * mode.stuck + abs(mode.slip)]
        if mode.pushed:
            return [*found, lambda t, y: self.force(t, y, mode)]
        return [*found, lambda t, y: self.depth(t, y, mode), lambda t, y: -self.force(t, y, mode)]

    def names(self, mode: Mode) -> list[str]:
        found = super().names(mode)
        return found if mode.pushed or not mode.wall else [*found[:-1], "clear", "push"]

    def at_rest(self, t: float, y: Vector, mode: Mode) -> Mode:
        """Stick or slip of a mass at rest on the base, in the contact that it has."""
        force = self.hold_force(t, y, mode)
        if abs(force) > self.design.friction_ratio:
            return mode._replace(slip=1 if force > 0.0 else -1, stuck=False)
        return mode._replace(slip=0, stuck=True)

    def carry_out(self, event: str, t: float, y: Vector, mode: Mode) -> tuple[Vector, Mode]:
        if event == "turn":
            y = (y[0], 0.0, y[2], y[3])
            return y, self.at_rest(t, y, mode)
        if event in ("slip+", "slip-"):
            return y, mode._replace(slip=1 if event == "slip+" else -1, stuck=False)
        if event == "release":
            return y, mode._replace(pushed=False)
        if event == "clear":
            return y, mode._replace(wall=0)
        if event == "push":
            return y, mode._replace(pushed=True)
        struck = mode._replace(wall=1 if event == "wall+" else -1, pushed=True)
        return y, self.at_rest(t, y, struck) if mode.stuck else struck


Reached = tuple[float, Vector, int | None]
"""Time, state and which event function ended a mode; None at the end."""
Advance = Callable[[Model, Mode, float, float, Vector], Reached]
"""From mode, time, end and state to what is reached."""


def march(design: Design, cycles: int, advance: Advance) -> State | None:
    """March whole cycles from rest with an integrator; None where it gives up or events do not end."""
    walls = None if design.particle is None else design.particle.wall
    model = Model(design) if walls is None else CompliantModel(design)
    r = design.frequency_ratio
    end = 2.0 * pi * cycles / r
    t, y = 0.0, (0.0, -r, 0.0, 0.0)
    mode = Mode(-1 if design.friction_ratio > 0.0 else 0, False, 0)
    for _ in range(MOST_EVENTS):
        try:
            t, y, event = advance(model, mode, t, end, y)
        except (ArithmeticError, RuntimeError, ValueError):
            return None
        if event is None:
            return y[0] + sin(r * t), y[1] + r * cos(r * t), y[2], y[3]
        y, mode = model.carry_out(model.names(mode)[event], t, y, mode)
    return None
