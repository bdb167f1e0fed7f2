"""A ground-motion record divided into panels, with velocity and displacement of the base."""

from math import ceil
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from damperlab.worker.physics.friction import breakaway, hold_force, slip_direction
from damperlab.worker.solver.array_loops import filled
from damperlab.worker.solver.dwell import dwell_at_rest
from damperlab.worker.solver.motion.taylor import LARGEST_WINDOW, TERMS
from damperlab.worker.solver.particle import Particle
from damperlab.worker.solver.sliding import moving_slide, slide_at_rest
from damperlab.worker.solver.state import State


class RecordBase(NamedTuple):
    """A base whose acceleration is linear in every panel.

    Attributes
    ----------
    two_zeta, window : float
        2ζ and the length of a panel [1/ω_n].
    windows : int
        Number of panels of the complete record.
    acceleration, jerk : array, shape (windows,)
        s'' at the start of each panel, and the constant s''' in the panel.
    rate, position : array, shape (windows + 1,)
        s' and s at the panel ends.
    most : array, shape (windows,)
        Largest |s''| of each panel.
    largest : float
        Largest |s''| of the record.
    rows : array, shape (2 · TERMS,)
        Taylor coefficients of s for s'' = 1 and for s''' = 1, without the terms of order 0 and 1.
    """

    two_zeta: float
    window: float
    windows: int
    acceleration: NDArray[np.float64]
    jerk: NDArray[np.float64]
    rate: NDArray[np.float64]
    position: NDArray[np.float64]
    most: NDArray[np.float64]
    largest: float
    rows: NDArray[np.float64]


def make_record_base(
    acceleration: NDArray[np.float64],
    step: float,
    damping_ratio: float,
    tail: float = 0.0,
) -> RecordBase:
    """Divide a record into panels: one per time step, or several if the step is too long for the Taylor polynomials.

    Parameters
    ----------
    acceleration : ndarray, shape (samples,)
        s'' divided by a reference acceleration. The best reference is the largest acceleration, so that the values are
        near 1.
    step : float
        Time between samples [1/ω_n].
    damping_ratio : float
        ζ.
    tail : float
        Time after the last sample during which the base moves at constant velocity [1/ω_n]; rounded up to whole panels.
    """
    pieces = ceil(step * (1.0 + damping_ratio) / LARGEST_WINDOW)
    window = step / pieces
    change = np.diff(acceleration)
    starts = acceleration[:-1, None] + change[:, None] * (np.arange(pieces) / pieces)
    still = np.zeros(ceil(tail / window * (1.0 - 1e-12)))
    start = np.concatenate((starts.reshape(-1), still))
    jerk = np.concatenate((np.repeat(change / step, pieces), still))
    end = start + jerk * window
    rate = np.concatenate(([0.0], np.cumsum(window * (start + end) / 2.0)))
    displacement_step = window * (rate[:-1] + window * (2.0 * start + end) / 6.0)
    rows = filled(2 * TERMS, 0.0)
    rows[2] = 1.0 / 2.0
    rows[TERMS + 3] = 1.0 / 6.0
    return RecordBase(
        2.0 * float(damping_ratio),
        float(window),
        start.size,
        start,
        jerk,
        rate,
        np.concatenate(([0.0], np.cumsum(displacement_step))),
        np.maximum(np.abs(start), np.abs(end)),
        float(np.abs(acceleration).max()),
        rows,
    )


def start_on_record(
    base: RecordBase,
    friction: float | None,
    particle: Particle | None,
    v: float = 0.0,
    w: float = 0.0,
    place: float = 0.0,
) -> State:
    """State at the start of a record: the base at rest, the particle at rest in the absolute frame.

    A particle under gravity lies on its lower wall and moves with the wall.

    Parameters
    ----------
    v, w : float
        Displacement and velocity of the primary mass.
    place : float
        Position of the particle in its cavity, from −1 to 1; 0 is the middle. The value is ignored for a particle under
        gravity.
    """
    gap, p_rate, riding, inertia, slide = 0.0, 0.0, 0.0, 1.0, slide_at_rest(particle)
    if particle is not None:
        gap = particle.clearance_ratio * (1.0 + place)
        if particle.gravity is not None:
            gap, p_rate = 0.0, w
        if particle.friction is not None and p_rate == w:
            riding, inertia = 1.0, 1.0 + particle.mass_ratio
        elif particle.friction is not None:
            slide = moving_slide(float(np.sign(w)), particle)
    slip, slip_order = 0.0, 0
    if friction is not None:
        slip = float(np.sign(w))
        if w == 0.0:
            force = hold_force(v, -base.acceleration[0], inertia)
            slip = slip_direction(force, breakaway(friction, base.largest))
            slip_order = int(slip != 0.0)
    dwell = dwell_at_rest(particle)
    return State(
        float(v), float(w), slip, 1.0, float(gap), float(p_rate), riding, slip_order, 0, dwell, slide
    )
