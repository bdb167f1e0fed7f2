"""Contact phase at a compliant wall: from the first touch until the particle is clear of the wall.

The contact phase is integrated in one of four ways:

1. While the contact's own vibration decays, polynomials of all six coordinates are used. A span is at most half the
   inverse of the contact's fastest rate.
2. Once y' follows from the other coordinates while y still decays, the rate of y limits the spans
   (`CompliantRegime.between`).
3. If an envelope of the vibration excludes events, one long step is taken. Polynomials then describe the slow motion,
   and an exponential describes the vibration.
4. Once the vibration has decayed below rounding, polynomials of the slow motion are used. If y and y' are
   both fast, a span can be a complete panel. So a particle at rest on a very stiff wall needs no more steps
   than on a rigid wall.

The particle detaches when the force of the wall falls to zero. The particle then still penetrates the wall, and some
energy remains in the wall's spring. The flight ends when the particle is clear of the wall, or when the wall pushes
again.
"""

from damperlab.worker.jit import kernel
from damperlab.worker.physics.compliant_wall import spring_energy
from damperlab.worker.solver.compliant_regime import buffers_of, compliant_regime_of, wall_of
from damperlab.worker.solver.contact.compliant.contact_segment import expand, to_event
from damperlab.worker.solver.contact.compliant.long_step import (
    FEWEST_STEPS,
    after_long_step,
    coordinates_into,
    longest_step,
)
from damperlab.worker.solver.contact.compliant.separation import separate
from damperlab.worker.solver.contact.rest import detach, slip_from_rest
from damperlab.worker.solver.dwell import approach_speed
from damperlab.worker.solver.events import (
    ARRIVED,
    CLEARANCE,
    IMPACTS,
    NOTHING,
    PUSHED_AGAIN,
    RELEASE,
    SEGMENTS,
    SLIP_ONSET,
    TURN,
    TURNS,
    spend,
)
from damperlab.worker.solver.excitation.excitation import (
    Phase,
    expand_excitation,
    phase_after,
    phase_at,
)
from damperlab.worker.solver.motion.slow_subspace import DIM
from damperlab.worker.solver.motion.vibration import subtract_vibration, vibration_of
from damperlab.worker.solver.observe.meter import IMPACT_LOSS, SPEED, Meter
from damperlab.worker.solver.regime import Span
from damperlab.worker.solver.scene import Scene, curves_of
from damperlab.worker.solver.segment_log import Log
from damperlab.worker.solver.state import Dwell, State
from damperlab.worker.solver.transition_log import Transitions, note_segment, note_transition

_SPEED_ROUNDING = 1e-13  # below this fraction of the velocities, a leaving speed is a rounding error


@kernel
def strike(state: State, side: float, phase: Phase, scene: Scene, meter: Meter | None) -> State:
    """Return the state just after the particle meets a compliant wall.

    The velocities do not jump, but the dashpot resists immediately.
    """
    wall = wall_of(scene)
    u_rate = state.w + phase.rate
    approach = max(side * (u_rate - state.p_rate), 0.0)
    scene.counts[IMPACTS] += 1
    if meter is not None:
        meter.sums[SPEED] = max(meter.sums[SPEED], approach)
    order = 0
    if wall.damping * approach == 0.0:
        order = 1 if approach > 0.0 or wall.damping > 0.0 else 2
    slip = state.slip
    slip_order = 0
    if scene.friction is not None:
        if slip == 0.0:
            slip = slip_from_rest(state.v, side * wall.damping * approach, 1.0, False, phase, scene)
            slip_order = int(slip != 0.0)
    return state._replace(
        slip=slip,
        wall=side,
        gap=0.0,
        p_rate=u_rate - side * approach,
        riding=1.0,
        slip_order=slip_order,
        gap_order=order,
        dwell=Dwell(0.0, approach),
    )


@kernel
def while_in_contact(
    state: State, span: Span, k: int, scene: Scene, meter: Meter | None, log: Log | Transitions | None
) -> tuple[State, Span, int]:
    """Integrate a contact with a compliant wall until the particle is clear of the wall or the panel ends.

    `state` is a state within panel k, and `span` the rest of the panel from that time on.

    Returns
    -------
    state : State
    span : Span
        The rest of panel k from the returned state on; `remaining` is 0 if the contact reaches the end of the panel.
    outcome : int
        ARRIVED, or the reason for an early end (`events`).
    """
    base, counts, excitation = scene.base, scene.counts, curves_of(scene).excitation
    opening = phase_at(base, k)
    expand_excitation(base, opening, excitation)
    phase, remaining = span.phase, span.remaining
    while remaining > 0.0 and (state.riding > 0.0 or state.gap < 0.0):
        before = state
        if state.riding > 0.0:
            state, t, kind = _in_contact(state, phase, remaining, scene, meter)
        else:
            state, t, kind = separate(state, phase, remaining, scene, meter)
        note_segment(log, before, (k + 1) * base.window - remaining, t, kind)
        if kind != NOTHING:
            counts[SEGMENTS] += 1
        outcome = spend(counts, t, scene.loaded.slipping.step)
        if outcome != ARRIVED:
            return state, Span(phase, span.end, remaining, False), outcome
        remaining = max(remaining - t, 0.0)
        phase = span.end
        if remaining > 0.0:
            phase = phase_after(base, opening, excitation, base.window - remaining)
        reached = state
        if kind != NOTHING:
            state = _after_event(state, kind, phase, scene, meter)
        note_transition(log, t, kind, reached, state, phase)
    return state, Span(phase, span.end, remaining, False), ARRIVED


@kernel
def _in_contact(
    state: State, phase: Phase, remaining: float, scene: Scene, meter: Meter | None
) -> tuple[State, float, int]:
    """Integrate one segment of compliant contact; return its end state, its length and the kind of its event."""
    buffers = buffers_of(scene)
    regime = compliant_regime_of(state, scene)
    motion = regime.motion
    start = buffers.start
    coordinates_into(state, regime, phase, start)
    expand_excitation(scene.base, phase, buffers.excitation)
    if motion.fast > 0:
        vibration, settled = vibration_of(start, motion)
        if not settled and regime.between.fast > 0:
            _, follows = vibration_of(start, regime.between)
            if follows:
                scene.counts[SEGMENTS] += 1
                expand(start, DIM - 1, regime.between.slow_rows, phase, scene)
                t = min(remaining, regime.between.slow_step)
                return to_event(state, phase, t, regime, scene, meter)
        if settled or remaining > FEWEST_STEPS * motion.step:
            t = min(remaining, motion.slow_step)
            if not settled:
                subtract_vibration(start, vibration, motion)
            expand(start, DIM - motion.fast, motion.slow_rows, phase, scene)
            if settled:
                return to_event(state, phase, t, regime, scene, meter)
            t = longest_step(state, phase, t, vibration, regime, scene, meter)
            if t > 0.0:
                return after_long_step(state, t, vibration, regime, scene, meter)
            # restore the vibration, which was subtracted from `start`
            coordinates_into(state, regime, phase, start)
        scene.counts[SEGMENTS] += 1
    expand(start, DIM, motion.rows, phase, scene)
    return to_event(state, phase, min(remaining, motion.step), regime, scene, meter)


@kernel
def _after_event(state: State, kind: int, phase: Phase, scene: Scene, meter: Meter | None) -> State:
    """Return the state just after an event during contact."""
    wall = wall_of(scene)
    slip = state.slip
    slip_order = state.slip_order
    order = state.gap_order
    gap = state.gap
    w = state.w
    riding = state.riding
    dwell = state.dwell
    pen_rate = approach_speed(dwell)
    u_rate = w + phase.rate
    leaving = state.wall * (state.p_rate - u_rate)
    if scene.friction is not None:
        if kind in (TURN, SLIP_ONSET):
            wall_force = 0.0
            if riding > 0.0:
                wall_force = state.wall * (wall.damping * pen_rate - wall.stiffness * gap)
            if kind == TURN:
                scene.counts[TURNS] += 1
            slip = slip_from_rest(state.v, wall_force, 1.0, kind == SLIP_ONSET, phase, scene)
            w = 0.0
            slip_order = int(slip != 0.0)
    if kind == RELEASE:
        riding = 0.0
        leaving = -pen_rate
        if leaving <= _SPEED_ROUNDING * (abs(u_rate) + abs(w) + abs(phase.rate)):
            # the particle came to rest on the wall: its leaving speed is below the accuracy of the velocities
            if meter is not None:
                if meter.energies is not None:
                    meter.sums[IMPACT_LOSS] += spring_energy(wall.stiffness, -gap)
            return detach(state, phase, scene)
        dwell = Dwell(0.0, 0.0)
        order = 1
        if wall.damping == 0.0 or gap >= 0.0:
            gap = 0.0
            order = 1 if leaving > 0.0 else 2
    elif kind == CLEARANCE:
        order = 1 if leaving > 0.0 else 2
    elif kind == PUSHED_AGAIN:
        if leaving < 0.0:  # because of rounding, the particle penetrates the wall before its strike
            return strike(state, state.wall, phase, scene, meter)
        if wall.damping == 0.0:
            gap = 0.0
            order = 1 if leaving > 0.0 else 2
        else:
            riding = 1.0
            dwell = Dwell(0.0, gap * wall.stiffness / wall.damping)
            order = 1
    return state._replace(
        w=w, slip=slip, gap=gap, riding=riding, slip_order=slip_order, gap_order=order, dwell=dwell
    )
