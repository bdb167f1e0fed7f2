"""What a ground-motion record does to structures without a damper: the response spectrum by which engineers know it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.ground.motion import GroundMotion

Floats = NDArray[np.float64]

DAMPING = 0.05
"""Damping ratio for which spectra are usually drawn."""
PERIODS = np.geomspace(0.05, 5.0, 81)
"""Natural periods of the structures [s]."""


@dataclass(frozen=True)
class ResponseSpectrum:
    """Peaks of structures under one record.

    Parameters
    ----------
    period_s : ndarray, (n,)
        Natural periods [s].
    displacement_m : ndarray, (n,)
        Largest displacement against the base at a sample [m].
    damping_ratio : float
        Of every structure.
    """

    period_s: Floats
    displacement_m: Floats
    damping_ratio: float

    @property
    def pseudo_acceleration_m_s2(self) -> Floats:
        """Give ω² times the largest displacement, (n,) [m/s²]."""
        found: Floats = (2.0 * np.pi / self.period_s) ** 2 * self.displacement_m
        return found


def response_spectrum(
    motion: GroundMotion, period_s: Floats = PERIODS, damping_ratio: float = DAMPING
) -> ResponseSpectrum:
    """March linear structures from sample to sample, exactly for a base acceleration that is linear between them.

    The recurrence is that of Nigam and Jennings (Bull. Seism. Soc. Am. 59, 1969), written with the exponential of the
    structure's matrix. Peaks are those at the samples: between two of them the displacement may be larger by a share of
    (ω h)²/8, h the time step.

    Parameters
    ----------
    motion : GroundMotion
        The record.
    period_s : ndarray, (n,)
        Natural periods [s], above 0.
    damping_ratio : float
        From 0 to less than 1.
    """
    h, omega, zeta = motion.step_s, 2.0 * np.pi / period_s, damping_ratio
    root = np.sqrt(1.0 - zeta**2)
    decay, s, c = np.exp(-zeta * omega * h), np.sin(root * omega * h), np.cos(root * omega * h)
    # x and its rate after a step without a load
    x_of_x, x_of_v = decay * (c + zeta / root * s), decay * s / (root * omega)
    v_of_x, v_of_v = -omega * decay * s / root, decay * (c - zeta / root * s)
    # a load p0 + (p1 - p0) t/h has the particular solution (p - 2 ζ (p1 - p0)/(ω h))/ω²
    creep = 2.0 * zeta / (omega * h)
    x, v, largest = np.zeros_like(omega), np.zeros_like(omega), np.zeros_like(omega)
    load = -motion.acceleration_m_s2
    for before, after in zip(load[:-1].tolist(), load[1:].tolist(), strict=True):
        slope = after - before
        first, rate = (before - creep * slope) / omega**2, slope / (h * omega**2)
        dx, dv = x - first, v - rate
        x, v = (
            x_of_x * dx + x_of_v * dv + (after - creep * slope) / omega**2,
            v_of_x * dx + v_of_v * dv + rate,
        )
        largest = np.maximum(largest, np.abs(x))
    return ResponseSpectrum(np.asarray(period_s), largest, zeta)
