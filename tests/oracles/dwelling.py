"""Integrates the contact model `dwell` with SciPy's DOP853, and imports nothing from the project.

Coordinates and time are absolute. The particle flies, or is in contact with a wall for the contact time. The mass slips
in one direction or sticks. Each such regime is integrated up to the first event, with a tolerance of 1e-12. Sustained
contact is not supported: the integration then raises an error.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import cos, pi, sin

import numpy as np
from scipy.integrate import solve_ivp

_TOLERANCE = 1e-12


@dataclass(frozen=True)
class Scene:
    """Ratios of a design point, and the contact time of the particle.

    The friction ratio may be 0. The excitation is a motion of the base or, if `forced`, a force on the structure.
    """

    damping_ratio: float
    frequency_ratio: float
    friction_ratio: float
    clearance_ratio: float
    restitution: float
    mass_ratio: float
    contact_time: float
    forced: bool = False


def end_state(
    scene: Scene,
    cycles: int,
    start: Sequence[float] = (0.0, 0.0, 0.0, 0.0),
    seen: Callable[[np.ndarray, np.ndarray], None] | None = None,
) -> tuple[list[float], int]:
    """Return u, u', p, p' after whole cycles, and the number of impacts.

    The initial state is rest by default. In any other initial state, the particle must touch no wall. `seen` is called
    after each regime with the times and the values of u'' at these times.
    """
    zeta, r, gamma = scene.damping_ratio, scene.frequency_ratio, scene.friction_ratio
    delta, beta = scene.clearance_ratio, scene.mass_ratio

    t, end = 0.0, 2.0 * pi * cycles / r
    y = np.array(start, dtype=float)
    shaken, force = (0.0, 1.0) if scene.forced else (1.0, 0.0)
    slip = float(np.sign(y[1] - shaken * r)) if gamma else 0.0
    held = bool(gamma) and slip == 0.0
    joined_until = 0.0
    speed, wall = 0.0, 0.0
    impacts = 0

    def inertia() -> float:
        return 1.0 + beta if joined_until > t else 1.0

    def hold_force(at: float, u: float) -> float:
        push = force + shaken * inertia() * r * r
        return push * sin(r * at) - (u - shaken * sin(r * at))

    def judge() -> None:
        """Decide whether a mass at rest on the base sticks or slips."""
        nonlocal slip, held
        force = hold_force(t, y[0])
        held = abs(force) <= gamma
        slip = 0.0 if held else float(np.sign(force))

    while t < end:
        joined = joined_until > t
        mass = inertia()

        def right_side(
            at: float,
            q: np.ndarray,
            joined: bool = joined,
            mass: float = mass,
            held: bool = held,
            slip: float = slip,
        ) -> list[float]:
            base, rate = shaken * sin(r * at), shaken * r * cos(r * at)
            spring = 2 * zeta * (q[1] - rate) + (q[0] - base) + slip * gamma - force * sin(r * at)
            acceleration = -r * r * base if held else -spring / mass
            return [q[1], acceleration, q[3], acceleration if joined else 0.0]

        def turn(at: float, q: np.ndarray, slip: float = slip) -> float:
            return float(slip * (q[1] - shaken * r * cos(r * at)))

        def onset(at: float, q: np.ndarray) -> float:
            return gamma - abs(hold_force(at, q[0]))

        def near(at: float, q: np.ndarray) -> float:
            return float(delta - (q[0] - q[2]))

        def far(at: float, q: np.ndarray) -> float:
            return float(delta + (q[0] - q[2]))

        watches = {}
        if gamma:
            watches["onset" if held else "turn"] = onset if held else turn
        if not joined:
            watches |= {"near": near, "far": far}
        for watch in watches.values():
            watch.terminal, watch.direction = True, -1.0  # type: ignore[attr-defined]
        stop = min(end, joined_until) if joined else end
        solved = solve_ivp(
            right_side,
            (t, stop),
            y,
            method="DOP853",
            rtol=_TOLERANCE,
            atol=_TOLERANCE,
            max_step=0.05 / r,
            events=list(watches.values()),
        )
        if seen is not None:
            places = zip(solved.t, solved.y.T, strict=True)
            seen(solved.t, np.array([right_side(float(at), q)[1] for at, q in places]))
        t, y = float(solved.t[-1]), solved.y[:, -1].copy()
        kind = next((n for n, at in zip(watches, solved.t_events, strict=True) if len(at)), "")
        rate = shaken * r * cos(r * t)
        if kind == "turn":
            y[1] = rate
            if joined:
                y[3] = rate
            judge()
        elif kind == "onset":
            held, slip = False, float(np.sign(hold_force(t, y[0])))
        elif kind in ("near", "far"):
            wall = 1.0 if kind == "near" else -1.0
            impacts += 1
            speed = wall * (y[1] - y[3])
            y[1] = y[3] = (y[1] + beta * y[3]) / (1 + beta)
            y[2] = y[0] - wall * delta
            joined_until = t + scene.contact_time
            held, slip = False, float(np.sign(y[1] - rate)) if gamma else 0.0
        elif joined and t >= joined_until:
            joined_until = 0.0
            apart = wall * scene.restitution * speed / (1 + beta)
            if apart == 0.0:
                raise ValueError("the particle would have to ride on")
            y[1] -= beta * apart
            y[3] += apart
            held, slip = False, float(np.sign(y[1] - rate)) if gamma else 0.0
    return [float(value) for value in y], impacts
