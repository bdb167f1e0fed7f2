"""Taylor coefficients of the motion in contact with a compliant wall, for a unit initial value of each coordinate."""

import numpy as np
from numpy.typing import NDArray

from damperlab.worker.jit import kernel
from damperlab.worker.solver.addresses import Floats
from damperlab.worker.solver.array_loops import filled
from damperlab.worker.solver.motion.compliant_motion import CompliantForcing
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
from damperlab.worker.solver.particle import Wall

Array = NDArray[np.float64]

OF_RELATIVE, OF_ABSOLUTE, OF_Y, OF_WALL_FORCE = range(4)
"""Indices of the rows of x, x + s, y and F."""


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


@kernel
def combine_rows(which: int, coordinates: Floats, units: int, rows: Floats, out: Floats) -> None:
    """Write the coefficients of the quantity `which`, from its rows and the coordinates at the start."""
    at = which * DIM * TERMS
    for n in range(TERMS):
        out[n] = 0.0
    for unit in range(units):
        factor = coordinates[unit]
        for n in range(TERMS):
            out[n] += factor * rows[at + unit * TERMS + n]
