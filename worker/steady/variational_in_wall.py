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
from damperlab.worker.solver.particle import Wall

Array = NDArray[np.float64]


@inlined
def flow_in_wall(
    span: float, held: bool, arrays: Contact, wall: Wall | None, tangents: Array, n: int
) -> None:
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
    tangents : array, shape (4 · n,)
        n tangent vectors (δv, δw, δy, δy') in columns, changed in place.
    """
    if wall is None:
        return
    contact = contact_on_addresses(arrays)
    motion = contact.held if held else contact.slipping
    buffers = contact.buffers
    start, relative, depth = buffers.start, buffers.relative, buffers.depth
    writer, share = motion.writer, motion.share
    for j in range(n):
        start[0] = tangents[j] - share * tangents[2 * n + j]
        start[1] = 0.0 if held else tangents[n + j] - share * tangents[3 * n + j]
        start[2] = 0.0
        start[3] = 0.0
        start[4] = tangents[2 * n + j]
        start[5] = tangents[3 * n + j]
        fast_1 = 0.0
        fast_2 = 0.0
        if motion.fast > 0 and span > motion.step:
            fast_1_at_start = 0.0
            fast_2_at_start = 0.0
            for i in range(DIM):
                fast_1_at_start += motion.reader[i] * start[i]
                fast_2_at_start += motion.reader[DIM + i] * start[i]
            for i in range(DIM):
                start[i] -= writer[2 * i] * fast_1_at_start + writer[2 * i + 1] * fast_2_at_start
            fast_1, fast_2 = fast_later(motion.rates, fast_1_at_start, fast_2_at_start, span)
            combine_rows(RELATIVE, start, DIM - motion.fast, motion.slow_rows, relative)
            combine_rows(DEPTH, start, DIM - motion.fast, motion.slow_rows, depth)
        else:
            combine_rows(RELATIVE, start, DIM, motion.rows, relative)
            combine_rows(DEPTH, start, DIM, motion.rows, depth)
        if held:
            tangents[n + j] = 0.0
        else:
            of_x = (writer[0] + share * writer[8]) * fast_1 + (writer[1] + share * writer[9]) * fast_2
            of_w = (writer[2] + share * writer[10]) * fast_1 + (writer[3] + share * writer[11]) * fast_2
            tangents[j] = value(relative, span) + of_x
            tangents[n + j] = slope(relative, span) + of_w
        tangents[2 * n + j] = value(depth, span) + (writer[8] * fast_1 + writer[9] * fast_2)
        tangents[3 * n + j] = slope(depth, span) + (writer[10] * fast_1 + writer[11] * fast_2)
