"""The linear motion of mass and particle pressed against each other by a compliant wall.

Written in X = x − μy and y = u − p ∓ d, with μ = β/(1 + β), K and C those of the wall over k, κ = 1/(1 + β): the contact
force F = Ky + Cy' moves the common centre of mass only by what it changes in the spring and dashpot of the structure,

    X'' = −s'' − κ(2ζ(X' + μy') + X + μy),    y'' = −(2ζ(X' + μy') + X + μy) − F/μ,

so a stiff wall leaves X slow. While friction holds the mass, X stands for v, and y'' = s'' − κF/μ. The base stands for two
coordinates more: sin φ and cos φ, or s'' and the s''' that a record keeps from sample to sample.

Two sets of rows expand the motion: all of it, over spans that the fastest rate of the contact allows, and the part that is
left when the contact has come to rest. The latter is the slow invariant subspace of the same equations, so it is exact:
whole windows can be crossed in it however stiff the wall. With φ the one or two fast coordinates (y' where the wall is
overdamped and yields slowly, else y and y') and σ the others, P and B solve two Riccati equations,

    φ = Pσ + f,   σ = ξ + Bf,   ξ' = Gξ,   f' = Ff,

by iteration, which converges as the ratio of the rates. A wall with much damping has two rates far apart, both fast beside
the structure: between them, y is still moving when y' has long come to follow it, and a third set of rows takes y as slow.
"""

from math import sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from damperlab.worker.jit import inlined, kernel
from damperlab.worker.physics.compliant_wall import reduced_mass
from damperlab.worker.solver.arrays import filled, unit_matrix, zero_matrix
from damperlab.worker.solver.memory import Floats, address
from damperlab.worker.solver.motion.slow_subspace import DIM, contact_rates, split
from damperlab.worker.solver.motion.taylor import LARGEST_WINDOW, TERMS
from damperlab.worker.solver.particle import Particle, Wall

Array = NDArray[np.float64]

RELATIVE, ABSOLUTE, DEPTH, WALL_FORCE = range(4)
"""Sets of rows: x, x + s, y, F."""
# Longest span of the whole motion, in units of the contact's own rate: 0.5^16/16! is below 1e-18.
_LONGEST = 0.5
_APART = 10.0  # ratio of rates from which fast and slow are told apart


class Drive(NamedTuple):
    """What the motion in contact has to know of the base, whose two coordinates are its `Phase.first` and `second`.

    Attributes
    ----------
    two_zeta, window : float
        2ζ of the structure, and the length of a window [1/ω_n].
    fastest : float
        The faster of structure and excitation [ω_n].
    first_rate, second_rate : float
        Rate of the first coordinate over the second, and of the second over the first.
    push, force : float
        −s'' and the force on the structure over the first coordinate.
    place, rate : float
        s over the first and s' over the second; 0 for a record, whose place and rate are no coordinates, and under a force.
    """

    two_zeta: float
    window: float
    fastest: float
    first_rate: float
    second_rate: float
    push: float
    force: float
    place: float
    rate: float


class Pressed(NamedTuple):
    """Motion in contact, of a mass that slips or is held.

    Attributes
    ----------
    share : float
        μ where the mass moves with the contact, 0 where it is held: x = X + share · y.
    step, slow_step : float
        Longest span of the whole motion, of the slow one [1/ω_n].
    fast : int
        Fast coordinates told apart: 0, 1 or 2.
    weight : float
        Ω: |f₁| Ω and |f₂| stay below √(f₂² + Ω²f₁²) at the start.
    rows, slow_rows : array, shape (4 · DIM · TERMS,)
        Taylor coefficients of x, x + s, y and F for each unit start.
    reader : array, shape (2 · DIM,)
        f from the coordinates.
    writer : array, shape (DIM · 2,)
        The coordinates of f.
    rates, inverse : array, shape (4,)
        F and its inverse.
    """

    share: float
    step: float
    slow_step: float
    fast: int
    weight: float
    rows: NDArray[np.float64]
    slow_rows: NDArray[np.float64]
    reader: NDArray[np.float64]
    writer: NDArray[np.float64]
    rates: NDArray[np.float64]
    inverse: NDArray[np.float64]


class Buffers(NamedTuple):
    """Scratch of a march in contact, arrays of shape (TERMS,): polynomials of a segment, and its start."""

    relative: NDArray[np.float64]
    absolute: NDArray[np.float64]
    depth: NDArray[np.float64]
    push: NDArray[np.float64]
    shaken: NDArray[np.float64]
    rate: NDArray[np.float64]
    scratch: NDArray[np.float64]
    start: NDArray[np.float64]


class Contact(NamedTuple):
    """What replaces the riding `Medium` where walls are compliant.

    Attributes
    ----------
    slipping, held : Pressed
        The motion in contact.
    slipping_between, held_between : Pressed
        The same with y' alone as fast, where that differs; `fast` is 0 where it does not.
    buffers : Buffers
        Scratch.
    """

    slipping: Pressed
    held: Pressed
    slipping_between: Pressed
    held_between: Pressed
    buffers: Buffers


@kernel
def make_contact(drive: Drive, particle: Particle, wall: Wall) -> Contact:
    """Motion in contact with a compliant wall."""
    return Contact(
        _make_pressed(drive, particle.mass_ratio, wall, False, False),
        _make_pressed(drive, particle.mass_ratio, wall, True, False),
        _make_pressed(drive, particle.mass_ratio, wall, False, True),
        _make_pressed(drive, particle.mass_ratio, wall, True, True),
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


@inlined
def contact_on_addresses(contact: Contact) -> Contact:
    """The same contact with addresses for arrays; the arrays must outlive it."""
    one = contact.buffers
    buffers = Buffers(
        address(one.relative, 0),
        address(one.absolute, 0),
        address(one.depth, 0),
        address(one.push, 0),
        address(one.shaken, 0),
        address(one.rate, 0),
        address(one.scratch, 0),
        address(one.start, 0),
    )
    return Contact(
        _point(contact.slipping),
        _point(contact.held),
        _point(contact.slipping_between),
        _point(contact.held_between),
        buffers,
    )


@inlined
def _point(pressed: Pressed) -> Pressed:
    return Pressed(
        pressed.share,
        pressed.step,
        pressed.slow_step,
        pressed.fast,
        pressed.weight,
        address(pressed.rows, 0),
        address(pressed.slow_rows, 0),
        address(pressed.reader, 0),
        address(pressed.writer, 0),
        address(pressed.rates, 0),
        address(pressed.inverse, 0),
    )


@kernel
def _equations(drive: Drive, mass_ratio: float, wall: Wall, held: bool) -> Array:
    """The matrix of the coordinates' rates."""
    mu = reduced_mass(mass_ratio)
    kappa = 1.0 / (1.0 + mass_ratio)
    a = zero_matrix(DIM, DIM)
    a[2, 3] = drive.first_rate
    a[3, 2] = drive.second_rate
    a[4, 5] = 1.0
    if held:
        a[5, 2] = -drive.push
        a[5, 4] = -kappa * wall.stiffness / mu
        a[5, 5] = -kappa * wall.damping / mu
        return a
    a[0, 1] = 1.0
    a[1, 0] = -kappa
    a[1, 1] = -kappa * drive.two_zeta
    a[1, 2] = drive.push + kappa * drive.force
    a[1, 4] = -kappa * mu
    a[1, 5] = -kappa * mu * drive.two_zeta
    a[5, 0] = -1.0
    a[5, 2] = drive.force
    a[5, 1] = -drive.two_zeta
    a[5, 4] = -(wall.stiffness / mu + mu)
    a[5, 5] = -(wall.damping / mu + drive.two_zeta * mu)
    return a


@kernel
def _make_pressed(drive: Drive, mass_ratio: float, wall: Wall, held: bool, between: bool) -> Pressed:
    a = _equations(drive, mass_ratio, wall, held)
    share = 0.0 if held else reduced_mass(mass_ratio)
    fastest, slowest = contact_rates(-a[5, 4], -a[5, 5])
    others = (1.0 + 0.5 * drive.two_zeta) * drive.fastest
    fast = 0
    if slowest >= _APART * others:
        fast = 2
    elif fastest >= _APART * max(others, slowest):
        fast = 1
    if between:
        fast = 1 if fast == 2 and fastest >= _APART * slowest else 0
    step = min(drive.window, _LONGEST / fastest)
    slow_step = step if fast == 0 else drive.window
    rows = filled(4 * DIM * TERMS, 0.0)
    slow_rows = filled(4 * DIM * TERMS, 0.0)
    if not between:
        _fill_rows(rows, a, unit_matrix(DIM), DIM, drive, wall, share, held)
    reader = zero_matrix(2, DIM)
    writer = zero_matrix(DIM, 2)
    rates = zero_matrix(2, 2)
    inverse = zero_matrix(2, 2)
    weight = 1.0
    if fast > 0:
        slow, back, fast_rates, fast_inverse, converged = split(a, fast)
        if not converged:  # the whole motion over short spans, which needs nothing told apart
            fast = 0
            slow_step = step
    if fast > 0:
        rates = fast_rates
        inverse = fast_inverse
        n = DIM - fast
        column = 2 - fast
        for i in range(fast):
            reader[column + i, n + i] = 1.0
            for j in range(n):
                reader[column + i, j] = -slow[i, j]
                writer[j, column + i] = back[j, i]
            for k in range(fast):
                total = 1.0 if i == k else 0.0
                for j in range(n):
                    total += slow[i, j] * back[j, k]
                writer[n + i, column + k] = total
        generator = zero_matrix(DIM, DIM)
        lift = zero_matrix(DIM, DIM)
        for i in range(n):
            lift[i, i] = 1.0
            for j in range(n):
                generator[i, j] = a[i, j]
                for k in range(fast):
                    generator[i, j] += a[i, n + k] * slow[k, j]
        for i in range(fast):
            for j in range(n):
                lift[n + i, j] = slow[i, j]
        _fill_rows(slow_rows, generator, lift, n, drive, wall, share, held)
        if fast == 2:
            weight = sqrt(rates[0, 0] * rates[1, 1] - rates[0, 1] * rates[1, 0])
        else:
            slow_step = min(drive.window, LARGEST_WINDOW / max(1.0, 1.5 * slowest))
    return Pressed(
        share,
        step,
        slow_step,
        fast,
        weight,
        rows,
        slow_rows,
        reader.reshape(-1),
        writer.reshape(-1),
        rates.reshape(-1),
        inverse.reshape(-1),
    )


@kernel
def _fill_rows(
    rows: Array, generator: Array, lift: Array, units: int, drive: Drive, wall: Wall, share: float, held: bool
) -> None:
    """Taylor coefficients for each unit start; `lift` gives the six coordinates of those that `generator` moves.

    Those of x + s lack the place and the rate at which a record has the base, like its rows.
    """
    here = filled(DIM, 0.0)
    following = filled(DIM, 0.0)
    full = filled(DIM, 0.0)
    for unit in range(units):
        at = unit * TERMS
        here[:] = 0.0
        here[unit] = 1.0
        for n in range(TERMS):
            for i in range(DIM):
                full[i] = 0.0
                for j in range(units):
                    full[i] += lift[i, j] * here[j]
            x = full[0] + share * full[4]
            w = full[1] + share * full[5]
            push = wall.stiffness * full[4] + wall.damping * full[5]
            rows[DEPTH * DIM * TERMS + at + n] = full[4]
            rows[WALL_FORCE * DIM * TERMS + at + n] = push
            absolute = ABSOLUTE * DIM * TERMS + at
            if held:
                if n == 0:
                    rows[at] = x
                    rows[absolute] = x
                rows[absolute + n] += drive.place * full[2]
                if drive.place == 0.0 and n + 2 < TERMS:
                    rows[absolute + n + 2] = -drive.push * full[2] / ((n + 1) * (n + 2))
            else:
                rows[at + n] = x
                if n == 0:
                    rows[absolute] = x + drive.place * full[2]
                    rows[absolute + 1] = w + drive.rate * full[3]
                if n + 2 < TERMS:
                    acceleration = (drive.force * full[2] - (drive.two_zeta * w + x)) - push
                    rows[absolute + n + 2] = acceleration / ((n + 1) * (n + 2))
            for i in range(units):
                following[i] = 0.0
                for j in range(units):
                    following[i] += generator[i, j] * here[j]
            for i in range(units):
                here[i] = following[i] / (n + 1)


@kernel
def combine_rows(which: int, coordinates: Floats, units: int, rows: Floats, out: Floats) -> None:
    """Coefficients of one set of rows from the coordinates at the start."""
    at = which * DIM * TERMS
    for n in range(TERMS):
        out[n] = 0.0
    for unit in range(units):
        factor = coordinates[unit]
        for n in range(TERMS):
            out[n] += factor * rows[at + unit * TERMS + n]
