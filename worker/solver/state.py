"""The state of a motion at one instant, and functions that return a changed state."""

from typing import NamedTuple

from damperlab.worker.jit import inlined


class Dwell(NamedTuple):
    """Data of the present contact, for contacts with a finite duration.

    Attributes
    ----------
    left : float
        Time until detachment [1/ω_n]; 0 in sustained contact, in flight, and on a compliant wall.
    speed : float
        Approach speed [Z ω_n] when the particle met the wall; on a compliant wall, the present rate of penetration.
    """

    left: float
    speed: float


class Slide(NamedTuple):
    """Motion of a particle with friction in its cavity.

    Attributes
    ----------
    direction : float
        Sign of u' − p'; 0 while friction, or a wall, carries the particle along.
    order : int
        Number of leading Taylor coefficients of u' − p' that are zero after the latest event.
    down : float or None
        Direction of gravity: −1 towards negative u, +1 in a mirrored half cycle. None without gravity.
    """

    direction: float
    order: int
    down: float | None = None


class State(NamedTuple):
    """State at one instant, in the mirrored half-cycle frame of `integrate.py`; lengths are divided by Z, and times by 1/ω_n.

    Attributes
    ----------
    v, w : float
        Displacement and velocity relative to the base.
    slip : float
        +1 or −1 while the mass slips in that direction, 0 while friction holds the mass; always 0 without friction.
    wall : float
        +1 if the particle last touched the wall at u − p = +d/Z, −1 if it last touched the other wall.
    gap : float
        Distance of the particle from the wall last touched, exactly 0 after an impact. The gap is negative during
        penetration of a compliant wall. In a short flight, the gap is more accurate than u − p, a difference of large
        numbers.
    p_rate : float
        Absolute particle velocity.
    riding : float
        1 while the particle moves with the mass, on a wall or carried by friction, and while a compliant wall pushes
        the particle; 0 while the particle flies or slides.
    slip_order, gap_order : int
        Numbers of leading Taylor coefficients that are zero after the latest event: for w, and for the gap or, in
        compliant contact, the wall force.
    dwell : Dwell or None
        Data of contacts with a finite duration; None if impacts are instantaneous.
    slide : Slide or None
        Sliding of a particle with friction or gravity; None without friction and gravity.
    """

    v: float
    w: float
    slip: float
    wall: float
    gap: float
    p_rate: float
    riding: float
    slip_order: int
    gap_order: int
    dwell: Dwell | None = None
    slide: Slide | None = None


@inlined
def advanced(
    state: State, v: float, w: float, gap: float, p_rate: float, dwell: Dwell | None, gap_order: int
) -> State:
    """Return a later state in the same regime, in which `slip_order` and `slide.order` are reset to 0."""
    slide = slide_on(state.slide)
    return state._replace(
        v=v, w=w, gap=gap, p_rate=p_rate, slip_order=0, gap_order=gap_order, dwell=dwell, slide=slide
    )


@inlined
def slide_on(slide: Slide | None) -> Slide | None:
    """Return `slide` with the field `order` reset to 0; None if `slide` is None."""
    if slide is None:
        return None
    return slide._replace(order=0)


@inlined
def mirrored(state: State) -> State:
    """State with all signs flipped, so that the next half cycle starts at phase 0 again."""
    return state._replace(
        v=-state.v,
        w=-state.w,
        slip=-state.slip,
        wall=-state.wall,
        p_rate=-state.p_rate,
        slide=_mirrored(state.slide),
    )


@inlined
def _mirrored(slide: Slide | None) -> Slide | None:
    if slide is None:
        return None
    if slide.down is None:
        return slide._replace(direction=-slide.direction)
    return slide._replace(direction=-slide.direction, down=-slide.down)
