"""Section coordinates, which are the part of a state that repeats in a periodic response."""

from math import ceil, inf

import numpy as np
from numpy.typing import NDArray

from damperlab.worker.jit import inlined, kernel
from damperlab.worker.solver.dwell import dwell_at_rest
from damperlab.worker.solver.events import IMPACTS
from damperlab.worker.solver.particle import Particle, Wall
from damperlab.worker.solver.sliding import direction_of, down_of
from damperlab.worker.solver.state import Dwell, State, slide_on

Array = NDArray[np.float64]

SECTION_SIZE = 4
"""Number of coordinates of a state on the section, and of components of a tangent vector."""


@inlined
def has_contact_coordinates(riding: float, speed: float, wall: Wall | None) -> bool:
    """Whether the contact has its own coordinates: True in compliant contact and in a dwell on a rigid wall."""
    return riding > 0.0 and (wall is not None or speed > 0.0)


@inlined
def has_contact(state: State, particle: Particle) -> bool:
    """Whether the last two coordinates of a state describe a contact."""
    if state.dwell is None:
        return False
    return has_contact_coordinates(state.riding, state.dwell.speed, particle.wall)


@kernel
def coordinates(state: State, particle: Particle | None, out: Array) -> None:
    """Write the section coordinates of a state into `out`, shape (SECTION_SIZE,): v, w, p, p' at phase 0, where s = 0.

    For a particle with friction, p' comes before p: if the particle meets no wall, p does not affect the other
    coordinates and is not part of an orbit. In a contact of finite duration, the last two coordinates
    have the sign of the wall: the penetration and its rate, or the time until detachment and the approach speed.
    """
    out[0] = state.v
    out[1] = state.w
    out[2] = 0.0
    out[3] = 0.0
    if particle is not None:
        position = state.v - state.wall * (particle.clearance_ratio - state.gap)
        if particle.friction is not None:
            out[2] = state.p_rate
            out[3] = position
            return
        out[2] = position
        out[3] = state.p_rate
        if state.dwell is not None:
            if has_contact(state, particle):
                of_wall = -state.gap if particle.wall is not None else state.dwell.left
                out[2] = state.wall * of_wall
                out[3] = state.wall * state.dwell.speed


@kernel
def state_at(point: Array, like: State, particle: Particle | None) -> tuple[State, bool]:
    """Return the state with given section coordinates, in the regime (slip, wall, riding) of another state.

    Returns
    -------
    state : State
    possible : bool
        False if the particle would lie beyond a wall, or if the mass would move against the direction of slip.
    """
    v, w = point[0], point[1]
    gap, p_rate, dwell = 0.0, 0.0, like.dwell
    possible = w * like.slip >= 0.0
    if particle is not None:
        widest = 2.0 * particle.clearance_ratio
        if particle.friction is not None:
            p_rate = like.p_rate + (w - like.w) if like.riding > 0.0 else point[2]
            if like.riding == 0.0 or like.gap > 0.0:
                gap = particle.clearance_ratio - like.wall * (v - point[3])
            possible = possible and 0.0 <= gap <= widest
        elif like.riding > 0.0:
            p_rate = like.p_rate + (w - like.w)
            if like.dwell is not None:
                gap, p_rate, dwell, allowed = _contact_at(point, like, p_rate, like.dwell, particle)
                possible = possible and allowed
        else:
            gap = particle.clearance_ratio - like.wall * (v - point[2])
            p_rate = point[3]
            # a particle that has detached may still penetrate a compliant wall
            least_gap = -inf if like.gap < 0.0 else 0.0
            possible = possible and least_gap <= gap <= widest
    slide = slide_on(like.slide)
    moved = like._replace(
        v=v, w=w, gap=gap, p_rate=p_rate, slip_order=0, gap_order=0, dwell=dwell, slide=slide
    )
    return moved, possible


@kernel
def flying_at(
    point: Array, like: State, friction: float | None, particle: Particle | None
) -> tuple[State, bool]:
    """Return the results of `state_at` for a particle in flight.

    The coordinates belong to a motion of the same scene as the state `like`, but perhaps in another regime.
    """
    slip = 0.0
    if friction is not None and point[1] != 0.0:
        slip = 1.0 if point[1] > 0.0 else -1.0
    like = like._replace(slip=slip, gap=0.0, riding=0.0, dwell=dwell_at_rest(particle))
    moved, possible = state_at(point, like, particle)
    return moved, possible


@inlined
def _contact_at(
    point: Array, like: State, p_rate: float, dwell: Dwell, particle: Particle
) -> tuple[float, float, Dwell, bool]:
    """Gap, particle velocity and dwell of a contact at section coordinates, and whether such a contact is possible."""
    gap = 0.0
    allowed = True
    speed = like.wall * point[3]
    if particle.wall is not None:
        gap = -like.wall * point[2]
        p_rate -= like.wall * (speed - dwell.speed)
        allowed = gap <= 0.0 and particle.wall.damping * speed - particle.wall.stiffness * gap >= 0.0
        dwell = Dwell(0.0, speed)
    if particle.contact_time is not None:
        if dwell.speed > 0.0:
            # for a time outside this contact, take the previous or next one, approximately as in a chatter
            left = like.wall * point[2]
            later = 1.0 - ceil(left / particle.contact_time)
            left += later * particle.contact_time
            speed *= particle.restitution**later
            allowed = 0.0 < left <= particle.contact_time and 0.0 < speed < inf
            dwell = Dwell(left, speed)
    return gap, p_rate, dwell, allowed


@kernel
def active_size(state: State, particle: Particle | None, counts: NDArray[np.int64]) -> int:
    """Number of leading coordinates of an orbit: 4, or 2 without a particle or with a particle at rest that was never
    struck.
    """
    if particle is not None:
        if counts[IMPACTS] > 0 or state.p_rate != 0.0:
            return 4
    return 2


@inlined
def are_comparable(one: State, other: State, particle: Particle | None) -> bool:
    """Whether the section coordinates of two states have the same meaning."""
    same = one.riding == other.riding and one.slip == other.slip
    same = same and direction_of(one.slide) == direction_of(other.slide)
    same = same and down_of(one.slide) == down_of(other.slide)
    if particle is not None:
        same = same and has_contact(one, particle) == has_contact(other, particle)
    return same
