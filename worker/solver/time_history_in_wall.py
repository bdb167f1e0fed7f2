"""The motion of a logged segment in a compliant wall, to be sampled for a time history."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from damperlab.worker.solver.motion.contact_motion import DEPTH, RELATIVE, Pressed, combine_rows
from damperlab.worker.solver.motion.slow_subspace import DIM, fast_later
from damperlab.worker.solver.motion.taylor import TERMS, slope, value
from damperlab.worker.solver.segment_log import APPROACH, DURATION, GAP, WALL, V, W


def motion_in_wall(
    row: NDArray[np.float64], sine: float, cosine: float, offset: float, motion: Pressed
) -> Callable[[float], tuple[float, float, float, float]]:
    """Motion of a segment in a compliant wall.

    Returns
    -------
    callable
        From the time since its start to x, x', y and y' as of `motion.contact_motion`.
    """
    y, y_rate = -row[WALL] * row[GAP], row[WALL] * row[APPROACH]
    start = np.array(
        [row[V] + offset - motion.share * y, row[W] - motion.share * y_rate, sine, cosine, y, y_rate]
    )
    units, rows = DIM, motion.rows
    vibration = np.zeros(2)
    writer = motion.writer.reshape(DIM, 2)
    if row[DURATION] > motion.step * (1.0 + 1e-12) and motion.fast > 0:
        units, rows = DIM - motion.fast, motion.slow_rows
        vibration = motion.reader.reshape(2, DIM) @ start
        start = start - writer @ vibration
    x, y_row = np.empty(TERMS), np.empty(TERMS)
    combine_rows(RELATIVE, start, units, rows, x)
    combine_rows(DEPTH, start, units, rows, y_row)

    def at(t: float) -> tuple[float, float, float, float]:
        f = writer @ np.array(fast_later(motion.rates, vibration[0], vibration[1], t))
        return (
            value(x, t) + f[0] + motion.share * f[4],
            slope(x, t) + f[1] + motion.share * f[5],
            value(y_row, t) + f[4],
            slope(y_row, t) + f[5],
        )

    return at
