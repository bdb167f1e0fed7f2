"""States at phase 0 from which a run may start."""

from damperlab.worker.jit import kernel
from damperlab.worker.solver.dwell import dwell_at_rest
from damperlab.worker.solver.excitation.sine import base_rate_at_phase_zero
from damperlab.worker.solver.particle import Particle
from damperlab.worker.solver.sliding import moving_slide, slide_at_rest
from damperlab.worker.solver.state import State


@kernel
def at_rest(
    frequency_ratio: float, friction: float | None, particle: Particle | None, forced: bool = False
) -> State:
    """Make a state with mass and particle at rest in the absolute frame: v' = −r, or v' = 0 under a force.

    The particle is in the middle of its cavity or, under gravity, on the lower wall.
    """
    slip = 0.0
    if friction is not None:
        slip = 0.0 if forced else -1.0
    gap = 0.0
    riding = 0.0
    if particle is not None:
        gap = particle.clearance_ratio
        if particle.friction is not None:
            riding = 1.0
        if particle.gravity is not None:
            gap = 0.0
    return State(
        0.0,
        0.0 - base_rate_at_phase_zero(frequency_ratio, forced),
        slip,
        1.0,
        gap,
        0.0,
        riding,
        0,
        0,
        dwell_at_rest(particle),
        slide_at_rest(particle),
    )


def carried(state: State, r_before: float, r: float, shrinks: float = 1.0, forced: bool = False) -> State:
    """Return the state for a new excitation frequency; the change of frequency causes no slip and no impact.

    The structure keeps its motion relative to the base, and so does a particle on its wall. A particle in flight or at
    rest keeps its absolute velocity.

    Parameters
    ----------
    state : State
        State at phase 0.
    r_before, r : float
        Frequency ratio of the given state, and the new frequency ratio.
    shrinks : float
        Ratio of the previous to the present reference length.
    forced : bool
        Whether a force on the structure replaces the shaken base.
    """
    p_rate = shrinks * state.p_rate
    if state.riding > 0.0 or state.gap < 0.0:
        before = base_rate_at_phase_zero(r_before, forced)
        p_rate = base_rate_at_phase_zero(r, forced) + shrinks * (state.p_rate - before)
    dwell = state.dwell
    if dwell is not None:
        dwell = dwell._replace(speed=shrinks * dwell.speed)
    return state._replace(
        v=shrinks * state.v,
        w=shrinks * state.w,
        gap=shrinks * state.gap,
        p_rate=p_rate,
        slip_order=0,
        gap_order=0,
        dwell=dwell,
    )


@kernel
def moving(
    u: float,
    u_rate: float,
    position: float,
    p_rate: float,
    frequency_ratio: float,
    friction: float | None,
    particle: Particle | None,
    forced: bool = False,
) -> State:
    """Make a state from values in the absolute frame, with the particle in flight.

    Parameters
    ----------
    u, u_rate : float
        Displacement and velocity of the primary mass.
    position : float
        Position of the particle in its cavity, from −1 (at the rear wall) to 1.
    p_rate : float
        Velocity of the particle.
    """
    w = u_rate - base_rate_at_phase_zero(frequency_ratio, forced)
    slip = 0.0
    if friction is not None:
        slip = 1.0 if w > 0.0 else -1.0
    gap = 0.0
    if particle is not None:
        gap = particle.clearance_ratio * (1.0 + position)
        if particle.friction is not None:
            slide = moving_slide(1.0 if u_rate > p_rate else -1.0, particle)
            return State(u, w, slip, 1.0, gap, p_rate, 0.0, 0, 0, None, slide)
    return State(u, w, slip, 1.0, gap, p_rate, 0.0, 0, 0, dwell_at_rest(particle), slide_at_rest(particle))
