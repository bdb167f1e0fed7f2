"""The variational equations in contact with a compliant wall: how the motion there takes small changes of its start on."""

import numpy as np
from numpy.typing import NDArray

from damperlab.worker.jit import inlined
from damperlab.worker.solver.motion.contact_motion import (
    DEPTH,
    RELATIVE,
    Contact,
    combine_rows,
    contact_on_addresses,
)
from damperlab.worker.solver.motion.slow_subspace import DIM, fast_later
from damperlab.worker.solver.motion.taylor import slope, value
from damperlab.worker.solver.state import Wall

Array = NDArray[np.float64]


@inlined
def flow_in_wall(span: float, held: bool, arrays: Contact, wall: Wall | None, z: Array, n: int) -> None:
    """A span in contact; over a long one the fast part goes by its exponential, as in `contact_segment`.

    Parameters
    ----------
    span : float
        No longer than a contact segment.
    held : bool
        Whether friction holds the mass.
    arrays : Contact
        The motion in contact.
    wall : Wall or None
        None where walls are rigid: nothing is done.
    z : array, shape (4 · n,)
        n tangent vectors (δv, δw, δy, δy') in columns, changed in place.
    """
    if wall is None:
        return
    contact = contact_on_addresses(arrays)
    motion = contact.held if held else contact.slipping
    buffers = contact.buffers
    start, relative, depth = buffers.start, buffers.relative, buffers.depth
    u = motion.writer
    s = motion.share
    for j in range(n):
        start[0] = z[j] - s * z[2 * n + j]
        start[1] = 0.0 if held else z[n + j] - s * z[3 * n + j]
        start[2] = 0.0
        start[3] = 0.0
        start[4] = z[2 * n + j]
        start[5] = z[3 * n + j]
        one = 0.0
        two = 0.0
        if motion.fast > 0 and span > motion.step:
            first = 0.0
            second = 0.0
            for i in range(DIM):
                first += motion.reader[i] * start[i]
                second += motion.reader[DIM + i] * start[i]
            for i in range(DIM):
                start[i] -= u[2 * i] * first + u[2 * i + 1] * second
            one, two = fast_later(motion.rates, first, second, span)
            combine_rows(RELATIVE, start, DIM - motion.fast, motion.slow_rows, relative)
            combine_rows(DEPTH, start, DIM - motion.fast, motion.slow_rows, depth)
        else:
            combine_rows(RELATIVE, start, DIM, motion.rows, relative)
            combine_rows(DEPTH, start, DIM, motion.rows, depth)
        if held:
            z[n + j] = 0.0
        else:
            z[j] = value(relative, span) + ((u[0] + s * u[8]) * one + (u[1] + s * u[9]) * two)
            z[n + j] = slope(relative, span) + ((u[2] + s * u[10]) * one + (u[3] + s * u[11]) * two)
        z[2 * n + j] = value(depth, span) + (u[8] * one + u[9] * two)
        z[3 * n + j] = slope(depth, span) + (u[10] * one + u[11] * two)
