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

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from damperlab.worker.jit import inlined
from damperlab.worker.solver.memory import address


class ContactForcing(NamedTuple):
    """What the motion in contact has to know of the excitation, whose two coordinates are `Phase.first` and `second`.

    Attributes
    ----------
    two_zeta, window : float
        2ζ of the structure, and the length of a window [1/ω_n].
    fastest : float
        The faster of structure and excitation [ω_n].
    first_rate, second_rate : float
        Rate of the first coordinate over the second, and of the second over the first.
    inertia_force, force : float
        −s'' and the force on the structure over the first coordinate.
    position, velocity : float
        s over the first and s' over the second; 0 for a record, of which they are no coordinates, and under a force.
    """

    two_zeta: float
    window: float
    fastest: float
    first_rate: float
    second_rate: float
    inertia_force: float
    force: float
    position: float
    velocity: float


class ContactMotion(NamedTuple):
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
        Taylor coefficients of x, x + s, y and F for each unit start (`contact_rows`).
    fast_of : array, shape (2 · DIM,)
        f of the coordinates.
    of_fast : array, shape (DIM · 2,)
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
    fast_of: NDArray[np.float64]
    of_fast: NDArray[np.float64]
    rates: NDArray[np.float64]
    inverse: NDArray[np.float64]


class Buffers(NamedTuple):
    """Scratch of a march in contact, arrays of shape (TERMS,): polynomials of a segment, and its start."""

    relative: NDArray[np.float64]
    absolute: NDArray[np.float64]
    depth: NDArray[np.float64]
    wall_force: NDArray[np.float64]
    excitation: NDArray[np.float64]
    rate: NDArray[np.float64]
    scratch: NDArray[np.float64]
    start: NDArray[np.float64]


class Contact(NamedTuple):
    """What replaces the riding `Medium` where walls are compliant.

    Attributes
    ----------
    slipping, held : ContactMotion
        The motion in contact.
    slipping_between, held_between : ContactMotion
        The same with y' alone as fast, where that differs; `fast` is 0 where it does not.
    buffers : Buffers
        Scratch.
    """

    slipping: ContactMotion
    held: ContactMotion
    slipping_between: ContactMotion
    held_between: ContactMotion
    buffers: Buffers


@inlined
def contact_on_addresses(contact: Contact) -> Contact:
    """The same contact with addresses for arrays; the arrays must outlive it."""
    one = contact.buffers
    buffers = Buffers(
        address(one.relative, 0),
        address(one.absolute, 0),
        address(one.depth, 0),
        address(one.wall_force, 0),
        address(one.excitation, 0),
        address(one.rate, 0),
        address(one.scratch, 0),
        address(one.start, 0),
    )
    return Contact(
        _motion_on_addresses(contact.slipping),
        _motion_on_addresses(contact.held),
        _motion_on_addresses(contact.slipping_between),
        _motion_on_addresses(contact.held_between),
        buffers,
    )


@inlined
def _motion_on_addresses(motion: ContactMotion) -> ContactMotion:
    return ContactMotion(
        motion.share,
        motion.step,
        motion.slow_step,
        motion.fast,
        motion.weight,
        address(motion.rows, 0),
        address(motion.slow_rows, 0),
        address(motion.fast_of, 0),
        address(motion.of_fast, 0),
        address(motion.rates, 0),
        address(motion.inverse, 0),
    )
