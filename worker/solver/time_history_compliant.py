"""The motion in a logged segment of contact with a compliant wall, for sampling a time history."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.portable import product
from damperlab.worker.solver.motion.compliant_motion import CompliantMotion
from damperlab.worker.solver.motion.compliant_rows import OF_RELATIVE, OF_Y, combine_rows
from damperlab.worker.solver.motion.slow_subspace import CENTRE, CENTRE_RATE, DIM, Y_RATE, Y
from damperlab.worker.solver.motion.taylor import TERMS, slope, value
from damperlab.worker.solver.motion.vibration import Vibration, vibration_after
from damperlab.worker.solver.segment_log import APPROACH, DURATION, GAP, WALL, V, W


def motion_in_contact(
    row: NDArray[np.float64], sine: float, cosine: float, offset: float, motion: CompliantMotion
) -> Callable[[float], tuple[float, float, float, float]]:
    """Return the motion in a segment of contact with a compliant wall.

    Returns
    -------
    callable
        Function that returns x, x', y and y' (`motion.compliant_motion`) at a time after the start of the segment.
    """
    y, y_rate = -row[WALL] * row[GAP], row[WALL] * row[APPROACH]
    start = np.array(
        [row[V] + offset - motion.share * y, row[W] - motion.share * y_rate, sine, cosine, y, y_rate]
    )
    units, rows = DIM, motion.rows
    f = np.zeros(2)
    from_fast = motion.from_fast.reshape(DIM, 2)
    if row[DURATION] > motion.step * (1.0 + 1e-12) and motion.fast > 0:
        units, rows = DIM - motion.fast, motion.slow_rows
        f = product(motion.to_fast.reshape(2, DIM), start)
        start = start - product(from_fast, f)
    x, y_row = np.empty(TERMS), np.empty(TERMS)
    combine_rows(OF_RELATIVE, start, units, rows, x)
    combine_rows(OF_Y, start, units, rows, y_row)

    vibration = Vibration(f[0], f[1])

    def at(t: float) -> tuple[float, float, float, float]:
        added = product(from_fast, vibration_after(vibration, motion.rates, t))
        return (
            value(x, t) + added[CENTRE] + motion.share * added[Y],
            slope(x, t) + added[CENTRE_RATE] + motion.share * added[Y_RATE],
            value(y_row, t) + added[Y],
            slope(y_row, t) + added[Y_RATE],
        )

    return at
