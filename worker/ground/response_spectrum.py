"""Computes the response spectrum of a ground-motion record."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.ground.motion import GroundMotion
from damperlab.worker.ground.design import Damper, Structure
from damperlab.worker.ground.response import ground_response

Floats = NDArray[np.float64]

DAMPING = 0.05
"""Usual damping ratio of a response spectrum."""
PERIODS = np.geomspace(0.05, 5.0, 81)
"""Default natural periods [s]."""


@dataclass(frozen=True)
class ResponseSpectrum:
    """Largest displacement under one record, as a function of the natural period of a structure.

    Parameters
    ----------
    period_s : ndarray, (n,)
        Natural periods [s].
    displacement_m : ndarray, (n,)
        Largest displacement relative to the base [m], also between samples.
    damping_ratio : float
        Damping ratio of every structure.
    """

    period_s: Floats
    displacement_m: Floats
    damping_ratio: float

    @property
    def pseudo_acceleration_m_s2(self) -> Floats:
        """Return ω² times the largest displacement, shape (n,) [m/s²]."""
        found: Floats = (2.0 * np.pi / self.period_s) ** 2 * self.displacement_m
        return found


def response_spectrum(
    motion: GroundMotion, period_s: Floats = PERIODS, damping_ratio: float = DAMPING
) -> ResponseSpectrum:
    """Compute the response spectrum of a record.

    The periods [s] have shape (n,). The damping ratio is at least 0 and less than 1.
    """
    structures = [Structure(1.0, 1.0 / period, damping_ratio) for period in period_s.tolist()]
    peaks = [ground_response(each, Damper(), motion).peak_relative_displacement_m for each in structures]
    return ResponseSpectrum(np.asarray(period_s), np.array(peaks), damping_ratio)
