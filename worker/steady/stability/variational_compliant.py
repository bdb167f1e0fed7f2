"""The variational equations in contact with a compliant wall: the propagation of tangent vectors."""

import numpy as np
from numpy.typing import NDArray

from damperlab.worker.jit import inlined
from damperlab.worker.solver.motion.compliant_motion import Contact
from damperlab.worker.solver.motion.slow_subspace import (
    BASE_FIRST,
    BASE_SECOND,
    CENTRE,
    CENTRE_RATE,
    Y_RATE,
    Y,
)
from damperlab.worker.solver.motion.vibration import contact_at, expand_over

Array = NDArray[np.float64]


@inlined
def flow_in_contact(span: float, held: bool, contact: Contact, tangents: Array, n: int) -> None:
    """Propagate through a span in contact.

    A span longer than `motion.step` uses polynomials for the slow motion and an exponential for the vibration.

    Parameters
    ----------
    span : float
        Length of the span, at most the length of a contact segment.
    held : bool
        Whether friction holds the mass.
    contact : Contact
        The motion in contact.
    tangents : array, shape (4 · n,)
        n tangent vectors (δv, δw, δy, δy') in columns, changed in place.
    """
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
        vibration = expand_over(span, start, motion, relative, depth)
        x, w, y, y_rate = contact_at(span, vibration, motion, relative, depth)
        if held:
            tangents[n + j] = 0.0
        else:
            tangents[j] = x
            tangents[n + j] = w
        tangents[2 * n + j] = y
        tangents[3 * n + j] = y_rate
