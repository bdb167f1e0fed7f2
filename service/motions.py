"""Quantities derived from a computed motion: forces on the structure, and spectra of the displacement."""

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from damperlab.worker.point import Design

Column = NDArray[np.float64]

FORCES = ("spring", "damping", "friction", "excitation")
"""Names of the forces on a structure. The forces are divided by k·Z."""

SAMPLES_PER_CYCLE = 256
HARMONICS = 8
"""Highest harmonic of the excitation in a spectrum of a steady motion."""
NATURAL = 4
"""A spectrum under a record ends at this multiple of the structure's natural frequency."""
HELD = 1e-9
"""A structure counts as locked by friction if its speed is below this fraction of the largest speed."""
AT_WALL = 1e-9
"""A particle counts as resting against a wall if its distance from the wall is below this fraction of the clearance."""


def forces_on(history: Mapping[str, Column], design: "Design") -> dict[str, Column]:
    """Compute the forces on the structure, divided by k·Z.

    Parameters
    ----------
    history : mapping of ndarray
        Columns of a time history, see `damperlab.worker.point.Simulation`.
    design : Design
        The design point.

    Returns
    -------
    dict of ndarray
        One value per sample for each of ``spring``, ``damping``, ``friction`` and ``excitation``. The excitation force
        is 0 if the base is shaken. While friction locks the structure, ``friction`` is the force that moves the
        structure with its base. Forces of instantaneous impacts are not included, because they are not finite.
    """
    u, v, v_rate = history["u"], history["v"], history["v_rate"]
    phase = design.frequency_ratio * (history["time"] - history["time"][0])
    force = np.sin(phase) if design.forced else np.zeros_like(u)
    carried = np.ones_like(u)
    if design.particle is not None:
        nearest = design.particle.clearance_ratio * (1.0 - AT_WALL)
        # a particle at rest against a wall moves with the structure
        carried[np.abs(history["p"] - u) >= nearest] += design.particle.mass_ratio
    most = design.friction_ratio
    # the acceleration of the base is -r² z
    held = np.clip(v - carried * design.frequency_ratio**2 * (u - v) - force, -most, most)
    moves = np.abs(v_rate) > HELD * np.abs(v_rate).max(initial=0.0)
    return {
        "spring": -v,
        "damping": -2.0 * design.damping_ratio * v_rate,
        "friction": np.where(moves, -most * np.sign(v_rate), held),
        "excitation": force,
    }


def harmonics_of(history: Mapping[str, Column], frequency_ratio: float) -> dict[str, Column]:
    """Compute the spectrum of u over all complete excitation cycles of a steady motion.

    Returns
    -------
    dict of ndarray
        ``multiple`` is the frequency divided by the excitation frequency: 1/n, 2/n, … up to `HARMONICS`, for
        n cycles. ``amplitude`` is the amplitude at each frequency, divided by Z.
    """
    time = history["time"]
    cycle = 2.0 * math.pi / frequency_ratio
    cycles = round((time[-1] - time[0]) / cycle)
    if cycles < 1:
        return {"multiple": np.zeros(0), "amplitude": np.zeros(0)}
    amplitude = _amplitudes(time, history["u"], cycles * cycle, cycles * SAMPLES_PER_CYCLE)
    place = np.arange(1, HARMONICS * cycles + 1)
    return {"multiple": place / cycles, "amplitude": amplitude[place]}


def drift_spectrum(history: Mapping[str, Column], natural_frequency_hz: float) -> dict[str, Column]:
    """Compute the spectrum of the displacement relative to the base under a record.

    Returns
    -------
    dict of ndarray
        Frequencies ``frequency_hz`` up to `NATURAL` times the natural frequency, and amplitudes ``amplitude_m``.
    """
    time = history["time_s"]
    span, highest = time[-1] - time[0], NATURAL * natural_frequency_hz
    count = max(256, math.ceil(4.0 * highest * span))
    amplitude = _amplitudes(time, history["relative_displacement_m"], span, count)
    place = np.arange(1, int(min(highest * span, count / 2 - 1)) + 1)
    return {"frequency_hz": place / span, "amplitude_m": amplitude[place]}


def _amplitudes(time: Column, values: Column, span: float, count: int) -> Column:
    """Interpolate values at equal time steps, and return the amplitudes of their discrete Fourier transform."""
    even = np.interp(time[0] + span * np.arange(count) / count, time, values)
    return np.asarray(2.0 * np.abs(np.fft.rfft(even)) / count)
