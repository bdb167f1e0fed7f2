"""The linear motion of mass and particle in contact through a compliant wall.

The coordinates are X = x − μy and y = u − p ∓ d, where x = v + σγ_F (σ the direction of slip). y has the sign of the
wall: wall · y is the penetration of the particle. Let μ = β/(1 + β) and κ = 1/(1 + β), and let g be the force on the
structure, 0 on a shaken base. The wall has the stiffness K over k and the damping C over k/ω_n, so the contact force is
F = Ky + Cy'. The contact force moves the common centre of mass only through the spring and dashpot of the structure,

    X'' = −s'' + κ(g − (2ζ(X' + μy') + X + μy)),    y'' = g − (2ζ(X' + μy') + X + μy) − F/μ,

so X is slow even if the wall is stiff. While friction holds the mass, X is v, and y'' = s'' − κF/μ. The excitation adds
two coordinates: sin φ and cos φ, or s'' and s''' of a record.

The motion has two expansions. The complete expansion is used over short spans, limited by the fastest rate of the
contact. The slow expansion describes the motion after the vibration of the contact has decayed. This slow motion lies
in an invariant subspace of the same equations, so the slow expansion is exact. If y and y' are both fast, the slow
expansion is used over complete panels, however stiff the wall is. In z' = Az, let q be the fast coordinates: y and
y', or only y' if the contact has only one fast rate. Let r be the other coordinates. Then

    q = Pr + f,   r = ξ + Bf,   ξ' = Gξ,   f' = Λf,
    A_qr + A_qq P = PG,   G = A_rr + A_rq P,   Λ = A_qq − P A_rq,   BΛ = GB + A_rq.

P solves a Riccati equation and B a linear equation. P and B are found by iteration. Each iteration multiplies
the error by about the ratio of slow to fast rates. The contact with a strongly damped wall has two very
different rates, both fast compared with the structure: y' soon follows from the other coordinates, while y
still decays. For such a wall, a third expansion treats y as a slow coordinate (`Contact.slipping_between`).
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from damperlab.worker.jit import inlined, kernel
from damperlab.worker.solver.addresses import Floats
from damperlab.worker.solver.motion.slow_subspace import (
    BASE_FIRST,
    BASE_SECOND,
    CENTRE,
    CENTRE_RATE,
    DIM,
    Y_RATE,
    Y,
)
from damperlab.worker.solver.motion.taylor import TERMS

OF_RELATIVE, OF_ABSOLUTE, OF_Y, OF_WALL_FORCE = range(4)
"""Indices of the rows of x, x + s, y and F."""


class CompliantForcing(NamedTuple):
    """Data of the excitation in contact, whose two coordinates are `Phase.first` and `Phase.second`.

    Attributes
    ----------
    two_zeta, window : float
        2ζ of the structure, and the length of a panel [1/ω_n].
    fastest : float
        The higher of the frequencies of structure and excitation [ω_n].
    first_rate, second_rate : float
        Factors c₁ and c₂ in first' = c₁ · second and second' = c₂ · first.
    inertia_force, force : float
        Ratios of −s'', and of the force on the structure, to the first coordinate.
    position, velocity : float
        Ratios of s to the first coordinate and of s' to the second coordinate; 0 under a force and under a record.
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
    """The motion in contact, either in slip or in stick.

    Attributes
    ----------
    share : float
        Factor in x = X + share · y: μ if the mass slips, 0 if the mass sticks.
    step, slow_step : float
        Longest span of the complete motion, and of the slow motion [1/ω_n].
    fast : int
        Number of separated fast coordinates: 0, 1 or 2.
    weight : float
        Weight Ω of f₁ in the size of the vibration (`vibration.size_of`): √det Λ with two fast coordinates, else 1.
    rows, slow_rows : array, shape (4 · DIM · TERMS,)
        Taylor coefficients of x, x + s, y and F for a unit initial value of each coordinate (`compliant_equations.fill_rows`).
    to_fast : array, shape (2 · DIM,)
        Matrix that maps the coordinates to f = q − Pr. A single fast coordinate takes the second row.
    from_fast : array, shape (DIM · 2,)
        Matrix that maps f to its contribution to the coordinates, (Bf, f + PBf).
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
    """Buffers of an integration in contact: arrays of shape (TERMS,) for coefficients of the current segment.

    Attributes
    ----------
    relative, absolute, wall_force : array
        Coefficients of x, x + s and F; in a long step, coefficients of the slow motion only.
    y : array
        Coefficients of y; after detachment, of wall · y (`separation.py`).
    excitation : array
        Coefficients of s or, if the base is at rest, of the force on the structure.
    rate, scratch : array
        Work arrays.
    start : array
        The first DIM entries are the coordinates at the start of a segment; `measure_long_step` overwrites them.
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
    """The motion in contact with a compliant wall.

    In a scene, a `Contact` replaces the `LinearMotion` of sustained contact.

    Attributes
    ----------
    slipping, held : CompliantMotion
        The motion in contact while the mass slips, and while friction holds the mass.
    slipping_between, held_between : CompliantMotion
        The motions `slipping` and `held` with only y' treated as fast. These two motions are used only if y
        and y' are both fast and have very different rates: `fast` is then 1, otherwise 0. Only `slow_rows`
        are used; `rows` contains zeros.
    buffers : Buffers
        Work arrays.
    """

    slipping: CompliantMotion
    held: CompliantMotion
    slipping_between: CompliantMotion
    held_between: CompliantMotion
    buffers: Buffers


@inlined
def write_coordinates(
    x: float, w: float, first: float, second: float, y: float, y_rate: float, share: float, start: Floats
) -> None:
    """Write the six coordinates of a state in contact into `start`; `share` is from `CompliantMotion`."""
    start[CENTRE] = x - share * y
    start[CENTRE_RATE] = w - share * y_rate
    start[BASE_FIRST] = first
    start[BASE_SECOND] = second
    start[Y] = y
    start[Y_RATE] = y_rate


@kernel
def combine_rows(which: int, coordinates: Floats, units: int, rows: Floats, out: Floats) -> None:
    """Write the coefficients of the quantity with index `which`, from its rows and the coordinates at the start."""
    at = which * DIM * TERMS
    for n in range(TERMS):
        out[n] = 0.0
    for unit in range(units):
        factor = coordinates[unit]
        for n in range(TERMS):
            out[n] += factor * rows[at + unit * TERMS + n]
