"""The variational equations of a half cycle: linear motion between events, and one saltation law at every event.

A tangent vector is (δv, δw, δy, δy') at equal times, with y = u − p. The coordinate is y and not p, because
the small δy after a chatter would be lost in δp. While a particle dwells on a rigid wall, y is constant, so
changes of the time until detachment and of the approach speed, (±δleft, ±δspeed), replace δy and δy'. The
sign ± is the sign of the wall, so that all components change sign when a half cycle is mirrored. On the
section, p and p' replace y and y' of a particle in flight (`section.coordinates.coordinates`).
"""

import numpy as np
from numpy.typing import NDArray

from damperlab.worker.jit import inlined
from damperlab.worker.solver.addresses import address
from damperlab.worker.solver.events import FAR_WALL, LET_GO, NEAR_WALL, PUSHED_AGAIN, RELEASE, REST, TURN
from damperlab.worker.solver.linear_motion import LinearMotion
from damperlab.worker.solver.motion.compliant_motion import Contact, write_coordinates
from damperlab.worker.solver.motion.taylor import TERMS, beyond_tangent, change, slope
from damperlab.worker.solver.motion.vibration import contact_at, expand_over
from damperlab.worker.solver.particle import Wall
from damperlab.worker.solver.regime import motion_of, slip_regime
from damperlab.worker.solver.scene import Scene
from damperlab.worker.solver.transition_log import Side, Transition, Transitions, transition_at
from damperlab.worker.steady.section.coordinates import SECTION_SIZE, has_contact_coordinates
from damperlab.worker.steady.stability.saltation import field, leaving_speed, pass_contact, pass_event

Array = NDArray[np.float64]


@inlined
def propagate(log: Transitions, scene: Scene, tangents: Array) -> None:
    """Propagate tangent vectors through the transitions of exactly one half cycle, in place, and mirror them.

    `tangents`, shape (SECTION_SIZE, n), contains n tangent vectors, in columns, in the coordinates of
    `section.coordinates.coordinates`. While friction holds the mass, δw is 0. In sustained contact on a rigid
    wall, δy and δy' are 0. Each component that is fixed at 0 has a multiplier of 0. The matrix of a chatter
    is the product of the matrices of its impacts.
    """
    rows, particle = log.rows, scene.particle
    z = address(tangents, 0)
    n = tangents.shape[1]
    count = min(log.cursor[0], log.capacity)
    if particle is not None and count > 0:
        if particle.friction is not None:
            _enter_rubbing(transition_at(rows, 0).before, scene.friction, z, n)
        else:
            _enter(transition_at(rows, 0).before, scene.friction, particle.wall, z, n)
    resume = 0
    for i in range(count):
        if i < resume:
            continue
        event = transition_at(rows, i)
        _pass_span(event, scene, z, n)
        kind = int(event.event)
        to = i
        if particle is not None:
            if kind == LET_GO:
                if event.after.riding > 0.0 and i + 1 < count:
                    following = transition_at(rows, i + 1)
                    if following.span == 0.0 and following.event == RELEASE:
                        resume = i + 2  # the particle stays on the wall, but the wall at once moves away
                        to = i + 1
        if kind in (TURN, NEAR_WALL, FAR_WALL, LET_GO, PUSHED_AGAIN, REST):
            ends = transition_at(rows, to)
            before = field(event.before, event, scene)
            after = field(ends.after, ends, scene)
            if kind == TURN:
                pass_event(1, before.w, 0.0, 1.0, before, after, z, n)
            elif kind == REST:
                pass_event(3, before.y_rate, 0.0, 1.0, before, after, z, n)
            elif particle is not None:
                if kind == LET_GO:
                    speed = leaving_speed(rows, event, to, count, scene, particle)
                    after = after._replace(y=-event.before.wall * speed)
                pass_contact(ends.after, kind == LET_GO, before, after, particle, z, n)
    if particle is not None and count > 0:
        if particle.friction is not None:
            _leave_rubbing(z, n)
        else:
            _leave(transition_at(rows, count - 1).after, particle.wall, z, n)
    for i in range(SECTION_SIZE * n):
        z[i] = -z[i]


@inlined
def _pass_span(event: Transition, scene: Scene, z: Array, n: int) -> None:
    """Propagate through the span before an event."""
    span, riding = event.span, event.before.riding
    held, _ = slip_regime(event.before.slip, scene.friction)
    if scene.particle is not None and scene.particle.wall is not None:
        if riding > 0.0:
            _flow_in_contact(span, held, scene.loaded, z, n)
            return
    _flow(span, held, riding == 0.0, motion_of(riding, scene), scene, z, n)


@inlined
def _enter(start: Side, friction: float | None, wall: Wall | None, z: Array, n: int) -> None:
    """Convert tangent vectors from section coordinates."""
    contact = has_contact_coordinates(start.riding, start.speed, wall)
    held, _ = slip_regime(start.slip, friction)
    for j in range(n):
        if held:
            z[n + j] = 0.0
        if not contact:
            z[2 * n + j] = z[j] - z[2 * n + j] if start.riding == 0.0 else 0.0
            z[3 * n + j] = z[n + j] - z[3 * n + j] if start.riding == 0.0 else 0.0


@inlined
def _leave(end: Side, wall: Wall | None, z: Array, n: int) -> None:
    """Convert tangent vectors to section coordinates."""
    if not has_contact_coordinates(end.riding, end.speed, wall):
        for j in range(n):
            z[2 * n + j] = z[j] - z[2 * n + j]
            z[3 * n + j] = z[n + j] - z[3 * n + j]


@inlined
def _enter_rubbing(start: Side, friction: float | None, z: Array, n: int) -> None:
    """Convert tangent vectors from the section coordinates of a particle with friction, in which p' comes before p."""
    carried = start.riding > 0.0
    on_wall = carried and start.gap == 0.0
    held, _ = slip_regime(start.slip, friction)
    for j in range(n):
        if held:
            z[n + j] = 0.0
        y = 0.0 if on_wall else z[j] - z[3 * n + j]
        y_rate = 0.0 if carried else z[n + j] - z[2 * n + j]
        z[2 * n + j] = y
        z[3 * n + j] = y_rate


@inlined
def _leave_rubbing(z: Array, n: int) -> None:
    """Convert tangent vectors to the section coordinates of a particle with friction."""
    for j in range(n):
        p_rate = z[n + j] - z[3 * n + j]
        z[3 * n + j] = z[j] - z[2 * n + j]
        z[2 * n + j] = p_rate


@inlined
def _flow(span: float, held: bool, flies: bool, motion: LinearMotion, scene: Scene, z: Array, n: int) -> None:
    """Propagate through a span without an event, with the particle in flight or moving with the mass."""
    if held:
        for j in range(n):
            z[n + j] = 0.0
            if scene.particle is not None:
                if flies:
                    z[2 * n + j] += span * z[3 * n + j]
        return
    window = scene.base.window
    of_v, of_w = address(motion.relative_rows, 0), address(motion.relative_rows, TERMS)
    windows = int(span / window)
    rest = span - windows * window
    vv_change = change(of_v, rest)  # difference from the matrix of motion at constant velocity
    vw_change = beyond_tangent(of_w, rest)
    wv = slope(of_v, rest)
    ww = slope(of_w, rest)
    if windows > 0:
        vv = 1.0 + vv_change
        vw = rest + vw_change
        for _ in range(windows):
            vv, wv = motion.xx * vv + motion.xw * wv, motion.wx * vv + motion.ww * wv
            vw, ww = motion.xx * vw + motion.xw * ww, motion.wx * vw + motion.ww * ww
        vv_change = vv - 1.0
        vw_change = vw - span
    for j in range(n):
        dv = z[j]
        dw = z[n + j]
        bent = vv_change * dv + vw_change * dw
        later = wv * dv + ww * dw
        if scene.particle is not None:
            if flies:
                z[2 * n + j] += span * z[3 * n + j] + bent
                z[3 * n + j] += later - dw
        z[j] = dv + (span * dw + bent)
        z[n + j] = later


@inlined
def _flow_in_contact(span: float, held: bool, contact: Contact, tangents: Array, n: int) -> None:
    """Propagate through a span in contact, which is at most as long as a contact segment.

    A span longer than `motion.step` uses polynomials for the slow motion and an exponential for the vibration.
    """
    motion = contact.held if held else contact.slipping
    buffers = contact.buffers
    start, relative, depth = buffers.start, buffers.relative, buffers.y
    for j in range(n):
        dx, dw = tangents[j], 0.0 if held else tangents[n + j]
        dy, dy_rate = tangents[2 * n + j], tangents[3 * n + j]
        write_coordinates(dx, dw, 0.0, 0.0, dy, dy_rate, motion.share, start)
        vibration = expand_over(span, start, motion, relative, depth)
        x, w, y, y_rate = contact_at(span, vibration, motion, relative, depth)
        if held:
            tangents[n + j] = 0.0
        else:
            tangents[j] = x
            tangents[n + j] = w
        tangents[2 * n + j] = y
        tangents[3 * n + j] = y_rate
