"""The linear motion of mass and particle in contact through a compliant wall.

The coordinates are X = x − μy and y = u − p ∓ d, where x = v + σγ_F (σ the direction of slip). y has the sign of the
wall: wall · y is the penetration of the particle. Let μ = β/(1 + β) and κ = 1/(1 + β), and let g be the force on the
structure, 0 on a shaken base. With K of the wall over k, and C over k/ω_n, the contact force is F = Ky + Cy'. It moves
the common centre of mass only through the spring and dashpot of the structure,

    X'' = −s'' + κ(g − (2ζ(X' + μy') + X + μy)),    y'' = g − (2ζ(X' + μy') + X + μy) − F/μ,

so a stiff wall leaves X slow. While friction holds the mass, X stands for v, and y'' = s'' − κF/μ. The excitation
adds two coordinates: sin φ and cos φ, or s'' and the s''' that is constant between the samples of a record.

The motion has two expansions. The complete one is for spans that the fastest rate of the contact allows. The slow one
is what remains after the vibration of the contact has decayed. The slow motion is an invariant subspace of the same
equations, so it is exact. If a wall is fast in both y and y', complete panels are possible however stiff it is. In z' =
Az, let q be the fast coordinates: y' alone if the wall is overdamped and yields slowly, else y and y'. Let r be the
other coordinates. Then

    q = Pr + f,   r = ξ + Bf,   ξ' = Gξ,   f' = Λf,
    A_qr + A_qq P = PG,   G = A_rr + A_rq P,   Λ = A_qq − P A_rq,   BΛ = GB + A_rq.

P (a Riccati equation) and B (a linear one) are found by iteration, whose error falls in each step by about the ratio of
slow to fast rates. A wall with much damping has two very different rates, both fast compared with the structure. Then y
still moves when y' already follows it. For this case a third expansion takes y as slow (`Contact.slipping_between`).
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray


class CompliantForcing(NamedTuple):
    """Data on the excitation for the motion in contact. Its two coordinates are `Phase.first` and `Phase.second`.

    Attributes
    ----------
    two_zeta, window : float
        2ζ of the structure, and the length of a panel [1/ω_n].
    fastest : float
        The higher frequency of structure and excitation [ω_n].
    first_rate, second_rate : float
        Ratio of the rate of the first coordinate to the second coordinate, and the reverse.
    inertia_force, force : float
        Ratios of −s'', and of the force on the structure, to the first coordinate.
    position, velocity : float
        Ratios of s to the first coordinate and of s' to the second. Both are 0 under a force, and for a record, whose
        coordinates do not contain s and s'.
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
    """Motion in contact, of a mass that slips or sticks.

    Attributes
    ----------
    share : float
        μ if the mass moves with the contact, 0 if it sticks: x = X + share · y.
    step, slow_step : float
        Longest span of the complete motion, and of the slow motion [1/ω_n].
    fast : int
        Number of separated fast coordinates: 0, 1 or 2.
    weight : float
        Ω = √det Λ with two fast coordinates, else 1: weight of f₁ in the size of the vibration
        (`vibration.size_of`).
    rows, slow_rows : array, shape (4 · DIM · TERMS,)
        Taylor coefficients of x, x + s, y and F for each unit start (`compliant_rows`).
    to_fast : array, shape (2 · DIM,)
        Matrix that gives f = q − Pr from the coordinates. A single fast coordinate takes the second row.
    from_fast : array, shape (DIM · 2,)
        Matrix that gives the contribution of f to the coordinates, (Bf, f + PBf).
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
    """Buffers of an integration in contact, arrays of shape (TERMS,): coefficients on the present segment.

    Attributes
    ----------
    relative, absolute, wall_force : array
        Coefficients of x, x + s and F; in a long step, only those of the slow motion.
    y : array
        Coefficients of y; after detachment, of wall · y (`separation.py`).
    excitation : array
        Coefficients of s, or of the force, under which the base is at rest.
    rate, scratch : array
        Overwritten by every call.
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
    """The motion in contact with a compliant wall; it takes the place of the `LinearMotion` in sustained contact.

    Attributes
    ----------
    slipping, held : CompliantMotion
        The motion in contact.
    slipping_between, held_between : CompliantMotion
        The same with only y' treated as fast. `fast` is 1 only if y and y' are both fast and their rates very
        different; else it is 0, and the motion is not used. `rows` is left at 0.
    buffers : Buffers
        Scratch.
    """

    slipping: CompliantMotion
    held: CompliantMotion
    slipping_between: CompliantMotion
    held_between: CompliantMotion
    buffers: Buffers
