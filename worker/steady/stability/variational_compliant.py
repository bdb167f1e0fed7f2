"""The variational equations in contact with a compliant wall: the propagation of tangent vectors."""

import numpy as np
from numpy.typing import NDArray

from damperlab.worker.jit import inlined
from damperlab.worker.solver.addresses import on_addresses
from damperlab.worker.solver.motion.compliant_motion import Contact
from damperlab.worker.solver.motion.compliant_rows import OF_RELATIVE, OF_Y, combine_rows
from damperlab.worker.solver.motion.slow_subspace import (
    BASE_FIRST,
    BASE_SECOND,
    CENTRE,
    CENTRE_RATE,
    DIM,
    Y_RATE,
    Y,
)
from damperlab.worker.solver.motion.taylor import slope, value
from damperlab.worker.solver.motion.vibration import (
    Vibration,
    form_of,
    form_of_w,
    form_of_x,
    subtract_vibration,
    value_of_form,
    vibration_after,
    vibration_at,
)
from damperlab.worker.solver.particle import Wall

Array = NDArray[np.float64]


@inlined
def flow_in_contact(
    span: float, held: bool, arrays: Contact, wall: Wall | None, tangents: Array, n: int
) -> None:
    """Propagate through a span in contact.

    A span longer than `motion.step` uses polynomials for the slow motion and an exponential for the vibration.

    Parameters
    ----------
    span : float
        Length of the span, at most that of a contact segment.
    held : bool
        Whether friction holds the mass.
    arrays : Contact
        The motion in contact.
    wall : Wall or None
        None for rigid walls, for which nothing is done.
    tangents : array, shape (4 · n,)
        n tangent vectors (δv, δw, δy, δy') in columns, changed in place.
    """
    if wall is None:
        return
    contact = on_addresses(arrays)
    motion = contact.held if held else contact.slipping
    buffers = contact.buffers
    start, relative, depth = buffers.start, buffers.relative, buffers.y
    share = motion.share
    for j in range(n):
        start[CENTRE] = tangents[j] - share * tangents[2 * n + j]
        start[CENTRE_RATE] = 0.0 if held else tangents[n + j] - share * tangents[3 * n + j]
        start[BASE_FIRST] = 0.0
        start[BASE_SECOND] = 0.0
        start[Y] = tangents[2 * n + j]
        start[Y_RATE] = tangents[3 * n + j]
        vibration = Vibration(0.0, 0.0)
        if motion.fast > 0 and span > motion.step:
            before = vibration_at(start, motion)
            subtract_vibration(start, before, motion)
            vibration = vibration_after(before, motion.rates, span)
            combine_rows(OF_RELATIVE, start, DIM - motion.fast, motion.slow_rows, relative)
            combine_rows(OF_Y, start, DIM - motion.fast, motion.slow_rows, depth)
        else:
            combine_rows(OF_RELATIVE, start, DIM, motion.rows, relative)
            combine_rows(OF_Y, start, DIM, motion.rows, depth)
        if held:
            tangents[n + j] = 0.0
        else:
            tangents[j] = value(relative, span) + value_of_form(vibration, form_of_x(motion))
            tangents[n + j] = slope(relative, span) + value_of_form(vibration, form_of_w(motion))
        tangents[2 * n + j] = value(depth, span) + value_of_form(vibration, form_of(Y, motion))
        tangents[3 * n + j] = slope(depth, span) + value_of_form(vibration, form_of(Y_RATE, motion))
