"""Periodic orbits by Newton on the section, with the exact Jacobian of the event-driven map."""

from math import ceil, inf, sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from damperlab.worker.jit import inlined, kernel
from damperlab.worker.solver.integrate import half_cycle
from damperlab.worker.solver.motion.contact import Contact
from damperlab.worker.solver.motion.propagator import Base, Medium
from damperlab.worker.solver.scene import Scene
from damperlab.worker.solver.state import ARRIVED, IMPACTS, Dwell, Particle, State, Wall
from damperlab.worker.solver.transitions import Transitions
from damperlab.worker.steady.eigenvalues import spectral_radius
from damperlab.worker.steady.variational import SIZE, is_contact, propagate

Array = NDArray[np.float64]

_ITERATIONS = 10
_CLOSED = 1e-13  # relative distance from closure that counts as rounding
_NEARER = 0.7  # of its first distance: a run that comes so much nearer to an orbit, as predicted, tends to it
_ARRIVED_SHARE = 1e-4  # so near that no prediction is needed
_SINGULAR = 1e-11  # pivot below which the orbit is not isolated

LEAVES, FOLLOWS, APPROACHES = range(3)
"""What a run does about an orbit."""


@kernel
def coordinates(state: State, particle: Particle | None, out: Array) -> None:
    """Section coordinates of a state into `out`, shape (SIZE,): v, w, p, p' at phase 0, where s = 0.

    In a contact that takes time the last two are what varies there, with the sign of the wall: the depth and its rate, or the
    time until the particle is let go and the speed at which it came.
    """
    out[0] = state.v
    out[1] = state.w
    out[2] = 0.0
    out[3] = 0.0
    if particle is not None:
        out[2] = state.v - state.wall * (particle.clearance_ratio - state.gap)
        out[3] = state.p_rate
        _contact_coordinates(state, state.dwell, particle.wall, out)


@inlined
def _contact_coordinates(state: State, dwell: Dwell | None, wall: Wall | None, out: Array) -> None:
    if dwell is not None:
        if is_contact(state.riding, dwell.speed, wall):
            out[2] = -state.wall * state.gap if wall is not None else state.wall * dwell.left
            out[3] = state.wall * dwell.speed


@inlined
def _has_contact(state: State, dwell: Dwell | None, wall: Wall | None) -> bool:
    """Whether the last two coordinates are those of a contact."""
    if dwell is not None:
        return is_contact(state.riding, dwell.speed, wall)
    return False


@kernel
def state_at(point: Array, like: State, particle: Particle | None) -> tuple[State, bool]:
    """State at section coordinates, in the regime (slip, wall, riding) of another state.

    Returns
    -------
    state : State
    possible : bool
        False where the particle would lie beyond a wall, or slip against its direction.
    """
    v, w = point[0], point[1]
    gap = 0.0
    p_rate = 0.0
    dwell = like.dwell
    possible = w * like.slip >= 0.0
    if particle is not None:
        if like.riding > 0.0:
            p_rate = like.p_rate + (w - like.w)
            gap, p_rate, dwell, allowed = _contact_at(
                point, like, p_rate, like.dwell, particle.wall, particle.contact_time, particle.restitution
            )
            possible = possible and allowed
        else:
            gap = particle.clearance_ratio - like.wall * (v - point[2])
            p_rate = point[3]
            least = 0.0
            if like.gap < 0.0:  # let go while still in a compliant wall
                least = -inf
            possible = possible and least <= gap <= 2.0 * particle.clearance_ratio
    return State(v, w, like.slip, like.wall, gap, p_rate, like.riding, 0, 0, dwell), possible


@inlined
def _contact_at(
    point: Array,
    like: State,
    p_rate: float,
    dwell: Any,
    wall: Wall | None,
    contact_time: float | None,
    restitution: float,
) -> tuple[float, float, Any, bool]:
    """Gap, particle velocity and dwell of a contact at section coordinates, and whether there is such a one."""
    gap = 0.0
    allowed = True
    if dwell is not None:
        speed = like.wall * point[3]
        if wall is not None:
            gap = -like.wall * point[2]
            p_rate -= like.wall * (speed - dwell.speed)
            allowed = gap <= 0.0 and wall.damping * speed - wall.stiffness * gap >= 0.0
            dwell = Dwell(0.0, speed)
        if contact_time is not None:
            if dwell.speed > 0.0:
                # beyond its ends lies the contact before or the one after, about as it is in a chatter
                left = like.wall * point[2]
                later = 1.0 - ceil(left / contact_time)
                left += later * contact_time
                speed *= restitution**later
                allowed = 0.0 < left <= contact_time and 0.0 < speed < inf
                dwell = Dwell(left, speed)
    return gap, p_rate, dwell, allowed


@kernel
def around(
    state: State,
    lag: int,
    base: Base,
    free: Medium,
    loaded: Medium | Contact | None,
    friction: float | None,
    particle: Particle | None,
    work: Array,
    counts: NDArray[np.int64],
    log: Transitions,
    monodromy: Array,
) -> tuple[State, bool]:
    """March a state through `lag` half cycles with the Jacobian of the map into `monodromy`, shape (SIZE, SIZE).

    Returns
    -------
    state : State
    complete : bool
        False where the march or its record ended early; the Jacobian is then of no use.
    """
    for i in range(SIZE):
        for j in range(SIZE):
            monodromy[i, j] = 1.0 if i == j else 0.0
    scene = Scene(base, free, loaded, friction, particle, work, counts)
    for _ in range(lag):
        log.cursor[0] = 0
        state, outcome = half_cycle(state, scene, None, log)
        if outcome != ARRIVED or log.cursor[0] > log.capacity:
            return state, False
        propagate(log, base, free, loaded, friction, particle, monodromy)
    return state, True


@kernel
def active_size(state: State, particle: Particle | None, counts: NDArray[np.int64]) -> int:
    """Leading coordinates that an orbit closes in: a particle at rest that was never struck takes no part."""
    if particle is not None:
        if counts[IMPACTS] > 0 or state.p_rate != 0.0:
            return 4
    return 2


@kernel
def _newton_step(
    monodromy: Array,
    residual: Array,
    state: State,
    size: int,
    friction: float | None,
    particle: Particle | None,
    step: Array,
) -> bool:
    """Solve (1 − M) step = residual in the coordinates that are free; False where it is singular.

    A mass held by friction has w = 0, and a riding particle follows the wall: those coordinates do not move.
    """
    free = np.ones(SIZE, np.bool_)
    if friction is not None:
        if state.slip == 0.0:
            free[1] = False
    if particle is not None:
        if state.riding > 0.0 and not _has_contact(state, state.dwell, particle.wall):
            free[2] = False
            free[3] = False
    index = np.empty(SIZE, np.int64)
    n = 0
    for i in range(size):
        step[i] = 0.0
        if free[i]:
            index[n] = i
            n += 1
    a = np.empty((n, n + 1))
    for i in range(n):
        for j in range(n):
            a[i, j] = (1.0 if i == j else 0.0) - monodromy[index[i], index[j]]
        a[i, n] = residual[index[i]]
    for column in range(n):
        pivot = column
        for i in range(column + 1, n):
            if abs(a[i, column]) > abs(a[pivot, column]):
                pivot = i
        if abs(a[pivot, column]) < _SINGULAR:
            return False
        for j in range(n + 1):
            a[column, j], a[pivot, j] = a[pivot, j], a[column, j]
        for i in range(n):
            if i != column:
                factor = a[i, column] / a[column, column]
                for j in range(column, n + 1):
                    a[i, j] -= factor * a[column, j]
    for i in range(n):
        step[index[i]] = a[i, n] / a[i, i]
    return True


@kernel
def _norm(vector: Array, size: int) -> float:
    total = 0.0
    for i in range(size):
        total += vector[i] * vector[i]
    return sqrt(total)


@inlined
def _same_regime(one: State, other: State, particle: Particle | None) -> bool:
    """Whether the coordinates of two states mean the same."""
    same = one.riding == other.riding and one.slip == other.slip
    if particle is not None:
        same = same and _has_contact(one, one.dwell, particle.wall) == _has_contact(
            other, other.dwell, particle.wall
        )
    return same


@kernel
def find_orbit(
    state: State,
    lag: int,
    scale: float,
    reach: float,
    base: Base,
    free: Medium,
    loaded: Medium | Contact | None,
    friction: float | None,
    particle: Particle | None,
    work: Array,
    counts: NDArray[np.int64],
    log: Transitions,
    monodromy: Array,
) -> tuple[State, float, int]:
    """Periodic orbit near a state.

    Parameters
    ----------
    state : State
        On the section, close to the orbit.
    lag : int
        Period in half cycles of the mirrored map.
    scale : float
        Size of the motion.
    reach : float
        Longest step believed.
    monodromy : array, shape (SIZE, SIZE)
        Filled with the Jacobian of the orbit found.

    Returns
    -------
    orbit : State
        On the orbit; meaningless unless found.
    error : float
        Estimated distance from the exact orbit; inf where none was found.
    halves : int
        Half cycles marched.
    """
    size = active_size(state, particle, counts)
    point = np.empty(SIZE)
    end = np.empty(SIZE)
    step = np.zeros(SIZE)
    coordinates(state, particle, point)
    here = state
    halves = 0
    previous = inf
    for _ in range(_ITERATIONS):
        there, complete = around(
            here, lag, base, free, loaded, friction, particle, work, counts, log, monodromy
        )
        halves += lag
        if not complete or not _same_regime(there, here, particle):
            return state, inf, halves
        coordinates(there, particle, end)
        for i in range(SIZE):
            end[i] -= point[i]
        if not _newton_step(monodromy, end, here, size, friction, particle, step):
            return state, inf, halves
        distance = _norm(step, size)
        if _norm(end, size) <= _CLOSED * scale and (distance <= _CLOSED * scale or distance > 0.5 * previous):
            return here, distance, halves  # no step makes it better
        previous = distance
        if not distance <= reach:
            return state, inf, halves
        for i in range(size):
            point[i] += step[i]
        here, possible = state_at(point, here, particle)
        if not possible:
            return state, inf, halves
        coordinates(here, particle, point)  # a riding particle has moved with the mass
    return state, inf, halves


@kernel
def orbit_multiplier(monodromy: Array, size: int, lag: int) -> float:
    """Largest modulus of the Floquet multipliers over one period of the response.

    The map of an odd number of mirrored half cycles is half a period, so its multipliers are squared.
    """
    radius = spectral_radius(monodromy, size)
    return radius * radius if lag % 2 == 1 else radius


@kernel
def follows(
    ring_now: Array,
    orbit_point: Array,
    departure: Array,
    monodromy: Array,
    periods: int,
    size: int,
    scale: float,
) -> int:
    """Whether the run approaches the orbit as its linearisation says, `periods` after a known departure from it.

    Parameters
    ----------
    ring_now : array, shape (SIZE,)
        Section coordinates of the run now.
    orbit_point : array, shape (SIZE,)
        Those of the orbit.
    departure : array, shape (SIZE,)
        Run minus orbit, `periods` periods ago.
    monodromy : array, shape (SIZE, SIZE)
        Jacobian over one period.
    periods, size : int
    scale : float
        Size of the motion.

    Returns
    -------
    verdict : int
        LEAVES, FOLLOWS (as predicted, but hardly nearer than before) or APPROACHES. The middle one is no proof: about an
        orbit with a multiplier near the unit circle a run may wander for good and look for a while as if it settled.
    """
    predicted = departure.copy()
    for _ in range(periods):
        moved = np.zeros(SIZE)
        for i in range(size):
            for j in range(size):
                moved[i] += monodromy[i, j] * predicted[j]
        predicted = moved
    off = 0.0
    now = 0.0
    for i in range(size):
        gone = ring_now[i] - orbit_point[i]
        now += gone * gone
        off += (gone - predicted[i]) ** 2
    now = sqrt(now)
    first = _norm(departure, size)
    if now <= _ARRIVED_SHARE * first:
        return APPROACHES
    if sqrt(off) > 0.25 * now + 1e-10 * scale:
        return LEAVES
    return APPROACHES if now <= _NEARER * first or now <= 1e-10 * scale else FOLLOWS
