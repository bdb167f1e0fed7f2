"""Slip and acceleration of the primary mass at a transition, for all contact models."""

from damperlab.worker.jit import inlined
from damperlab.worker.physics.friction import breakaway, slip_direction
from damperlab.worker.solver.excitation.excitation import Phase, force_to_hold, largest_to_hold
from damperlab.worker.solver.regime import slip_regime
from damperlab.worker.solver.scene import Scene


@inlined
def slip_from_rest(
    v: float, wall_force: float, inertia: float, must_slip: bool, phase: Phase, scene: Scene
) -> float:
    """Direction in which a mass at rest on the base slips; 0 if friction holds the mass, or without friction.

    Parameters
    ----------
    v : float
        Displacement of the mass relative to the base.
    wall_force : float
        Force of a compliant wall on the mass, positive against u; 0 without such a wall.
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
    """Direction of slip at a velocity w; `slip` if the mass is at rest, or without friction."""
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
