"""The vibration of a contact, the fast part f of its motion: what it is, what it becomes, and what it adds to the motion."""

from math import cos, exp, sin, sqrt
from typing import NamedTuple

from damperlab.worker.jit import inlined, kernel
from damperlab.worker.solver.memory import Floats
from damperlab.worker.solver.motion.contact_motion import ContactMotion
from damperlab.worker.solver.motion.slow_subspace import CENTRE, CENTRE_RATE, DEPTH, DEPTH_RATE, DIM
from damperlab.worker.solver.particle import Wall

_NOISE = 2e-15  # of f, relative to the terms that it is the difference of


class Vibration(NamedTuple):
    """f of a motion in contact (`contact_motion`)."""

    first: float
    second: float


class LinearForm(NamedTuple):
    """What a quantity has of the vibration: first · f₁ + second · f₂."""

    first: float
    second: float


@kernel
def vibration_of(coordinates: Floats, motion: ContactMotion) -> tuple[Vibration, bool]:
    """The vibration at six coordinates, and whether it has died down to the rounding of what it is a difference of."""
    first = 0.0
    second = 0.0
    first_terms = 0.0
    second_terms = 0.0
    for i in range(DIM):
        one = motion.fast_of[i] * coordinates[i]
        other = motion.fast_of[DIM + i] * coordinates[i]
        first += one
        second += other
        first_terms += abs(one)
        second_terms += abs(other)
    noise = _NOISE * (motion.weight * first_terms + second_terms)
    settled = sqrt(second * second + (motion.weight * first) ** 2) <= noise
    return Vibration(first, second), settled


@inlined
def fast_part(coordinates: Floats, motion: ContactMotion) -> Vibration:
    """The vibration at six coordinates, whatever its size."""
    first = 0.0
    second = 0.0
    for i in range(DIM):
        first += motion.fast_of[i] * coordinates[i]
        second += motion.fast_of[DIM + i] * coordinates[i]
    return Vibration(first, second)


@inlined
def take_out(coordinates: Floats, vibration: Vibration, motion: ContactMotion) -> None:
    """Leave the slow motion alone in the coordinates."""
    for i in range(DIM):
        coordinates[i] -= share_of(vibration, form_of(i, motion))


@inlined
def share_of(vibration: Vibration, form: LinearForm) -> float:
    """What a quantity has of a vibration."""
    return form.first * vibration.first + form.second * vibration.second


@inlined
def form_of(coordinate: int, motion: ContactMotion) -> LinearForm:
    """What a coordinate has of the vibration."""
    return LinearForm(motion.of_fast[2 * coordinate], motion.of_fast[2 * coordinate + 1])


@inlined
def form_of_x(motion: ContactMotion) -> LinearForm:
    """What x = X + share · y has of it."""
    centre, depth = form_of(CENTRE, motion), form_of(DEPTH, motion)
    return LinearForm(centre.first + motion.share * depth.first, centre.second + motion.share * depth.second)


@inlined
def form_of_w(motion: ContactMotion) -> LinearForm:
    """What w = X' + share · y' has of it."""
    centre, depth = form_of(CENTRE_RATE, motion), form_of(DEPTH_RATE, motion)
    return LinearForm(centre.first + motion.share * depth.first, centre.second + motion.share * depth.second)


@inlined
def form_of_wall_force(motion: ContactMotion, wall: Wall) -> LinearForm:
    """What Ky + Cy' has of it."""
    depth, rate = form_of(DEPTH, motion), form_of(DEPTH_RATE, motion)
    return LinearForm(
        wall.stiffness * depth.first + wall.damping * rate.first,
        wall.stiffness * depth.second + wall.damping * rate.second,
    )


@inlined
def size_of(vibration: Vibration, weight: float) -> float:
    """√(f₂² + Ω²f₁²), which falls while the vibration dies away."""
    return sqrt(vibration.second * vibration.second + (weight * vibration.first) ** 2)


@inlined
def gain_of(form: LinearForm, weight: float) -> float:
    """Largest value of a linear form over the size of the vibration."""
    return sqrt((form.first / weight) ** 2 + form.second * form.second)


@kernel
def vibration_after(vibration: Vibration, rates: Floats, t: float) -> Vibration:
    """f a time t later: exp(Ft) f, with the four elements of F.

    Notes
    -----
    With m half the trace of F and δ = ((a − d)/2)² + bc, exp(Ft) is exp(mt) (cosh(√δ t) + (F − m) sinh(√δ t)/√δ).
    """
    first, second = vibration
    a, b, c, d = rates[0], rates[1], rates[2], rates[3]
    middle = 0.5 * (a + d)
    discriminant = 0.25 * (a - d) * (a - d) + b * c
    if discriminant < 0.0:
        frequency = sqrt(-discriminant)
        decay = exp(middle * t)
        even = decay * cos(frequency * t)
        odd = decay * sin(frequency * t) / frequency
    else:
        spread = sqrt(discriminant)
        if spread * t < 1e-4:
            decay = exp(middle * t)
            even = decay * (1.0 + 0.5 * (spread * t) ** 2)
            odd = decay * t * (1.0 + (spread * t) ** 2 / 6.0)
        else:
            quick = middle - spread
            slow = (a * d - b * c) / quick
            one = exp(quick * t)
            other = exp(slow * t)
            even = 0.5 * (other + one)
            odd = 0.5 * (other - one) / spread
    half_difference = 0.5 * (a - d)
    return Vibration(
        even * first + odd * (half_difference * first + b * second),
        even * second + odd * (c * first - half_difference * second),
    )
