"""The linearised motion of scenes whose contacts take time, dwelling or on compliant walls.

As in `tangent`, but a tangent vector is (δv, δw, δy, δy') with y = u − p: what a chatter leaves of δy would be lost in δp.
While a rigid wall holds the particle, y does not vary: (±δleft, ±δspeed) stand in its place, the time until it is let go and
the speed at which it came, with the sign of the wall, so that they change sign with all others when half a cycle is mirrored.
"""

from math import cos, sin

from damperlab.worker.jit import inlined, kernel
from damperlab.worker.solver.contact.compliant.motion import DEPTH, RELATIVE, combine_rows
from damperlab.worker.solver.contact.compliant.slow_subspace import DIM, fast_later
from damperlab.worker.solver.contact.media import medium_of, point_loaded
from damperlab.worker.solver.motion.taylor import TERMS, bend, change, combine, slope, value
from damperlab.worker.solver.segments import APPROACH, DURATION, EVENT, GAP, RIDING, SLIP, START, WALL, V, W
from damperlab.worker.solver.state import FAR_WALL, LET_GO, NEAR_WALL, PUSH, RELEASE, TURN
from damperlab.worker.steady.field import relative_acceleration

# Flights of a chatter shorter than this [1/ω_n] are left out: their length, of speeds near rounding, has few digits. What
# they change is in proportion to it.
_BRIEF = 1e-9


@inlined
def is_contact(riding, approach, wall):
    """Whether a contact has coordinates of its own: the particle is pushed by a compliant wall, or held by a rigid one."""
    if wall is not None:
        return riding > 0.0
    return riding > 0.0 and approach > 0.0


@kernel
def propagate_lasting(log, base, free, loaded_arrays, friction, particle, wall, tangents, work):
    """Carry tangent vectors through the segments of one half cycle, in place, and mirror them.

    Parameters
    ----------
    wall : Wall or None
        `particle.wall`, once more by itself: its type tells the compiler which contact it is.
    log, base, free, loaded_arrays, friction, particle, tangents, work
        As in `tangent.propagate`.

    Notes
    -----
    On a compliant wall the state never jumps; the field does where the mass turns, and where the dashpot meets a wall at
    speed. A dwell ends δleft late, and with e δspeed more.
    """
    loaded = point_loaded(loaded_arrays, wall)
    r = base.frequency_ratio
    relative = work[0]
    count = min(log.cursor[0], log.rows.shape[0])
    columns = tangents.shape[1]
    contact = False
    resume = 0
    for i in range(count):
        if i < resume:
            continue
        row = log.rows[i]
        t = row[DURATION]
        riding = row[RIDING]
        start = r * row[START]
        held = False
        offset = 0.0
        if friction is not None:
            held = row[SLIP] == 0.0
            offset = row[SLIP] * friction
        contact = is_contact(riding, row[APPROACH], wall)
        if i == 0:
            _enter(tangents, held, riding, contact)
        v = row[V]
        w = 0.0
        if wall is not None and riding > 0.0:
            _flow_pressed(t, held, loaded, wall, tangents)
        elif held:
            for j in range(columns):
                tangents[1, j] = 0.0
                if riding == 0.0:
                    tangents[2, j] += t * tangents[3, j]
        else:
            medium = medium_of(free, loaded_arrays, riding, wall)
            combine(row[V] + offset, row[W], sin(start), cos(start), medium.relative, relative)
            v = value(relative, t) - offset
            w = slope(relative, t)
            _flow(t, riding, medium.relative[0:TERMS], medium.relative[TERMS : 2 * TERMS], tangents)
        kind = int(row[EVENT])
        if kind == 0 or i + 1 >= count:
            continue
        after = log.rows[i + 1]
        if wall is not None:  # nothing jumps
            v = after[V]
            w = after[W]
        sine = sin(start + r * t)
        before_a = relative_acceleration(
            v, w, row[SLIP], riding, sine, base, free, loaded_arrays, friction, particle
        )
        after_a = relative_acceleration(
            after[V],
            after[W],
            after[SLIP],
            after[RIDING],
            sine,
            base,
            free,
            loaded_arrays,
            friction,
            particle,
        )
        push = _push(after, wall)
        if friction is None or after[SLIP] != 0.0:
            after_a -= push
        if kind == TURN:
            _pass_turn(
                before_a - push, after_a, -r * r * sine, riding, after[RIDING], contact, wall, tangents
            )
        elif kind in (NEAR_WALL, FAR_WALL, PUSH):
            _pass_strike(row, after, w, push, before_a, after_a, -r * r * sine, particle, wall, tangents)
        elif kind == LET_GO:
            resume, flown = _brief_flight(log.rows, i + 1, count)
            if resume > 0:  # it comes back before anything else has changed, held anew
                for j in range(columns):
                    tangents[2, j] += flown / row[APPROACH] * tangents[3, j]
                    tangents[3, j] *= particle.restitution
                continue
            if after[RIDING] > 0.0 and after[DURATION] == 0.0 and after[EVENT] == RELEASE and i + 2 < count:
                resume = i + 2  # it would ride on, but for the wall that runs away
                after = log.rows[resume]
            _pass_let_go(row, after, w, before_a, after_a, -r * r * sine, particle, tangents)
    for j in range(columns):
        if not contact:
            tangents[2, j] = tangents[0, j] - tangents[2, j]
            tangents[3, j] = tangents[1, j] - tangents[3, j]
        for i in range(tangents.shape[0]):
            tangents[i, j] = -tangents[i, j]


@inlined
def _brief_flight(rows, first, count):
    """Row after a flight that ends on the wall where it began, and its length; 0 where it is not a brief one."""
    flown = 0.0
    for i in range(first, count - 1):
        flown += rows[i, DURATION]
        if rows[i, RIDING] > 0.0 or flown > _BRIEF:
            break
        if rows[i, EVENT] == NEAR_WALL:
            return i + 1, flown
    return 0, flown


@kernel
def _enter(tangents, held, riding, contact):
    """From section coordinates, where p and p' stand in the place of y and y' in flight."""
    for j in range(tangents.shape[1]):
        if held:
            tangents[1, j] = 0.0
        if not contact:
            tangents[2, j] = tangents[0, j] - tangents[2, j] if riding == 0.0 else 0.0
            tangents[3, j] = tangents[1, j] - tangents[3, j] if riding == 0.0 else 0.0


@kernel
def _flow(t, riding, of_v, of_w, tangents):
    """A span of slip, the particle in flight or held by a rigid wall."""
    v_more = change(of_v, t)
    w_more = bend(of_w, t)
    wv = slope(of_v, t)
    ww = slope(of_w, t)
    for j in range(tangents.shape[1]):
        dv = tangents[0, j]
        dw = tangents[1, j]
        later = wv * dv + ww * dw
        if riding == 0.0:
            tangents[2, j] += t * tangents[3, j] + (v_more * dv + w_more * dw)
            tangents[3, j] += later - dw
        tangents[0, j] = dv + (v_more * dv + (t + w_more) * dw)
        tangents[1, j] = later


@kernel
def _flow_pressed(t, held, contact, wall, tangents):
    """A span in contact with a compliant wall; over a long one the fast part goes by its exponential, as in `phase`."""
    if wall is None:
        return
    motion = contact.held if held else contact.slipping
    buffers = contact.buffers
    start, relative, depth = buffers.start, buffers.relative, buffers.depth
    u = motion.writer
    s = motion.share
    for j in range(tangents.shape[1]):
        start[0] = tangents[0, j] - s * tangents[2, j]
        start[1] = 0.0 if held else tangents[1, j] - s * tangents[3, j]
        start[2] = 0.0
        start[3] = 0.0
        start[4] = tangents[2, j]
        start[5] = tangents[3, j]
        one = 0.0
        two = 0.0
        if motion.fast > 0 and t > motion.step:
            first = 0.0
            second = 0.0
            for i in range(DIM):
                first += motion.reader[i] * start[i]
                second += motion.reader[DIM + i] * start[i]
            for i in range(DIM):
                start[i] -= u[2 * i] * first + u[2 * i + 1] * second
            one, two = fast_later(motion.rates, first, second, t)
            combine_rows(RELATIVE, start, DIM - motion.fast, motion.slow_rows, relative)
            combine_rows(DEPTH, start, DIM - motion.fast, motion.slow_rows, depth)
        else:
            combine_rows(RELATIVE, start, DIM, motion.rows, relative)
            combine_rows(DEPTH, start, DIM, motion.rows, depth)
        if held:
            tangents[1, j] = 0.0
        else:
            tangents[0, j] = value(relative, t) + ((u[0] + s * u[8]) * one + (u[1] + s * u[9]) * two)
            tangents[1, j] = slope(relative, t) + ((u[2] + s * u[10]) * one + (u[3] + s * u[11]) * two)
        tangents[2, j] = value(depth, t) + (u[8] * one + u[9] * two)
        tangents[3, j] = slope(depth, t) + (u[10] * one + u[11] * two)


@inlined
def _push(row, wall):
    """Force of a compliant wall on the particle at the start of a segment, with its sign."""
    if wall is not None:
        if row[RIDING] > 0.0:
            return row[WALL] * (wall.damping * row[APPROACH] - wall.stiffness * row[GAP])
    return 0.0


@kernel
def _pass_turn(before_a, after_a, base_acceleration, riding, riding_after, contact, wall, tangents):
    """The mass stops, and goes on in another way or not at all."""
    if before_a == 0.0:
        return
    for j in range(tangents.shape[1]):
        dw = tangents[1, j]
        dt = -dw / before_a
        tangents[1, j] = -after_a * dt
        if wall is not None or riding == 0.0:
            tangents[3, j] += tangents[1, j] - dw
        elif riding_after == 0.0 and not contact:  # released by the turn
            tangents[3, j] = -(after_a + base_acceleration) * dt


@kernel
def _pass_strike(row, after, w, push, before_a, after_a, base_acceleration, particle, wall, tangents):
    """The particle meets a wall at speed: the dashpot of a compliant one pushes, a rigid one holds it."""
    if row[RIDING] > 0.0 or after[RIDING] == 0.0:
        return
    if after[APPROACH] <= 0.0:
        if wall is None:
            for j in range(tangents.shape[1]):
                tangents[2, j] = 0.0
                tangents[3, j] = 0.0
        return
    rate = after[WALL] * after[APPROACH]
    if wall is not None:
        for j in range(tangents.shape[1]):
            dt = -tangents[2, j] / rate
            tangents[1, j] += (before_a - after_a) * dt
            tangents[3, j] += (before_a - after_a + push / particle.mass_ratio) * dt
    else:
        share = particle.mass_ratio / (1.0 + particle.mass_ratio)
        for j in range(tangents.shape[1]):
            dt = -tangents[2, j] / rate
            shifted = tangents[3, j] + (before_a + base_acceleration) * dt
            tangents[0, j] += (w - after[W]) * dt
            tangents[1, j] += (before_a - after_a) * dt - share * shifted
            tangents[2, j] = after[WALL] * dt
            tangents[3, j] = shifted


@kernel
def _pass_let_go(row, after, w, before_a, after_a, base_acceleration, particle, tangents):
    """A dwell is over: a flight, or riding on the wall."""
    share = particle.mass_ratio / (1.0 + particle.mass_ratio)
    for j in range(tangents.shape[1]):
        dt = row[WALL] * tangents[2, j]
        leaving = particle.restitution * tangents[3, j]
        tangents[0, j] += (w - after[W]) * dt
        tangents[1, j] += (before_a - after_a) * dt
        tangents[2, j] = 0.0
        tangents[3, j] = 0.0
        if after[RIDING] == 0.0:
            tangents[1, j] -= share * leaving
            tangents[2, j] = row[WALL] * particle.restitution * row[APPROACH] * dt
            tangents[3, j] = -leaving - (after_a + base_acceleration) * dt
