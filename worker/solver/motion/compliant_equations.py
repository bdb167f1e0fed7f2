"""Equations of motion in contact with a compliant wall, and the `Contact` made from them."""

from math import sqrt

import numpy as np
from numpy.typing import NDArray

from damperlab.worker.jit import kernel
from damperlab.worker.physics.compliant_wall import reduced_mass
from damperlab.worker.solver.array_loops import add_product, copy_matrix, filled, unit_matrix, zero_matrix
from damperlab.worker.solver.motion.compliant_motion import (
    OF_ABSOLUTE,
    OF_WALL_FORCE,
    OF_Y,
    Buffers,
    CompliantForcing,
    CompliantMotion,
    Contact,
)
from damperlab.worker.solver.motion.slow_subspace import (
    BASE_FIRST,
    BASE_SECOND,
    CENTRE,
    CENTRE_RATE,
    DIM,
    Y_RATE,
    Y,
    contact_rates,
    split,
)
from damperlab.worker.solver.motion.taylor import LARGEST_WINDOW, TERMS
from damperlab.worker.solver.particle import Particle, Wall

Array = NDArray[np.float64]

# Longest span of the complete motion, times the fastest rate of the contact.
# The first omitted Taylor term is then 0.5^16/16!, below 1e-18.
_LONGEST = 0.5
_APART = 10.0  # ratio of rates above which fast and slow motion are separated


@kernel
def make_contact(forcing: CompliantForcing, particle: Particle, wall: Wall) -> Contact:
    """Make the motion in contact with a compliant wall."""
    return Contact(
        _contact_motion(forcing, particle.mass_ratio, wall, False, False),
        _contact_motion(forcing, particle.mass_ratio, wall, True, False),
        _contact_motion(forcing, particle.mass_ratio, wall, False, True),
        _contact_motion(forcing, particle.mass_ratio, wall, True, True),
        Buffers(
            filled(TERMS, 0.0),
            filled(TERMS, 0.0),
            filled(TERMS, 0.0),
            filled(TERMS, 0.0),
            filled(TERMS, 0.0),
            filled(TERMS, 0.0),
            filled(TERMS, 0.0),
            filled(TERMS, 0.0),
        ),
    )


@kernel
def compliant_equations(forcing: CompliantForcing, mass_ratio: float, wall: Wall, held: bool) -> Array:
    """Matrix A of z' = Az, shape (DIM, DIM), with the coordinates z in the order of `slow_subspace`."""
    mu = reduced_mass(mass_ratio)
    kappa = 1.0 / (1.0 + mass_ratio)
    a = zero_matrix(DIM, DIM)
    a[BASE_FIRST, BASE_SECOND] = forcing.first_rate
    a[BASE_SECOND, BASE_FIRST] = forcing.second_rate
    a[Y, Y_RATE] = 1.0
    if held:
        a[Y_RATE, BASE_FIRST] = -forcing.inertia_force
        a[Y_RATE, Y] = -kappa * wall.stiffness / mu
        a[Y_RATE, Y_RATE] = -kappa * wall.damping / mu
        return a
    a[CENTRE, CENTRE_RATE] = 1.0
    a[CENTRE_RATE, CENTRE] = -kappa
    a[CENTRE_RATE, CENTRE_RATE] = -kappa * forcing.two_zeta
    a[CENTRE_RATE, BASE_FIRST] = forcing.inertia_force + kappa * forcing.force
    a[CENTRE_RATE, Y] = -kappa * mu
    a[CENTRE_RATE, Y_RATE] = -kappa * mu * forcing.two_zeta
    a[Y_RATE, CENTRE] = -1.0
    a[Y_RATE, CENTRE_RATE] = -forcing.two_zeta
    a[Y_RATE, BASE_FIRST] = forcing.force
    a[Y_RATE, Y] = -(wall.stiffness / mu + mu)
    a[Y_RATE, Y_RATE] = -(wall.damping / mu + forcing.two_zeta * mu)
    return a


@kernel
def _contact_motion(
    forcing: CompliantForcing, mass_ratio: float, wall: Wall, held: bool, between: bool
) -> CompliantMotion:
    a = compliant_equations(forcing, mass_ratio, wall, held)
    share = 0.0 if held else reduced_mass(mass_ratio)
    contact_fast, contact_slow = contact_rates(-a[Y_RATE, Y], -a[Y_RATE, Y_RATE])
    fast = _fast_coordinates(
        contact_fast, contact_slow, (1.0 + 0.5 * forcing.two_zeta) * forcing.fastest, between
    )
    step = min(forcing.window, _LONGEST / contact_fast)
    slow_step = step if fast == 0 else forcing.window
    rows = filled(4 * DIM * TERMS, 0.0)
    slow_rows = filled(4 * DIM * TERMS, 0.0)
    if not between:
        fill_rows(rows, a, unit_matrix(DIM), DIM, forcing, wall, share, held)
    to_fast = zero_matrix(2, DIM)
    from_fast = zero_matrix(DIM, 2)
    rates = zero_matrix(2, 2)
    inverse = zero_matrix(2, 2)
    weight = 1.0
    if fast > 0:
        p, b, fast_rates, fast_inverse, converged = split(a, fast)
        if not converged:  # use the complete motion over short spans, not split into fast and slow
            fast = 0
            slow_step = step
    if fast > 0:
        rates = fast_rates
        inverse = fast_inverse
        _fill_vibration(to_fast, from_fast, p, b, fast)
        generator, lift = _slow_motion(a, p, fast)
        fill_rows(slow_rows, generator, lift, DIM - fast, forcing, wall, share, held)
        if fast == 2:
            weight = sqrt(rates[0, 0] * rates[1, 1] - rates[0, 1] * rates[1, 0])
        else:
            # y is part of the slow motion, with the lower rate of the contact; the factor 1.5 is a margin
            slow_step = min(forcing.window, LARGEST_WINDOW / max(1.0, 1.5 * contact_slow))
    return CompliantMotion(
        share,
        step,
        slow_step,
        fast,
        weight,
        rows,
        slow_rows,
        to_fast.reshape(-1),
        from_fast.reshape(-1),
        rates.reshape(-1),
        inverse.reshape(-1),
    )


@kernel
def _fast_coordinates(contact_fast: float, contact_slow: float, others: float, between: bool) -> int:
    """Number of fast coordinates, from the two rates of the contact and the fastest rate of the other coordinates.

    If `between` is True, return 1 when y and y' are both fast and y' is much faster than y, and 0 otherwise.
    """
    fast = 0
    if contact_slow >= _APART * others:
        fast = 2
    elif contact_fast >= _APART * max(others, contact_slow):
        fast = 1
    if between:
        fast = 1 if fast == 2 and contact_fast >= _APART * contact_slow else 0
    return fast


@kernel
def _fill_vibration(to_fast: Array, from_fast: Array, p: Array, b: Array, fast: int) -> None:
    """Fill `to_fast`, which maps the coordinates to f = q − Pr, and `from_fast`, which maps f to (Bf, f + PBf).

    The symbols are defined in `compliant_motion`. A single fast coordinate takes the second of the two places.
    """
    n = DIM - fast
    place = 2 - fast
    for i in range(fast):
        to_fast[place + i, n + i] = 1.0
        from_fast[n + i, place + i] = 1.0
        for j in range(n):
            to_fast[place + i, j] = -p[i, j]
            from_fast[j, place + i] = b[j, i]
    add_product(1.0, p, b, from_fast[n:, place:])


@kernel
def _slow_motion(a: Array, p: Array, fast: int) -> tuple[Array, Array]:
    """Matrix G of the slow motion, and the matrix that gives the coordinates (ξ, Pξ) from ξ."""
    n = DIM - fast
    generator = zero_matrix(DIM, DIM)
    lift = zero_matrix(DIM, DIM)
    copy_matrix(a[:n, :n], generator)
    add_product(1.0, a[:n, n:], p, generator)
    copy_matrix(p, lift[n:])
    for i in range(n):
        lift[i, i] = 1.0
    return generator, lift


@kernel
def fill_rows(
    rows: Array,
    generator: Array,
    lift: Array,
    units: int,
    forcing: CompliantForcing,
    wall: Wall,
    share: float,
    held: bool,
) -> None:
    """Fill the rows of Taylor coefficients of x, x + s, y and F.

    Under a record, the rows of x + s contain neither the position nor the velocity of the base.

    Parameters
    ----------
    rows : array, shape (4 · DIM · TERMS,)
        Taylor coefficients of x, x + s, y and F, with one row per quantity and coordinate.
    generator : array, shape (DIM, DIM)
        Matrix that maps the first `units` coordinates to their rates.
    lift : array, shape (DIM, DIM)
        Matrix that maps the first `units` coordinates to all six coordinates.
    share : float
        Factor of y in x = X + share · y.
    held : bool
        Whether friction holds the mass, so that x is constant.
    """
    here = filled(DIM, 0.0)
    following = filled(DIM, 0.0)
    c = filled(DIM, 0.0)
    for unit in range(units):
        at = unit * TERMS
        here[:] = 0.0
        here[unit] = 1.0
        for n in range(TERMS):
            for i in range(DIM):
                c[i] = 0.0
                for j in range(units):
                    c[i] += lift[i, j] * here[j]
            x = c[CENTRE] + share * c[Y]
            w = c[CENTRE_RATE] + share * c[Y_RATE]
            wall_force = wall.stiffness * c[Y] + wall.damping * c[Y_RATE]
            rows[OF_Y * DIM * TERMS + at + n] = c[Y]
            rows[OF_WALL_FORCE * DIM * TERMS + at + n] = wall_force
            absolute = OF_ABSOLUTE * DIM * TERMS + at
            if held:
                if n == 0:
                    rows[at] = x
                    rows[absolute] = x
                rows[absolute + n] += forcing.position * c[BASE_FIRST]
                if forcing.position == 0.0 and n + 2 < TERMS:
                    rows[absolute + n + 2] = -forcing.inertia_force * c[BASE_FIRST] / ((n + 1) * (n + 2))
            else:
                rows[at + n] = x
                if n == 0:
                    rows[absolute] = x + forcing.position * c[BASE_FIRST]
                    rows[absolute + 1] = w + forcing.velocity * c[BASE_SECOND]
                if n + 2 < TERMS:
                    u_acceleration = (forcing.force * c[BASE_FIRST] - (forcing.two_zeta * w + x)) - wall_force
                    rows[absolute + n + 2] = u_acceleration / ((n + 1) * (n + 2))
            for i in range(units):
                following[i] = 0.0
                for j in range(units):
                    following[i] += generator[i, j] * here[j]
            for i in range(units):
                here[i] = following[i] / (n + 1)
