"""The vibration of a contact, which is the fast part f of the motion: value, decay and contributions."""

from math import cos, exp, sin, sqrt
from typing import NamedTuple

from damperlab.worker.jit import inlined, kernel
from damperlab.worker.solver.addresses import Floats
from damperlab.worker.solver.motion.compliant_motion import OF_RELATIVE, OF_Y, CompliantMotion, combine_rows
from damperlab.worker.solver.motion.slow_subspace import CENTRE, CENTRE_RATE, DIM, Y_RATE, Y
from damperlab.worker.solver.motion.taylor import slope, value
from damperlab.worker.solver.particle import Wall

_NOISE = 2e-15  # rounding error of f, relative to the sum of the moduli of the terms of f
ENVELOPE_SAFETY = 2.0
"""Assumed upper limit of the ratio of a vibration's size to the initial size.

The vibration decays, but weak coupling to the slow motion might first increase its size. The limit is not derived.
"""


class Vibration(NamedTuple):
    """The fast coordinates f of a motion in contact (`compliant_motion`)."""

    first: float
    second: float


class LinearForm(NamedTuple):
    """Coefficients l of the vibration's contribution to a quantity: l·f = first · f₁ + second · f₂."""

    first: float
    second: float


@kernel
def vibration_of(coordinates: Floats, motion: CompliantMotion) -> tuple[Vibration, bool]:
    """Return the vibration at given coordinates, and whether the vibration has decayed to its rounding error."""
    first = 0.0
    second = 0.0
    first_terms = 0.0
    second_terms = 0.0
    for i in range(DIM):
        one = motion.to_fast[i] * coordinates[i]
        other = motion.to_fast[DIM + i] * coordinates[i]
        first += one
        second += other
        first_terms += abs(one)
        second_terms += abs(other)
    noise = _NOISE * (motion.weight * first_terms + second_terms)
    settled = sqrt(second * second + (motion.weight * first) ** 2) <= noise
    return Vibration(first, second), settled


@inlined
def vibration_at(coordinates: Floats, motion: CompliantMotion) -> Vibration:
    """Return the vibration at given coordinates."""
    first = 0.0
    second = 0.0
    for i in range(DIM):
        first += motion.to_fast[i] * coordinates[i]
        second += motion.to_fast[DIM + i] * coordinates[i]
    return Vibration(first, second)


@inlined
def subtract_vibration(coordinates: Floats, vibration: Vibration, motion: CompliantMotion) -> None:
    """Subtract the vibration from the six coordinates in place, so that the slow motion (ξ, Pξ) remains."""
    for i in range(DIM):
        coordinates[i] -= value_of_form(vibration, form_of(i, motion))


@inlined
def value_of_form(vibration: Vibration, form: LinearForm) -> float:
    """Return the vibration's contribution to a quantity with this linear form: first · f₁ + second · f₂."""
    return form.first * vibration.first + form.second * vibration.second


@inlined
def form_of(coordinate: int, motion: CompliantMotion) -> LinearForm:
    """Linear form of the vibration's contribution to one of the six coordinates: a row of `from_fast`."""
    return LinearForm(motion.from_fast[2 * coordinate], motion.from_fast[2 * coordinate + 1])


@inlined
def form_of_x(motion: CompliantMotion) -> LinearForm:
    """Linear form of the vibration's contribution to x = X + share · y."""
    centre, depth = form_of(CENTRE, motion), form_of(Y, motion)
    return LinearForm(centre.first + motion.share * depth.first, centre.second + motion.share * depth.second)


@inlined
def form_of_w(motion: CompliantMotion) -> LinearForm:
    """Linear form of the vibration's contribution to w = X' + share · y'."""
    centre, depth = form_of(CENTRE_RATE, motion), form_of(Y_RATE, motion)
    return LinearForm(centre.first + motion.share * depth.first, centre.second + motion.share * depth.second)


@inlined
def form_of_wall_force(motion: CompliantMotion, wall: Wall) -> LinearForm:
    """Linear form of the vibration's contribution to the wall force Ky + Cy'."""
    depth, rate = form_of(Y, motion), form_of(Y_RATE, motion)
    return LinearForm(
        wall.stiffness * depth.first + wall.damping * rate.first,
        wall.stiffness * depth.second + wall.damping * rate.second,
    )


@inlined
def size_of(vibration: Vibration, weight: float) -> float:
    """Return the size √(f₂² + Ω²f₁²) of a vibration."""
    return sqrt(vibration.second * vibration.second + (weight * vibration.first) ** 2)


@inlined
def gain_of(form: LinearForm, weight: float) -> float:
    """Largest ratio of a linear form to the size of the vibration."""
    return sqrt((form.first / weight) ** 2 + form.second * form.second)


@kernel
def vibration_after(vibration: Vibration, rates: Floats, t: float) -> Vibration:
    """Return the vibration after a time t, exp(Λt) f, from the four elements of Λ.

    Notes
    -----
    Let Λ = [[a, b], [c, d]], m = (a + d)/2 < 0 and δ = ((a − d)/2)² + bc. Then exp(Λt) = e^(mt) (cosh(√δ t) +
    (Λ − m) sinh(√δ t)/√δ). For δ < 0, cos and sin of √−δ t replace cosh and sinh. The smaller rate is
    computed as det Λ divided by the larger rate, because the sum m + √δ would lose digits by cancellation.
    """
    first, second = vibration
    a, b, c, d = rates[0], rates[1], rates[2], rates[3]
    middle = 0.5 * (a + d)
    discriminant = 0.25 * (a - d) * (a - d) + b * c
    if discriminant < 0.0:
        frequency = sqrt(-discriminant)
        decay = exp(middle * t)
        cosh_part = decay * cos(frequency * t)
        sinh_part = decay * sin(frequency * t) / frequency
    else:
        spread = sqrt(discriminant)
        if spread * t < 1e-4:
            decay = exp(middle * t)
            cosh_part = decay * (1.0 + 0.5 * (spread * t) ** 2)
            sinh_part = decay * t * (1.0 + (spread * t) ** 2 / 6.0)
        else:
            larger_rate = middle - spread
            smaller_rate = (a * d - b * c) / larger_rate
            larger_decayed = exp(larger_rate * t)
            smaller_decayed = exp(smaller_rate * t)
            cosh_part = 0.5 * (smaller_decayed + larger_decayed)
            sinh_part = 0.5 * (smaller_decayed - larger_decayed) / spread
    half_difference = 0.5 * (a - d)
    return Vibration(
        cosh_part * first + sinh_part * (half_difference * first + b * second),
        cosh_part * second + sinh_part * (c * first - half_difference * second),
    )


@kernel
def expand_over(
    span: float, start: Floats, motion: CompliantMotion, relative: Floats, depth: Floats
) -> Vibration:
    """Write the coefficients of x and y over a span, and return the vibration at its start.

    Over a span longer than `motion.step`, the coefficients are those of the slow motion, and the vibration is
    subtracted from the coordinates in `start`. Over a shorter span, the coefficients include the vibration, and the
    returned vibration is 0.
    """
    vibration = Vibration(0.0, 0.0)
    units, rows = DIM, motion.rows
    if motion.fast > 0 and span > motion.step:
        vibration = vibration_at(start, motion)
        subtract_vibration(start, vibration, motion)
        units, rows = DIM - motion.fast, motion.slow_rows
    combine_rows(OF_RELATIVE, start, units, rows, relative)
    combine_rows(OF_Y, start, units, rows, depth)
    return vibration


@kernel
def contact_at(
    t: float, vibration: Vibration, motion: CompliantMotion, relative: Floats, depth: Floats
) -> tuple[float, float, float, float]:
    """Return x, x', y and y' at a time t after the start of a span, from the results of `expand_over`."""
    later = vibration
    if vibration.first != 0.0 or vibration.second != 0.0:
        later = vibration_after(vibration, motion.rates, t)
    return (
        value(relative, t) + value_of_form(later, form_of_x(motion)),
        slope(relative, t) + value_of_form(later, form_of_w(motion)),
        value(depth, t) + value_of_form(later, form_of(Y, motion)),
        slope(depth, t) + value_of_form(later, form_of(Y_RATE, motion)),
    )
