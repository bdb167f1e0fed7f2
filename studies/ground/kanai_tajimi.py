"""Artificial records with the Kanai–Tajimi spectrum: white noise in the rock, filtered by the soil above the rock."""

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from damperlab.studies.faults import Fault, StudyFaults
from damperlab.studies.ground.motion import STANDARD_GRAVITY, GroundMotion, checked
from damperlab.studies.ground.recipe import SEED_SCHEMA, read_numbers, read_seed, schema_of, too_many_samples
from damperlab.studies.portable import cos, sin
from damperlab.studies.quantity import Quantity

_QUANTITIES: dict[str, tuple[Quantity, float | None]] = {
    name: (Quantity(name, meaning, low, high, advice), default)
    for name, meaning, low, high, advice, default in (
        ("duration_s", "duration [s]", 0.1, 1000.0, "some tens of seconds are usual", 30.0),
        ("step_s", "time step [s]", 1e-4, 0.1, "0.01 s is usual", 0.01),
        (
            "ground_frequency_hz",
            "natural frequency of the soil [Hz]",
            0.01,
            100.0,
            "2.5 Hz is firm soil",
            2.5,
        ),
        ("ground_damping_ratio", "damping ratio of the soil", 0.01, 10.0, "0.6 is firm soil", 0.6),
        ("peak_g", "largest acceleration [g]", 1e-6, 100.0, "give it in g", 0.3),
        ("rise_s", "time over which the motion grows [s]", 0.0, 1000.0, "0 starts at full strength", 3.0),
        ("fall_s", "time over which it dies down [s]", 0.0, 1000.0, "0 ends at full strength", 10.0),
    )
}
SECOND_FREQUENCY, SECOND_DAMPING = 0.1, 0.6
"""Natural frequency of the second filter relative to that of the soil, and damping ratio of the second filter."""


def spectrum(
    frequency_hz: ArrayLike, ground_frequency_hz: float, ground_damping_ratio: float
) -> NDArray[np.float64]:
    """Return the power spectral density of the acceleration, divided by the density at frequency 0.

    With ξ = f/f_g, the density is (1 + 4ζ²ξ²)/((1 − ξ²)² + 4ζ²ξ²). K. Kanai (1957), H. Tajimi (1960).
    """
    square = (np.asarray(frequency_hz, dtype=float) / ground_frequency_hz) ** 2
    loss = 4.0 * ground_damping_ratio**2 * square
    return np.asarray((1.0 + loss) / ((1.0 - square) ** 2 + loss))


def read_kanai_tajimi(document: object) -> GroundMotion:
    """Generate a record from a document with any of the parameters of `kanai_tajimi`.

    Raises
    ------
    StudyFaults
        If the document is invalid; the exception lists every fault.
    """
    given, values, faults = read_numbers(document, "kanai_tajimi", _QUANTITIES, ("seed",), '{"seed": 1}')
    seed = read_seed(given, "kanai_tajimi", faults)
    if faults:
        raise StudyFaults(faults)
    return kanai_tajimi(seed, name=given.get("name", ""), **values)


def kanai_tajimi_schema() -> dict[str, Any]:
    """Return the JSON schema of the document that `read_kanai_tajimi` reads."""
    return schema_of("An artificial record with the spectrum of Kanai and Tajimi.", _QUANTITIES, SEED_SCHEMA)


def kanai_tajimi(
    seed: int,
    duration_s: float = 30.0,
    step_s: float = 0.01,
    ground_frequency_hz: float = 2.5,
    ground_damping_ratio: float = 0.6,
    peak_g: float = 0.3,
    rise_s: float = 3.0,
    fall_s: float = 10.0,
    name: str = "",
) -> GroundMotion:
    """Generate an artificial record with the Kanai–Tajimi spectrum.

    A sum of cosines at equal steps of frequency, with random phases, is multiplied by a trapezoid and then filtered
    again. The second filter removes low frequencies, which would make the base drift by metres. So the
    velocity and the displacement of the base die out with the acceleration.

    Parameters
    ----------
    seed : int
        Seed of the random phases. Equal seeds give identical records.
    duration_s, step_s : float
        Duration and time step of the record [s].
    ground_frequency_hz, ground_damping_ratio : float
        Natural frequency [Hz] and damping ratio of the soil.
    peak_g : float
        Largest acceleration [g], to which the record is scaled.
    rise_s, fall_s : float
        Times over which the motion grows linearly at the start and falls linearly at the end [s].
    name : str
        Name of the record.

    Raises
    ------
    StudyFaults
        If the record has too many samples, or rise and fall together are longer than the duration.

    Notes
    -----
    M. Shinozuka, G. Deodatis, Simulation of stochastic processes by spectral representation, Appl. Mech. Rev. 44 (1991)
    191: without the trapezoid, the periodogram of the record equals the spectrum. The sum of cosines is computed by one
    inverse FFT.

    The second filter is the high-pass filter of R. W. Clough, J. Penzien, Dynamics of Structures (1975):
    s²/(s² + 2ζ_f·ω_f·s + ω_f²) with ω_f = 0.1 ω_g and ζ_f = 0.6. The filter is applied after the trapezoid,
    because the opposite order would cause a drift (S. Rezaeian, A. Der Kiureghian, Earthquake Eng. Struct.
    Dyn. 39 (2010) 1155).
    """
    count = round(duration_s / step_s) + 1
    faults = too_many_samples(
        "kanai_tajimi.step_s", count, f"one every {step_s:g} s over {duration_s:g} s", "take a longer step"
    )
    if faults:
        raise StudyFaults(faults)
    if rise_s + fall_s > duration_s:
        found, advice = f"{rise_s + fall_s:g} s of rise and fall", "shorten rise_s or fall_s"
        told = f"The record takes {rise_s + fall_s:g} s to rise and fall, but lasts only {duration_s:g} s."
        raise StudyFaults([Fault("kanai_tajimi.rise_s", found, f"at most {duration_s:g} s", advice, told)])
    length = 2 * math.ceil(count / 2)
    frequency = np.fft.rfftfreq(length, step_s)[1:-1]
    phase = 2.0 * np.pi * np.random.default_rng(seed).random(frequency.size)
    lines = np.zeros(length // 2 + 1, dtype=complex)
    size = np.sqrt(spectrum(frequency, ground_frequency_hz, ground_damping_ratio))
    lines.real[1:-1], lines.imag[1:-1] = size * cos(phase), size * sin(phase)
    wave = np.fft.irfft(lines)[:count]
    time = step_s * np.arange(count)
    if rise_s > 0:
        wave = wave * np.minimum(time / rise_s, 1.0)
    if fall_s > 0:
        wave = wave * np.clip((time[-1] - time) / fall_s, 0.0, 1.0)
    wave = _at_rest(wave, 2.0 * math.pi * SECOND_FREQUENCY * ground_frequency_hz * step_s)
    wave = wave * (peak_g * STANDARD_GRAVITY / np.abs(wave).max())
    source = (
        f"Kanai–Tajimi, seed {seed}, ground {ground_frequency_hz:g} Hz, damping {ground_damping_ratio:g}, "
        f"peak {peak_g:g} g"
    )
    return checked(GroundMotion(name or f"Kanai–Tajimi {seed}", step_s, wave, source), "kanai_tajimi")


def _at_rest(wave: NDArray[np.float64], omega: float) -> NDArray[np.float64]:
    """Apply the second filter to an acceleration, starting from rest. `omega` is ω_f times the time step.

    The filter uses the trapezoidal rule. The velocity of the base is integrated with the same rule, so the
    base drifts only by rounding errors.
    """
    loss, spring = SECOND_DAMPING * omega, omega * omega / 4.0
    total = 1.0 + loss + spring
    # the step is the unit of time; the base is at rest at the first sample
    filtered = [float(wave[0])]
    speed = way = 0.0
    for soil in wave[1:].tolist():
        last = filtered[-1]
        coasting = speed + last / 2.0
        # x'' = soil − 2ζω·x' − ω²·x, where x' and x are the integrals of x'' up to this sample
        new = (soil - 2.0 * loss * coasting - 4.0 * spring * (way + (speed + coasting) / 2.0)) / total
        further = coasting + new / 2.0
        way += (speed + further) / 2.0
        speed = further
        filtered.append(new)
    return np.array(filtered)
