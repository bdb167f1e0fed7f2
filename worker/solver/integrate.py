"""Event-driven integration over half an excitation cycle, or over a record.

An absent element of a scene is None, and the compiler omits its code. Without `friction`, the mass never sticks, and
velocity reversals are not searched. Without `particle`, there is no gap, no impact and no sustained contact. Without
`meter`, no peaks are measured; without `meter.energies`, no integrals are measured. Without `log`, no history is
recorded.
"""

from damperlab.worker.jit import inlined, kernel
from damperlab.worker.solver.addresses import on_addresses
from damperlab.worker.solver.contact.compliant.contact_phase import while_in_contact
from damperlab.worker.solver.contact.reset_map import after_event
from damperlab.worker.solver.detection.bounds import motion_bounds
from damperlab.worker.solver.detection.event_free import is_free_between, is_free_from
from damperlab.worker.solver.detection.first_event import next_event
from damperlab.worker.solver.dwell import dwell_on
from damperlab.worker.solver.events import ARRIVED, NOTHING, SEGMENTS, spend
from damperlab.worker.solver.excitation.excitation import (
    expand_excitation,
    next_half_start,
    phase_after,
    phase_until,
    travel,
)
from damperlab.worker.solver.expansion import expand_motion, mass_at
from damperlab.worker.solver.motion.taylor import beyond_tangent, slope
from damperlab.worker.solver.observe.measure import measure, measured_at_ends
from damperlab.worker.solver.observe.meter import Meter
from damperlab.worker.solver.particle import Particle
from damperlab.worker.solver.regime import Regime, Segment, Span, regime_of, window_at
from damperlab.worker.solver.scene import Curves, Scene, curves_of
from damperlab.worker.solver.segment_log import Log
from damperlab.worker.solver.sliding import acceleration_of
from damperlab.worker.solver.state import State, advanced
from damperlab.worker.solver.transition_log import Transitions, note_segment, note_transition


@kernel
def half_cycle(
    state: State, scene: Scene, meter: Meter | None, log: Log | Transitions | None
) -> tuple[State, int]:
    """Integrate over half an excitation cycle and mirror the state, or integrate over a complete record.

    Parameters
    ----------
    state : State
        State at phase 0 of the (mirrored) base, or at the start of the record.
    scene : Scene
        The scene. The integration increases its event counts.
    meter : Meter or None
        Meter that records peaks and integrals of the motion; None if nothing is measured.
    log : Log, Transitions or None
        Log of all segments, or of all transitions; None if nothing is recorded.

    Returns
    -------
    state : State
        State half a cycle later, mirrored: all signs are flipped, so that the next half cycle starts at phase 0 again.
        The state is not mirrored at the end of a record, or if the outcome is not ARRIVED.
    outcome : int
        ARRIVED, or the reason for an early end (`events`).
    """
    return half_cycle_on_addresses(state, on_addresses(scene), on_addresses(meter), on_addresses(log))


@kernel
def half_cycle_on_addresses(
    state: State, scene: Scene, meter: Meter | None, log: Log | Transitions | None
) -> tuple[State, int]:
    """`half_cycle` with addresses in place of the arrays of scene, meter and log.

    A caller that integrates many half cycles can convert the arrays to addresses just once.
    """
    base, curves = scene.base, curves_of(scene)
    since = 0.0  # time since the last transition
    for k in range(base.windows):
        span = window_at(base, k)
        while True:
            if scene.particle is not None and scene.particle.wall is not None:
                if (
                    state.riding > 0.0 or state.gap < 0.0
                ):  # the contact began with a transition, so `since` is 0
                    state, span, outcome = while_in_contact(state, span, k, scene, meter, log)
                    if outcome != ARRIVED:
                        return state, outcome
                    if span.remaining <= 0.0:
                        break
            segment, is_free = _propagate(state, span, scene)
            # most panels take this fast path, but a `Log` needs a row for each panel
            if is_free and span.whole and not isinstance(log, Log):
                if measured_at_ends(meter, segment, scene):
                    state = segment.end
                    since += segment.time
                    break
            expand_motion(
                state, segment.phase, segment.regime, scene, meter, curves.relative, curves.absolute
            )
            segment, kind = _to_event(segment, is_free, span.whole, scene, meter, curves)
            measure(meter, segment, span.whole and kind == NOTHING, scene, curves)
            note_segment(log, state, (k + 1) * base.window - span.remaining, segment.time, kind)
            state = segment.end
            since += segment.time
            if kind == NOTHING:
                break
            scene.counts[SEGMENTS] += 1
            outcome = spend(scene.counts, segment.time, base.window)
            if outcome != ARRIVED:
                return state, outcome
            span = Span(segment.phase_end, span.end, span.remaining - segment.time, False)
            state = after_event(segment.end, kind, span.phase, scene, meter)
            note_transition(log, since, kind, segment.end, state, span.phase)
            since = 0.0
            if span.remaining <= 0.0:
                break
    note_transition(log, since, NOTHING, state, state, phase_until(base, base.windows - 1))
    return next_half_start(base, state), ARRIVED


@inlined
def _propagate(state: State, span: Span, scene: Scene) -> tuple[Segment, bool]:
    """Return the rest of a panel as a segment, and whether this segment provably contains no event.

    A complete panel is first integrated by its matrix, and the absence of events is proved from the states at
    both ends. For part of a panel, the absence of events is proved from the start state alone, and the end
    state is computed later.
    """
    regime = regime_of(state, scene)
    bounds = motion_bounds(state, regime, span, scene.base)
    end = state  # not known yet
    if span.whole:
        end = _cross_window(state, regime, span, scene)
    segment = Segment(state, end, span.phase, span.end, regime, span.remaining, bounds)
    if span.whole:
        return segment, is_free_between(segment, scene)
    return segment, is_free_from(segment, scene)


@inlined
def _cross_window(state: State, regime: Regime, span: Span, scene: Scene) -> State:
    """Integrate over a complete panel without events, by its matrix."""
    base, motion, offset = scene.base, regime.motion, regime.offset
    v = state.v
    w = 0.0
    if not regime.sticks:
        x = state.v + offset
        first = span.phase.first
        second = span.phase.second
        v = (motion.xx * x + motion.xw * state.w) + (motion.xs * first + motion.xc * second) - offset
        w = (motion.wx * x + motion.ww * state.w) + (motion.ws * first + motion.wc * second)
    gap, p_rate = state.gap, state.p_rate
    if scene.particle is not None:
        if state.riding > 0.0:
            p_rate = w + span.end.rate
        else:
            moved = (v - state.v) + travel(base, span.phase, span.end)
            opening = state.p_rate * base.window - moved
            gap, p_rate = _flown(state, opening, base.window, scene.particle)
    return advanced(state, v, w, gap, p_rate, dwell_on(state.dwell, base.window), 0)


@inlined
def _to_event(
    segment: Segment, is_free: bool, whole: bool, scene: Scene, meter: Meter | None, curves: Curves
) -> tuple[Segment, int]:
    """Return a segment up to its first event, and the kind of this event; NOTHING if the segment has no event."""
    t, kind = segment.time, NOTHING
    if not is_free:
        t, kind = next_event(segment, scene, curves)
    end, phase_end = segment.end, segment.phase_end
    if kind != NOTHING or not whole:
        # the end of a complete panel always comes from its matrix, whether or not observables are measured
        end = _advance(segment, t, scene, curves)
    if kind != NOTHING or (meter is not None and meter.energies is not None and not whole):
        expand_excitation(scene.base, segment.phase, curves.excitation)
    if kind != NOTHING:
        phase_end = phase_after(scene.base, segment.phase, curves.excitation, t)
    return segment._replace(end=end, phase_end=phase_end, time=t), kind


@inlined
def _advance(segment: Segment, t: float, scene: Scene, curves: Curves) -> State:
    """Return the state at time t of a segment, from its polynomials."""
    state, absolute = segment.start, curves.absolute
    v, w = mass_at(state, t, segment.regime.sticks, curves.relative)
    gap, p_rate = state.gap, state.p_rate
    if scene.particle is not None:
        if state.riding > 0.0:
            p_rate = slope(absolute, t)
        else:
            # the change of the gap is computed directly, not as a difference of large displacements
            opening = (state.p_rate - absolute[1]) * t - beyond_tangent(absolute, t)
            gap, p_rate = _flown(state, opening, t, scene.particle)
    return advanced(state, v, w, gap, p_rate, dwell_on(state.dwell, t), 0)


@inlined
def _flown(state: State, opening: float, t: float, particle: Particle) -> tuple[float, float]:
    """Gap and velocity of a particle after a flight of duration t; `opening` is the change of p − u at constant p'."""
    gap, p_rate = state.gap + state.wall * opening, state.p_rate
    if particle.friction is not None:
        gained = acceleration_of(state, particle) * t
        gap += state.wall * (0.5 * gained * t)
        p_rate += gained
    return gap, p_rate
