"""What the kernels take and hand on: the particle, the state, the meters. Plain named tuples that numba keeps in registers."""

from enum import IntEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.variables import Status
from damperlab.worker.jit import inlined
from damperlab.worker.solver.arrays import filled


class Wall(NamedTuple):
    """A compliant wall: a spring and a dashpot side by side that push, and never pull (`physics.compliant_wall`).

    Attributes
    ----------
    stiffness, damping : float
        K over k, C over k/ω_n.
    """

    stiffness: float
    damping: float


class Particle(NamedTuple):
    """The particle of a scene; a scene without one passes None, and its kernel holds no impact code.

    Attributes
    ----------
    clearance_ratio, restitution, mass_ratio : float
        d/Z, e, β.
    contact_time : float or None
        How long the particle moves with a wall that it strikes [1/ω_n]; None where it leaves at once.
    wall : Wall or None
        Of a cavity with compliant walls, whose constants stand for e; None where walls are rigid.
    """

    clearance_ratio: float
    restitution: float
    mass_ratio: float
    contact_time: float | None = None
    wall: Wall | None = None


def with_floats(particle: Particle) -> Particle:
    """Particle with floats where integers may have been written: a kernel is compiled for one type."""
    contact_time = None if particle.contact_time is None else float(particle.contact_time)
    wall = (
        None if particle.wall is None else Wall(float(particle.wall.stiffness), float(particle.wall.damping))
    )
    return Particle(
        float(particle.clearance_ratio),
        float(particle.restitution),
        float(particle.mass_ratio),
        contact_time,
        wall,
    )


class Dwell(NamedTuple):
    """What a particle whose contacts take time remembers of the one under way.

    Attributes
    ----------
    left : float
        Time left until it is let go [1/ω_n]; 0 where it is not held (it then rides, or flies), and always on a
        compliant wall.
    speed : float
        Approach speed [Z ω_n]: when it met the wall; on a compliant wall at present.
    """

    left: float
    speed: float


class State(NamedTuple):
    """State at one instant, in the mirrored half-cycle frame of `integrate.py`; lengths over Z, time over 1/ω_n.

    Attributes
    ----------
    v, w : float
        Displacement and velocity relative to the base.
    slip : float
        +1 or −1 while the mass slips in that direction, 0 while friction holds it (or where there is no friction).
    wall : float
        +1 where the wall last touched is the one at u − p = +d/Z, −1 for the other.
    gap : float
        Distance of the particle from that wall, exactly 0 after an impact: measuring from the wall keeps the digits of
        a short flight that u − p, a difference of large numbers, would lose. Negative in a compliant wall.
    p_rate : float
        Absolute particle velocity.
    riding : float
        1 while the particle rides on the wall, or a compliant wall pushes it, 0 while it flies.
    slip_order, gap_order : int
        How many leading Taylor coefficients of w, of the gap (of the force of a compliant wall), are zero by the event
        just passed.
    dwell : Dwell or None
        Of a particle whose contacts take time; None without.
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


@inlined
def advanced(
    state: State, v: float, w: float, gap: float, p_rate: float, dwell: Dwell | None, gap_order: int
) -> State:
    """Later in the same regime: no velocity is known to be zero any more."""
    return State(v, w, state.slip, state.wall, gap, p_rate, state.riding, 0, gap_order, dwell)


@inlined
def stopped(state: State, slip: float, p_rate: float, riding: float, gap_order: int) -> State:
    """The mass at rest on the base: sticking for slip 0, else about to slip in that direction."""
    slip_order = 0 if slip == 0.0 else 1
    return State(
        state.v, 0.0, slip, state.wall, state.gap, p_rate, riding, slip_order, gap_order, state.dwell
    )


@inlined
def in_contact(
    state: State,
    w: float,
    slip: float,
    slip_order: int,
    wall: float,
    p_rate: float,
    gap_order: int,
    dwell: Dwell | None,
) -> State:
    """The particle on a wall, with which it moves or which pushes it."""
    return State(state.v, w, slip, wall, 0.0, p_rate, 1.0, slip_order, gap_order, dwell)


@inlined
def in_flight(
    state: State, w: float, slip: float, wall: float, p_rate: float, gap_order: int, dwell: Dwell | None
) -> State:
    """The particle leaving a wall."""
    return State(state.v, w, slip, wall, 0.0, p_rate, 0.0, 0, gap_order, dwell)


@inlined
def mirrored(state: State) -> State:
    """All signs flipped: half a cycle later the base is again where it began."""
    return State(
        -state.v,
        -state.w,
        -state.slip,
        -state.wall,
        state.gap,
        -state.p_rate,
        state.riding,
        state.slip_order,
        state.gap_order,
        state.dwell,
    )


# Counts of events in a march (int64 array of COUNTS entries).
IMPACTS = 0
TURNS = 1
ATTACHMENTS = 2
SEGMENTS = 3
IDLE = 4
BUDGET = 5
COUNTS = 6

# What a meter adds up; energies over k Z², times over 1/ω_n. The first five are integrals.
WORK_IN = 0
VISCOUS_LOSS = 1
FRICTION_LOSS = 2
IMPACT_LOSS = 3
SQUARE = 4  # ∫ u² dτ
STUCK = 5  # time held by friction
SPEED = 6  # largest approach speed of an impact
PEAK = 7  # largest |u| since the last reset
RELATIVE_PEAK = 8  # largest |v| since the last reset
METERS = 9

# What the meter of a record has besides, and the last two one that is asked for the acceleration.
RELATIVE_SQUARE = METERS  # ∫ v² dτ
ACCELERATION_SQUARE = METERS + 1  # ∫ u''² dτ
ACCELERATION_PEAK = METERS + 2  # largest |u''|; under a harmonic excitation since the last reset
RECORD_METERS = METERS + 3


class Meter(NamedTuple):
    """What a march measures: peaks, times and speeds, and where asked for the integrals of energies and squares.

    Attributes
    ----------
    sums : array, shape (METERS,) or (RECORD_METERS,)
        Added to; the longer one under a record, and with the acceleration. In a march that ends early, up to there.
    energies : True or None
        None: the kernel holds no integral, and their entries stay 0.
    acceleration : True or None
        Whether u'' is measured beside the energies, as it always is under a record. None: the kernel holds nothing of it.
    """

    sums: NDArray[np.float64]
    energies: bool | None = True
    acceleration: bool | None = None


@inlined
def make_meter(energies: bool | None, acceleration: bool | None) -> Meter:
    """Meter of zeros for a harmonic excitation."""
    if acceleration is not None:
        return Meter(filled(RECORD_METERS, 0.0), energies, acceleration)
    return Meter(filled(METERS, 0.0), energies, None)


@inlined
def clear_meter(meter: Meter) -> None:
    """Zeros again."""
    for i in range(METERS):
        meter.sums[i] = 0.0
    if meter.acceleration is not None:
        for i in range(METERS, RECORD_METERS):
            meter.sums[i] = 0.0


# Kinds of event that end a segment.
NOTHING = 0
TURN = 1
SLIP_ONSET = 2
NEAR_WALL = 3
FAR_WALL = 4
RELEASE = 5
LET_GO = 6  # a dwell is over
CLEARANCE = 7  # the particle is out of a compliant wall
PUSHED_AGAIN = 8  # a compliant wall pushes again


class Outcome(IntEnum):
    """How an integration ended: those of `Status` that an integration can end with, by the same numbers."""

    ARRIVED = Status.CONVERGED
    OUT_OF_EVENTS = Status.TOO_MANY_EVENTS
    STALLED = Status.NO_PROGRESS


# The same as plain numbers, as kernels take them.
ARRIVED = int(Outcome.ARRIVED)
OUT_OF_EVENTS = int(Outcome.OUT_OF_EVENTS)
STALLED = int(Outcome.STALLED)
