"""Time history of recorded segments, sampled from their closed form."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from worker.solver.record import DURATION, EVENT, GAP, P_RATE, RIDING, SLIP, START, WALL, Log, V, W
from worker.solver.scene import FAR_WALL, NEAR_WALL, Particle
from worker.solver.taylor import combine, expand_base, expand_stick, slope, value

HISTORY_COLUMNS = ("time", "u", "u_rate", "v", "v_rate", "p", "p_rate", "impact")
"""τ [1/ω_n], absolute and relative displacement [Z] and velocity [Z ω_n], particle, and 1 where an impact ends."""

_SAMPLES_PER_WINDOW = 4


def sample_half(
    log: Log,
    base: Any,
    free: Any,
    loaded: Any,
    friction: float | None,
    particle: Particle | None,
    half: int,
    work: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Sample the segments of one half cycle.

    Parameters
    ----------
    log : Log
        The segments of the half cycle, in its mirrored frame.
    base, free, loaded, friction, particle
        As in `march.half_cycle`.
    half : int
        Number of the half cycle from the start: odd ones are mirrored back.
    work : ndarray, shape (4, TERMS)
        Scratch.

    Returns
    -------
    ndarray, shape (len(HISTORY_COLUMNS), samples)
        Uniform samples within each segment and both its ends, so that the jumps at impacts are kept.
    """
    relative, absolute, shaken = work[0], work[1], work[3]
    mirror = -1.0 if half % 2 else 1.0
    r = base.frequency_ratio
    begin = half * np.pi / r
    out: list[tuple[float, ...]] = []
    for row in log.rows[: min(log.cursor[0], log.rows.shape[0])]:
        start, duration = row[START], row[DURATION]
        sine, cosine = np.sin(r * start), np.cos(r * start)
        expand_base(sine, cosine, base.rows, shaken)
        held = friction is not None and row[SLIP] == 0.0
        offset = 0.0 if friction is None else row[SLIP] * friction
        riding = row[RIDING] > 0.0
        if held:
            expand_stick(row[V], sine, cosine, base.rows, relative, absolute)
        else:
            medium = loaded if riding else free
            combine(row[V] + offset, row[W], sine, cosine, medium.relative, relative)
        count = max(1, int(np.ceil(_SAMPLES_PER_WINDOW * duration / base.window)))
        for i in range(count + 1):
            t = duration * i / count
            v = value(relative, t) - offset
            w = slope(relative, t)
            u = v + value(shaken, t)
            u_rate = w + slope(shaken, t)
            p, p_rate = np.nan, np.nan
            if particle is not None:
                wall = row[WALL]
                if riding:
                    p, p_rate = u - wall * particle.clearance_ratio, u_rate
                else:
                    at_start = value(relative, 0.0) - offset + shaken[0]
                    p_rate = row[P_RATE]
                    p = at_start - wall * (particle.clearance_ratio - row[GAP]) + p_rate * t
            struck = float(i == count and int(row[EVENT]) in (NEAR_WALL, FAR_WALL))
            signed = (mirror * x for x in (u, u_rate, v, w, p, p_rate))
            out.append((begin + start + t, *signed, struck))
    return np.array(out).T
