"""The linear motion of mass and particle pressed against each other by a compliant wall.

Written in X = x − μy and y = u − p ∓ d, where x = v + σγ_F (σ the direction of slip) and y has the sign of the wall: wall · y
is the depth of the particle in it. With μ = β/(1 + β), κ = 1/(1 + β), K of the wall over k, C over k/ω_n, and g the force on
the structure (0 on a shaken base): the contact force F = Ky + Cy' moves the common centre of mass only by what it changes in
the spring and dashpot of the structure,

    X'' = −s'' + κ(g − (2ζ(X' + μy') + X + μy)),    y'' = g − (2ζ(X' + μy') + X + μy) − F/μ,

so a stiff wall leaves X slow. While friction holds the mass, X stands for v, and y'' = s'' − κF/μ. The excitation adds two
coordinates: sin φ and cos φ, or s'' and the s''' that a record keeps from sample to sample.

Two expansions of the motion: the whole of it, over spans that the fastest rate of the contact allows, and the slow motion,
what is left when the contact has come to rest. That is an invariant subspace of the same equations, so it is exact: a wall
that is fast in both y and y' is crossed in whole windows however stiff it is. Of z' = Az let q be the one or two fast
coordinates (y' where the wall is overdamped and yields slowly, else y and y') and r the others:

    q = Pr + f,   r = ξ + Bf,   ξ' = Gξ,   f' = Λf,
    A_qr + A_qq P = PG,   G = A_rr + A_rq P,   Λ = A_qq − P A_rq,   BΛ = GB + A_rq.

P (a Riccati equation) and B (a linear one) are iterated for, which converges as the ratio of the rates. A wall with much
damping has two rates far apart, both fast beside the structure: y still moves when y' has long come to follow it. There, a
third expansion takes y as slow (`Contact.slipping_between`).
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray


class CompliantForcing(NamedTuple):
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


class CompliantMotion(NamedTuple):
    """Motion in contact, of a mass that slips or is held.

    Attributes
    ----------
    share : float
        μ where the mass moves with the contact, 0 where it is held: x = X + share · y.
    step, slow_step : float
        Longest span of the whole motion, of the slow one [1/ω_n].
    fast : int
        Fast coordinates separated: 0, 1 or 2.
    weight : float
        Ω = √det Λ with two fast coordinates, else 1: weighs f₁ in the size of the vibration (`vibration.size_of`).
    rows, slow_rows : array, shape (4 · DIM · TERMS,)
        Taylor coefficients of x, x + s, y and F for each unit start (`compliant_rows`).
    to_fast : array, shape (2 · DIM,)
        f of the coordinates, q − Pr; one fast coordinate takes the second place.
    from_fast : array, shape (DIM · 2,)
        What f adds to the coordinates, (Bf, f + PBf).
    rates, inverse : array, shape (4,)
        Λ and its inverse.
    """

    share: float
    step: float
    slow_step: float
    fast: int
    weight: float
    rows: NDArray[np.float64]
    slow_rows: NDArray[np.float64]
    to_fast: NDArray[np.float64]
    from_fast: NDArray[np.float64]
    rates: NDArray[np.float64]
    inverse: NDArray[np.float64]


class Buffers(NamedTuple):
    """Scratch of a march in contact, arrays of shape (TERMS,): coefficients on the segment under way.

    Attributes
    ----------
    relative, absolute, wall_force : array
        Of x, x + s and F; in a long step of the slow motion alone.
    y : array
        Of y; of wall · y where the wall has let go (`separation.py`).
    excitation : array
        Of s, or of the force where one acts: the base is at rest then.
    rate, scratch : array
        Overwritten by whatever is called.
    start : array
        Its first DIM entries: the coordinates at the start; overwritten by `raise_over_long_step`.
    """

    relative: NDArray[np.float64]
    absolute: NDArray[np.float64]
    y: NDArray[np.float64]
    wall_force: NDArray[np.float64]
    excitation: NDArray[np.float64]
    rate: NDArray[np.float64]
    scratch: NDArray[np.float64]
    start: NDArray[np.float64]


class Contact(NamedTuple):
    """What replaces the riding `LinearMotion` where walls are compliant.

    Attributes
    ----------
    slipping, held : CompliantMotion
        The motion in contact.
    slipping_between, held_between : CompliantMotion
        The same with y' alone as fast: `fast` is 1 only where y and y' are both fast and their rates far apart, else 0 and
        nothing of it is used. `rows` is left at 0.
    buffers : Buffers
        Scratch.
    """

    slipping: CompliantMotion
    held: CompliantMotion
    slipping_between: CompliantMotion
    held_between: CompliantMotion
    buffers: Buffers
