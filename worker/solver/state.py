"""What the kernels take and hand on: the particle, the state, the meters. Plain named tuples that numba keeps in registers."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray


class Wall(NamedTuple):
    """A compliant wall: a spring and a dashpot side by side that push, and never pull (`physics.contact`).

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


class Meter(NamedTuple):
    """What a march measures: peaks, times and speeds, and where asked for the integrals of energies and squares.

    Attributes
    ----------
    sums : array, shape (METERS,)
        Added to. In a march that ends early, up to there.
    energies : True or None
        None: the kernel holds no integral, and their entries stay 0.
    """

    sums: NDArray[np.float64]
    energies: bool | None = True


# Kinds of event that end a segment.
NOTHING = 0
TURN = 1
SLIP_ONSET = 2
NEAR_WALL = 3
FAR_WALL = 4
RELEASE = 5
LET_GO = 6  # a dwell is over
CLEARANCE = 7  # the particle is out of a compliant wall
PUSH = 8  # a compliant wall pushes again

# Outcome of a march.
ARRIVED = 0
OUT_OF_EVENTS = 2
STALLED = 4
