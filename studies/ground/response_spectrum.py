"""What a ground-motion record does to structures without a damper: the response spectrum by which engineers know it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.ground.motion import GroundMotion

Floats = NDArray[np.float64]

DAMPING = 0.05
"""Damping ratio for which spectra are usually drawn."""
AT_ONCE = 1_000_000
"""Times at which velocities are looked at in one array."""
HALVINGS = 30
"""How often the place of a peak is halved."""
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
        Largest displacement against the base [m], also between samples.
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
    structure's matrix. Between two samples the acceleration of a structure is a decaying sine, whose zeros are known, and
    from one of them to the next its velocity is monotonic: so every peak is found.

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
    turns = int(np.max(root * omega) * h / np.pi) + 1
    at_once = max(1, AT_ONCE // (omega.size * (turns + 2)))
    steps: list[tuple[Floats, Floats, Floats, Floats]] = []
    for before, after in zip(load[:-1].tolist(), load[1:].tolist(), strict=True):
        slope = after - before
        first, rate = (before - creep * slope) / omega**2, slope / (h * omega**2)
        dx, dv = x - first, v - rate
        steps.append((first, rate, dx, dv))
        if len(steps) == at_once:
            largest = np.maximum(largest, _peaks(steps, h, omega, zeta, turns))
            steps = []
        x, v = (
            x_of_x * dx + x_of_v * dv + (after - creep * slope) / omega**2,
            v_of_x * dx + v_of_v * dv + rate,
        )
        largest = np.maximum(largest, np.abs(x))
    if steps:
        largest = np.maximum(largest, _peaks(steps, h, omega, zeta, turns))
    return ResponseSpectrum(np.asarray(period_s), largest, zeta)


def _peaks(
    steps: Sequence[tuple[Floats, Floats, Floats, Floats]], h: float, omega: Floats, zeta: float, turns: int
) -> Floats:
    """Give the largest peaks of structures inside some steps, (n,); 0 without one.

    Parameters
    ----------
    steps : sequence of tuple
        Of each step the particular solution, its rate, and by how much displacement and velocity differ from them at its
        beginning, (n,) each.
    h, omega, zeta
        Time step [s], natural frequencies (n,) [rad/s], damping ratio.
    turns : int
        How often the acceleration of a structure is 0 in a step at most.
    """
    first, rate, dx, dv = (np.array(each) for each in zip(*steps, strict=True))
    root = np.sqrt(1.0 - zeta**2)
    damped = root * omega
    # displacement and velocity are e^(−ζωt) (p cos ω_d t + q sin ω_d t), beside the particular solution
    of_x, of_v = (dv + zeta * omega * dx) / damped, -(omega**2 * dx + zeta * omega * dv) / damped
    a = -(omega**2) * dx - 2.0 * zeta * omega * dv
    first_turn = np.arctan2(a, (omega**2 * dv + zeta * omega * a) / damped) % np.pi / damped
    times = first_turn[..., None] + np.arange(turns) * (np.pi / damped)[:, None]
    times = np.concatenate(
        (np.zeros((*dx.shape, 1)), np.minimum(times, h), np.full((*dx.shape, 1), h)), axis=-1
    )

    def moved(t: Floats, p: Floats, q: Floats, w: Floats) -> Floats:
        found: Floats = np.exp(-zeta * w * t) * (p * np.cos(root * w * t) + q * np.sin(root * w * t))
        return found

    speed = rate[..., None] + moved(times, dv[..., None], of_v[..., None], omega[:, None])
    step, structure, part = np.nonzero(speed[..., :-1] * speed[..., 1:] < 0.0)
    place, w = (step, structure), omega[structure]
    low, high, rising = times[*place, part], times[*place, part + 1], speed[*place, part + 1] > 0.0
    # a peak is flat: half the digits of its place are all of its height
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        above = (rate[place] + moved(middle, dv[place], of_v[place], w) > 0.0) == rising
        low, high = np.where(above, low, middle), np.where(above, middle, high)
    peaks = first[place] + rate[place] * low + moved(low, dx[place], of_x[place], w)
    largest = np.zeros_like(omega)
    np.maximum.at(largest, structure, np.abs(peaks))
    return largest
