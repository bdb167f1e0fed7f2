"""Time history of logged segments, sampled from their closed-form motion."""

from math import cos, sin

import numpy as np
from numpy.typing import NDArray

from damperlab.worker.solver.events import FAR_WALL, NEAR_WALL
from damperlab.worker.solver.excitation.excitation import expand_base, phase_of_sine
from damperlab.worker.solver.motion.taylor import TERMS, combine, slope, stick, value
from damperlab.worker.solver.motion.vibration import Vibration, contact_at, expand_over
from damperlab.worker.solver.scene import Scene
from damperlab.worker.solver.segment_log import Log, Logged, stored_rows

HISTORY_COLUMNS = ("time", "u", "u_rate", "v", "v_rate", "p", "p_rate", "impact")
"""Columns of a time history: time τ [1/ω_n], displacement [Z] and velocity [Z ω_n] of the mass (u absolute, v relative
to the base) and of the particle (p, absolute). The last column is 1 in the row just before an impact, otherwise 0.
"""

_SAMPLES_PER_WINDOW = 4


def sample_half(log: Log, scene: Scene, half: int) -> NDArray[np.float64]:
    """Sample the logged segments of one half cycle of a scene.

    Half cycles are counted from 0, and those with an odd index are mirrored back.

    Returns
    -------
    ndarray, shape (len(HISTORY_COLUMNS), samples)
        Equally spaced samples within each segment, including both ends, so that the jumps at impacts are preserved.
    """
    base, free, loaded, friction, particle, _, _ = scene
    relative, absolute, of_base, of_y = np.empty((4, TERMS))
    mirror = -1.0 if half % 2 else 1.0
    r = base.frequency_ratio
    begin = half * np.pi / r
    out: list[tuple[float, ...]] = []
    for row in stored_rows(log):
        logged = Logged(*row)
        start, duration = logged.start, logged.duration
        sine, cosine = sin(r * start), cos(r * start)
        expand_base(base, phase_of_sine(base, sine, cosine), of_base)
        held = friction is not None and logged.slip == 0.0
        offset = 0.0 if friction is None else logged.slip * friction
        riding = logged.riding > 0.0
        p_acceleration = 0.0
        if particle is not None and particle.friction is not None:
            p_acceleration = particle.friction * logged.slide
            if particle.gravity is not None:
                p_acceleration -= mirror * particle.gravity
            offset += 0.0 if held or riding else particle.mass_ratio * p_acceleration
        if held:
            absolute[:] = of_base
            stick(logged.v, relative, absolute)
        else:
            motion = free if particle is None or particle.wall is not None or not riding else loaded
            combine(logged.v + offset, logged.w, sine, cosine, motion.relative_rows, relative)
        in_contact = riding and particle is not None and particle.wall is not None
        if in_contact:
            contact = loaded.held if held else loaded.slipping
            y, y_rate = -logged.wall * logged.gap, logged.wall * logged.approach
            x, w = logged.v + offset, logged.w
            coordinates = [x - contact.share * y, w - contact.share * y_rate, sine, cosine, y, y_rate]
            vibration = Vibration(*expand_over(duration, np.array(coordinates), contact, relative, of_y))
        count = max(1, int(np.ceil(_SAMPLES_PER_WINDOW * duration / base.window)))
        for i in range(count + 1):
            t = duration * i / count
            v = value(relative, t) - offset
            w = slope(relative, t)
            depth, depth_rate = 0.0, 0.0
            if in_contact:
                x, w, y, y_rate = contact_at(t, vibration, contact, relative, of_y)
                v = x - offset
                depth, depth_rate = logged.wall * y, y_rate
            u = v + value(of_base, t)
            u_rate = w + slope(of_base, t)
            p, p_rate = np.nan, np.nan
            if particle is not None:
                wall = logged.wall
                if riding:
                    depth -= logged.gap if particle.friction is not None else 0.0
                    p, p_rate = u - wall * (particle.clearance_ratio + depth), u_rate - depth_rate
                else:
                    at_start = value(relative, 0.0) - offset + of_base[0]
                    p_rate = logged.p_rate + p_acceleration * t
                    p = (
                        at_start
                        - wall * (particle.clearance_ratio - logged.gap)
                        + 0.5 * (logged.p_rate + p_rate) * t
                    )
            struck = float(i == count and int(logged.event) in (NEAR_WALL, FAR_WALL))
            signed = (mirror * x for x in (u, u_rate, v, w, p, p_rate))
            out.append((begin + start + t, *signed, struck))
    return np.array(out).T
