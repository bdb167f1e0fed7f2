"""States at phase 0 that a run may start from."""

from damperlab.worker.jit import kernel
from damperlab.worker.solver.dwell import dwell_at_rest
from damperlab.worker.solver.excitation.sine_base import Forced, base_rate_at_phase_zero
from damperlab.worker.solver.state import State


@kernel
def at_rest(frequency_ratio, friction, particle):
    """Everything at rest in the absolute frame, particle centred: v' = −r, or 0 under a force, which begins with 0."""
    slip = 0.0
    if friction is not None:
        slip = 0.0 if isinstance(frequency_ratio, Forced) else -1.0
    gap = 0.0
    if particle is not None:
        gap = particle.clearance_ratio
    return State(
        0.0,
        0.0 - base_rate_at_phase_zero(frequency_ratio),
        slip,
        1.0,
        gap,
        0.0,
        0.0,
        0,
        0,
        dwell_at_rest(particle),
    )


@kernel
def carried(state, frequency_before, frequency_ratio):
    """The same motion relative to the base under another frequency of excitation: nothing slips or strikes by the change.

    Parameters
    ----------
    state : State
        At phase 0.
    frequency_before, frequency_ratio : float or Forced
        r of the state, and the new one.
    """
    p_rate = state.p_rate + (
        base_rate_at_phase_zero(frequency_ratio) - base_rate_at_phase_zero(frequency_before)
    )
    return State(state.v, state.w, state.slip, state.wall, state.gap, p_rate, state.riding, 0, 0, state.dwell)


def over_another_length(state: State, excitation: float | Forced, shrinks: float) -> State:
    """Return the same state at phase 0 where lengths are over another one, the base moving on at phase 0 as it did.

    Parameters
    ----------
    state : State
    excitation : float or Forced
        Frequency of the state.
    shrinks : float
        The length of before over the one of now.
    """
    of_base = base_rate_at_phase_zero(excitation)
    dwell = state.dwell
    if dwell is not None:
        dwell = dwell._replace(speed=shrinks * dwell.speed)
    return state._replace(
        v=shrinks * state.v,
        w=shrinks * state.w,
        gap=shrinks * state.gap,
        p_rate=of_base + shrinks * (state.p_rate - of_base),
        dwell=dwell,
    )


@kernel
def moving(u, u_rate, position, p_rate, frequency_ratio, friction, particle):
    """A state given in the absolute frame, the particle in flight.

    Parameters
    ----------
    u, u_rate : float
        Displacement and velocity of the primary mass.
    position : float
        Of the particle in its cavity, from −1 (at the wall behind) to 1.
    p_rate : float
        Velocity of the particle.
    """
    w = u_rate - base_rate_at_phase_zero(frequency_ratio)
    slip = 0.0
    if friction is not None:
        slip = 1.0 if w > 0.0 else -1.0
    gap = 0.0
    if particle is not None:
        gap = particle.clearance_ratio * (1.0 + position)
    return State(u, w, slip, 1.0, gap, p_rate, 0.0, 0, 0, dwell_at_rest(particle))
