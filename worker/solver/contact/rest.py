"""Slip, acceleration, approach and detachment at a transition, for all contact models."""

from damperlab.worker.jit import inlined
from damperlab.worker.physics.friction import breakaway, slip_direction
from damperlab.worker.solver.events import IMPACTS
from damperlab.worker.solver.excitation.excitation import (
    Phase,
    force_to_hold,
    largest_forcing,
    largest_to_hold,
)
from damperlab.worker.solver.observe.meter import SPEED, Meter
from damperlab.worker.solver.regime import slip_regime
from damperlab.worker.solver.scene import Scene
from damperlab.worker.solver.state import State

SPEED_ROUNDING = 1e-14  # below this fraction of the velocities, an outgoing speed is a rounding error
# Fraction of the present accelerations below which a relative acceleration is a rounding error.
STILL = 1e-9


@inlined
def slip_from_rest(
    v: float, wall_force: float, inertia: float, must_slip: bool, phase: Phase, scene: Scene
) -> float:
    """Direction in which a mass starts to slip from rest; 0 without friction, or if friction holds the mass.

    Parameters
    ----------
    v : float
        Displacement of the mass relative to the base.
    wall_force : float
        Force of a compliant wall on the mass, positive towards −u; 0 without such a wall.
    inertia : float
        Inertia of the bodies that move with the mass.
    must_slip : bool
        Whether the mass certainly slips, so that only the direction is determined.
    """
    if scene.friction is None:
        return 0.0
    force = force_to_hold(phase, v, inertia) - wall_force
    if must_slip:
        return 1.0 if force > 0.0 else -1.0
    most = largest_to_hold(scene.base, inertia) + abs(wall_force)
    return slip_direction(force, breakaway(scene.friction, most))


@inlined
def slip_at(w: float, slip: float, scene: Scene) -> float:
    """Direction of slip at a velocity w: the sign of w. At w = 0, or without friction, the direction is `slip`."""
    if scene.friction is not None:
        if w != 0.0:
            return 1.0 if w > 0.0 else -1.0
    return slip


@inlined
def acceleration_alone(v: float, w: float, slip: float, phase: Phase, scene: Scene) -> float:
    """u'' of the primary mass without a force of the particle."""
    sticks, offset = slip_regime(slip, scene.friction)
    if sticks:
        return -phase.inertia_force
    resistance: float = scene.base.two_zeta * w + v + offset
    return phase.force - resistance


@inlined
def meet(state: State, wall: float, phase: Phase, scene: Scene, meter: Meter | None) -> tuple[float, bool]:
    """Return the approach speed at a rigid wall, and whether the contact is an impact. Impacts are counted.

    If the particle touches the wall that it has just left, the contact does not count as an impact.
    """
    u_rate = state.w + phase.rate
    approach = max(wall * (u_rate - state.p_rate), 0.0)
    is_impact = approach > SPEED_ROUNDING * (abs(u_rate) + abs(state.p_rate) + abs(phase.rate))
    if is_impact:
        scene.counts[IMPACTS] += 1
    if meter is not None:
        meter.sums[SPEED] = max(meter.sums[SPEED], approach)
    return approach, is_impact


@inlined
def detach(state: State, phase: Phase, scene: Scene) -> State:
    """Return the state after a wall stops pushing a particle: the particle flies on with the velocity of the wall."""
    _, offset = slip_regime(state.slip, scene.friction)
    opening = -state.wall * acceleration_alone(state.v, state.w, state.slip, phase, scene)
    # At a detachment found as a root, the relative acceleration is zero within rounding.
    # The time derivative of this acceleration then opens the gap.
    scale = largest_forcing(scene.base) + abs(state.w) + abs(state.v) + abs(offset)
    order = 2 if opening > STILL * scale else 3
    return state._replace(gap=0.0, p_rate=state.w + phase.rate, riding=0.0, slip_order=0, gap_order=order)
