"""The linearised motion along recorded segments: flows between events, saltation at events.

Tangent vectors are (δv, δw, δp, δp') at equal times. Between events they follow the homogeneous motion; an event whose
time moves by δt adds the difference of the two vector fields (Aizerman & Gantmakher 1958; Leine & Nijmeijer 2004, ch. 7):
δz⁺ = R_z (δz⁻ + f⁻ δt) + R_t δt − f⁺ δt, with δt = −h_z δz⁻ / (dh/dt).
Contacts that take time are in `lasting`.
"""

from math import cos, exp, sin
from math import log as natural_log

import numpy as np

from damperlab.worker.jit import kernel
from damperlab.worker.solver.contact.media import medium_of
from damperlab.worker.solver.dwell import dwell_at_rest
from damperlab.worker.solver.motion.taylor import TERMS, combine, slope, value
from damperlab.worker.solver.segments import DURATION, EVENT, P_RATE, RIDING, SLIP, START, V, W
from damperlab.worker.solver.state import FAR_WALL, NEAR_WALL, TURN
from damperlab.worker.steady.field import relative_acceleration
from damperlab.worker.steady.lasting import propagate_lasting

SIZE = 4
"""Components of a tangent vector."""


@kernel
def propagate(log, base, free, loaded, friction, particle, tangents, work):
    """Carry tangent vectors through the segments of one half cycle, in place, and mirror them.

    Parameters
    ----------
    log : Log
        The segments of exactly one half cycle.
    base, free, loaded, friction, particle
        As in `integrate.half_cycle`.
    tangents : array, shape (SIZE, n)
        n tangent vectors, in columns, in the coordinates of `orbit.coordinates`.
    work : array, shape (4, TERMS)
        Scratch.

    Notes
    -----
    A mass held by friction forgets δw, a riding particle follows the wall: directions in which a perturbation dies in no
    time have multiplier 0. A chatter is the product of its impacts up to the join.
    """
    _propagate(log, base, free, loaded, friction, particle, dwell_at_rest(particle), tangents, work)


@kernel
def _propagate(log, base, free, loaded, friction, particle, dwell, tangents, work):
    """By the type of `dwell`: contacts at once, or such as take time."""
    if dwell is not None:
        propagate_lasting(log, base, free, loaded, friction, particle, particle.wall, tangents, work)
    else:
        _propagate_at_once(log, base, free, loaded, friction, particle, tangents, work)


@kernel
def _propagate_at_once(log, base, free, loaded, friction, particle, tangents, work):
    """`propagate` where contacts take no time."""
    relative = work[0]
    r = base.frequency_ratio
    count = min(log.cursor[0], log.rows.shape[0])
    columns = tangents.shape[1]
    for i in range(count):
        row = log.rows[i]
        t = row[DURATION]
        riding = row[RIDING]
        slip = row[SLIP]
        start = r * row[START]
        held = False
        offset = 0.0
        if friction is not None:
            held = slip == 0.0
            offset = slip * friction
        v = row[V]
        w = 0.0
        if not held:
            medium = free
            if particle is not None:
                medium = medium_of(free, loaded, riding, particle.wall)
            combine(row[V] + offset, row[W], sin(start), cos(start), medium.relative, relative)
            v = value(relative, t) - offset
            w = slope(relative, t)
            vv = value(medium.relative[0:TERMS], t)
            vw = value(medium.relative[TERMS : 2 * TERMS], t)
            wv = slope(medium.relative[0:TERMS], t)
            ww = slope(medium.relative[TERMS : 2 * TERMS], t)
            for j in range(columns):
                dv = tangents[0, j]
                dw = tangents[1, j]
                tangents[0, j] = vv * dv + vw * dw
                tangents[1, j] = wv * dv + ww * dw
        else:
            for j in range(columns):
                tangents[1, j] = 0.0
        if particle is not None:
            if riding > 0.0:
                for j in range(columns):
                    tangents[2, j] = tangents[0, j]
                    tangents[3, j] = tangents[1, j]
            else:
                for j in range(columns):
                    tangents[2, j] += t * tangents[3, j]
        kind = int(row[EVENT])
        if kind == 0 or i + 1 >= log.rows.shape[0]:
            continue
        sine = sin(start + r * t)
        base_rate = r * cos(start + r * t)
        base_acceleration = -r * r * sine
        after = log.rows[i + 1]
        before_a = relative_acceleration(v, w, slip, riding, sine, base, free, loaded, friction, particle)
        after_a = relative_acceleration(
            after[V], after[W], after[SLIP], after[RIDING], sine, base, free, loaded, friction, particle
        )
        if kind == TURN:
            if before_a == 0.0:
                continue
            for j in range(columns):
                dt = -tangents[1, j] / before_a
                tangents[1, j] = -after_a * dt
                if particle is not None:
                    if riding > 0.0 and after[RIDING] == 0.0:  # released by the turn
                        tangents[2, j] = tangents[0, j]
                        tangents[3, j] = base_acceleration * dt
        elif kind in (NEAR_WALL, FAR_WALL):
            if particle is not None:
                _impact_tangent(
                    row, after, w, base_rate, base_acceleration, before_a, after_a, particle, tangents
                )
    for i in range(SIZE):
        for j in range(columns):
            tangents[i, j] = -tangents[i, j]


@kernel
def _impact_tangent(row, after, w, base_rate, base_acceleration, before_a, after_a, particle, tangents):
    """Saltation at an impact, with the join that may end a chatter."""
    approach = w + base_rate - row[P_RATE]
    if approach == 0.0:
        return
    exchange = (1.0 + particle.restitution) / (1.0 + particle.mass_ratio)
    ridden = after[RIDING] > 0.0
    for j in range(tangents.shape[1]):
        dv = tangents[0, j]
        dw = tangents[1, j]
        dp = tangents[2, j]
        dq = tangents[3, j]
        dt = -(dv - dp) / approach
        shifted = (dw + before_a * dt) + base_acceleration * dt - dq  # change of the approach velocity
        dw_after = dw + before_a * dt - particle.mass_ratio * exchange * shifted
        dq_after = dq + exchange * shifted
        dv_after = dv + w * dt
        dp_after = dp + row[P_RATE] * dt
        if ridden:  # joined: momentum is shared, p follows the wall
            relative = dw_after + base_acceleration * dt - dq_after
            dw_after -= particle.mass_ratio / (1.0 + particle.mass_ratio) * relative
            tangents[0, j] = dv_after - after[W] * dt
            tangents[1, j] = dw_after - after_a * dt
            tangents[2, j] = tangents[0, j]
            tangents[3, j] = tangents[1, j]
        else:
            tangents[0, j] = dv_after - after[W] * dt
            tangents[1, j] = dw_after - after_a * dt
            tangents[2, j] = dp_after - after[P_RATE] * dt
            tangents[3, j] = dq_after


@kernel
def spectral_radius(matrix, size):
    """Largest modulus of the eigenvalues of the leading block: ‖Mᴺ‖^(1/N) for N = 2⁴⁰ (Gelfand), by squaring."""
    a = matrix[:size, :size].copy()
    exponent = 0.0
    weight = 1.0
    for _ in range(40):
        norm = np.abs(a).max()
        if norm == 0.0:
            return 0.0
        a = a / norm
        exponent += weight * natural_log(norm)
        weight *= 0.5
        square = a.copy()
        for i in range(size):
            for j in range(size):
                total = 0.0
                for k in range(size):
                    total += a[i, k] * a[k, j]
                square[i, j] = total
        a = square
    return exp(exponent)
