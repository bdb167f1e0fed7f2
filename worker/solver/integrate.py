"""March through half an excitation cycle, or through a record, from event to event.

What a scene lacks is None here, and the compiler drops it: without `friction` there is no search for turns and no stick,
without `particle` no gap, no impact, no riding; without `meter` no peaks, and without its `energies` no integrals; without
`log` no history.
"""

from damperlab.worker.jit import inlined, kernel
from damperlab.worker.solver.contact.compliant.phase import in_wall, through_wall
from damperlab.worker.solver.contact.media import medium_of
from damperlab.worker.solver.contact.reset import pass_event
from damperlab.worker.solver.detection.event_free import is_quiet, most_motion, was_quiet
from damperlab.worker.solver.detection.first_event import next_event
from damperlab.worker.solver.dwell import dwell_on
from damperlab.worker.solver.excitation.base import (
    carry,
    expand_base,
    mirrored,
    phase_after,
    phase_at,
    phase_until,
    travel,
)
from damperlab.worker.solver.memory import address
from damperlab.worker.solver.motion.taylor import TERMS, bend, change, combine, slope, stand
from damperlab.worker.solver.observe.harmonic import Curves, Segment
from damperlab.worker.solver.observe.observables import energies_of, measure, measure_quiet
from damperlab.worker.solver.scene import point_scene
from damperlab.worker.solver.state import (
    ARRIVED,
    BUDGET,
    IDLE,
    NOTHING,
    OUT_OF_EVENTS,
    SEGMENTS,
    STALLED,
    Meter,
    State,
)
from damperlab.worker.solver.transitions import keeps_segments, point_log, record_segment, record_transition

_MOST_IDLE = 64  # events without time moving on before the march gives up


@kernel
def half_cycle(state, scene, meter, log):
    """March a state through half an excitation cycle and mirror it, or through a record, which is not mirrored.

    Parameters
    ----------
    state : State
        At phase 0 of the (mirrored) base, or at the start of the record.
    scene : Scene
        What it is integrated in; its counts are added to.
    meter : Meter or None
        Added to, where given.
    log : Log, Transitions or None
        Takes every segment, or every transition, where given.

    Returns
    -------
    state : State
        Half a cycle later, mirrored: all signs flipped, so that it starts at phase 0 again.
    outcome : int
        ARRIVED, OUT_OF_EVENTS or STALLED.
    """
    return _integrate(state, point_scene(scene), point_meter(meter), point_log(log))


@inlined
def point_meter(meter):
    """The same meter with an address for its sums; the array must outlive it."""
    if meter is None:
        return None
    return Meter(address(meter.sums, 0), meter.energies)


@inlined
def _integrate(state, scene, meter, log):
    """Integrate through all windows of a base, on addresses."""
    base, free, loaded, friction, particle, work, counts = scene
    relative = address(work, 0)
    absolute = address(work, TERMS)
    scratch = address(work, 2 * TERMS)
    shaken = address(work, 3 * TERMS)
    curves = Curves(relative, absolute, shaken, scratch)
    since = 0.0  # time since the last transition
    for k in range(base.windows):
        phase = phase_at(base, k)
        end = phase_until(base, k)
        left = base.window
        whole = True
        while True:
            if particle is not None:
                if in_wall(state, particle.wall):
                    state, phase, left, outcome = through_wall(
                        state,
                        particle.wall,
                        phase,
                        left,
                        k,
                        base,
                        free,
                        loaded,
                        friction,
                        shaken,
                        counts,
                        meter,
                        log,
                    )
                    if outcome != ARRIVED:
                        return state, outcome
                    if left <= 0.0:
                        break
                    whole = False
            held = False
            offset = 0.0
            if friction is not None:
                held = state.slip == 0.0
                offset = state.slip * friction
            medium = free
            if particle is not None:
                medium = medium_of(free, loaded, state.riding, particle.wall)
            _x_most, w_most, u2_most = most_motion(state, offset, held, left, base, phase, medium)
            quiet = False
            if whole:
                # most windows: cross by matrix first, and let both ends together prove that nothing happened between
                crossed = _glide(state, offset, held, phase, end, base, medium, particle)
                quiet = was_quiet(
                    state,
                    crossed,
                    offset,
                    held,
                    phase,
                    end.push,
                    base,
                    medium,
                    friction,
                    particle,
                    state.dwell,
                    w_most,
                    u2_most,
                )
                if quiet and not keeps_segments(log):
                    if meter is None:
                        state = crossed
                        since += base.window
                        break
                    segment = Segment(state, crossed, phase, end, held, offset, base.window, w_most, u2_most)
                    if measure_quiet(meter, segment, base, medium, friction):
                        state = crossed
                        since += base.window
                        break
            else:
                quiet = is_quiet(
                    state,
                    offset,
                    held,
                    phase,
                    left,
                    base,
                    medium,
                    friction,
                    particle,
                    state.dwell,
                    w_most,
                    u2_most,
                )
            if held:
                expand_base(base, phase, absolute)
                stand(state.v, relative, absolute)
            else:
                combine(state.v + offset, state.w, phase.first, phase.second, medium.relative, relative)
                if particle is not None or meter is not None:
                    combine(state.v + offset, state.w, phase.first, phase.second, medium.absolute, absolute)
                    carry(base, phase, absolute)
            t = left
            kind = NOTHING
            if not quiet:
                t, kind = next_event(
                    state,
                    held,
                    phase,
                    left,
                    base,
                    medium,
                    friction,
                    particle,
                    state.dwell,
                    relative,
                    absolute,
                    scratch,
                    w_most,
                    u2_most,
                )
            if kind != NOTHING or not whole:
                # a whole window stays crossed by its matrix, so that the motion has the same bits whatever is measured
                crossed = _coast(state, offset, held, t, particle, relative, absolute)
            reached = end
            if kind != NOTHING or (energies_of(meter) is not None and not whole):
                expand_base(base, phase, shaken)
            if kind != NOTHING:
                reached = phase_after(base, phase, shaken, t)
            if meter is not None:
                segment = Segment(state, crossed, phase, reached, held, offset, t, w_most, u2_most)
                measure(meter, segment, whole and kind == NOTHING, base, medium, friction, curves)
            record_segment(log, state, (k + 1) * base.window - left, t, kind)
            since += t
            state = crossed
            if kind == NOTHING:
                break
            counts[SEGMENTS] += 1
            if counts[SEGMENTS] > counts[BUDGET]:
                return state, OUT_OF_EVENTS
            if t <= 1e-15 * base.window:
                counts[IDLE] += 1
                if counts[IDLE] > _MOST_IDLE:
                    return state, STALLED
            else:
                counts[IDLE] = 0
            phase = reached
            left = left - t
            whole = False
            state = pass_event(state, kind, phase, base, friction, particle, counts, meter)
            record_transition(log, since, kind, crossed, state, phase)
            since = 0.0
            if left <= 0.0:
                break
    record_transition(log, since, NOTHING, state, state, phase_until(base, base.windows - 1))
    return mirrored(base, state), ARRIVED


@inlined
def _glide(state, offset, held, phase, end, base, medium, particle):
    """Cross a window, in which nothing happens, by its matrix."""
    v = state.v
    w = 0.0
    if not held:
        x = state.v + offset
        first = phase.first
        second = phase.second
        v = (medium.xx * x + medium.xw * state.w) + (medium.xs * first + medium.xc * second) - offset
        w = (medium.wx * x + medium.ww * state.w) + (medium.ws * first + medium.wc * second)
    gap = state.gap
    p_rate = state.p_rate
    if particle is not None:
        if state.riding > 0.0:
            p_rate = w + end.rate
        else:
            moved = (v - state.v) + travel(base, phase, end)
            gap = state.gap + state.wall * (state.p_rate * base.window - moved)
    dwell = dwell_on(state.dwell, base.window)
    return State(v, w, state.slip, state.wall, gap, p_rate, state.riding, 0, 0, dwell)


@inlined
def _coast(state, offset, held, t, particle, relative, absolute):
    """State a time t later on the expanded polynomials."""
    v = state.v
    w = 0.0
    if not held:
        v = state.v + change(relative, t)
        w = slope(relative, t)
    gap = state.gap
    p_rate = state.p_rate
    if particle is not None:
        if state.riding > 0.0:
            p_rate = slope(absolute, t)
        else:
            # the gap's own change, no difference of large displacements
            gap = state.gap + state.wall * ((state.p_rate - absolute[1]) * t - bend(absolute, t))
    return State(v, w, state.slip, state.wall, gap, p_rate, state.riding, 0, 0, dwell_on(state.dwell, t))
