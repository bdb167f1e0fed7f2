"""Random vibration of the base: a stationary Gaussian acceleration with a given power spectral density."""

import math
from dataclasses import dataclass
from functools import cached_property, partial
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from damperlab.studies.faults import Fault, StudyFaults, attempt, describe, listing
from damperlab.studies.ground.motion import STANDARD_GRAVITY, GroundMotion
from damperlab.studies.ground.recipe import (
    SEED_SCHEMA,
    one_of,
    ramps,
    read_numbers,
    read_seed,
    schema_of,
    too_many_samples,
)
from damperlab.studies.portable import cos, expm1, log, sin
from damperlab.studies.quantity import Quantity

Floats = NDArray[np.float64]

PLACE = "random_vibration"
FREQUENCY = Quantity("frequency_hz", "frequency of a point of the table [Hz]", 0.02, 2000.0, "give it in Hz")
LEVELS: dict[str, Quantity] = {
    "psd_m2_per_s3": Quantity(
        "psd_m2_per_s3", "level there [(m/s²)²/Hz]", 1e-12, 1e9, "give it in (m/s²)²/Hz, which is m²/s³"
    ),
    "psd_g2_per_hz": Quantity("psd_g2_per_hz", "level there [g²/Hz]", 1e-12, 1e6, "give it in g²/Hz"),
}
"""Keys for the levels of the table. A document has one of the keys, which states the unit."""
DURATION = Quantity("duration_s", "time at full level [s]", 0.01, 1e5, "some tens of seconds are usual")
NUMBERS = {DURATION.name: (DURATION, None)}
MOST_POINTS = 100
SAMPLES_PER_CYCLE = 8
"""Number of samples per cycle of the highest frequency.

Linear interpolation over a step h multiplies a component of frequency f by sinc²(fh). The amplitudes are
corrected for this factor. The interpolation also adds a component at 1/h − f, which is smaller by
(fh/(1 − fh))², at most 1/49.
"""
RAMP_CYCLES = 4.0
"""Duration of the rise to full level, and of the final fall, in cycles of the lowest frequency."""
SHOWN = {"frequency_hz": "[10, 100]", "psd_g2_per_hz": "[0.001, 0.001]", "psd_m2_per_s3": "[0.1, 0.1]"}
"""Example of each column of a table, for messages."""
EXAMPLE = '{"frequency_hz": [10, 100], "psd_g2_per_hz": [0.001, 0.001], "duration_s": 30, "seed": 1}'


@dataclass(frozen=True)
class RandomVibration:
    """Definition of a random vibration: table of the power spectral density, duration and seed.

    Parameters
    ----------
    frequency_hz : tuple of float
        Frequencies of the table in ascending order [Hz].
    psd_m2_per_s3 : tuple of float
        One-sided power spectral density at these frequencies [(m/s²)²/Hz]. Between two points, log density is linear in
        log frequency, as in MIL-STD-810H, method 514.8. Outside the table the density is 0.
    duration_s : float
        Duration at full level [s], to which the two ramps of `RAMP_CYCLES` are added.
    seed : int
        Seed of the draw.
    """

    frequency_hz: tuple[float, ...]
    psd_m2_per_s3: tuple[float, ...]
    duration_s: float
    seed: int

    noun = "random vibration record"
    shorter = "shorten `duration_s`, or end the table at a lower frequency"

    @property
    def ramp_s(self) -> float:
        """Duration of each of the two ramps [s]."""
        return RAMP_CYCLES / self.frequency_hz[0]

    @property
    def whole_s(self) -> float:
        """Total duration, with both ramps [s]."""
        return self.duration_s + 2.0 * self.ramp_s

    @property
    def samples(self) -> int:
        """Number of samples of the record."""
        return math.ceil(self.whole_s * self.frequency_hz[-1] * SAMPLES_PER_CYCLE) + 1

    @cached_property
    def rms_m_s2(self) -> float:
        """Rms acceleration at full level [m/s²], the square root of the integral of the density."""
        return math.sqrt(float(self.power(self.frequency_hz[-1])))

    def power(self, frequency_hz: ArrayLike) -> Floats:
        """Integrate the density from the lowest frequency to each given frequency, in closed form [(m/s²)²]."""
        to = np.asarray(frequency_hz, dtype=float)
        total = np.zeros_like(to)
        points = zip(self.frequency_hz, self.psd_m2_per_s3, strict=True)
        for (low, before), (high, after) in pairwise(points):
            # ∫ S₁·(f/f₁)ⁿ df with f = f₁·e^x, for x from 0 to `way`
            way, growth = (
                log(np.clip(to, low, high) / low),
                1.0 + math.log(after / before) / math.log(high / low),
            )
            total += before * low * (way if abs(growth) < 1e-9 else expm1(growth * way) / growth)
        return total

    def motion(self, name: str = "") -> GroundMotion:
        """Generate the record as a sum of cosines at equal steps of frequency, with random amplitudes and phases.

        The Fourier coefficients are Gaussian, and so is the sum (S. O. Rice, Bell Syst. Tech. J. 23 (1944) 282;
        M. Grigoriu, Probab. Eng. Mech. 8 (1993) 75). So the rms of the record varies with the seed.
        The mean power of each component is the integral of the density over one frequency step around the component.
        The ramps multiply the displacement of the base, and the record is the second derivative of the product. So the
        base starts and ends at rest in the same place.
        """
        count = self.samples
        step = self.whole_s / (count - 1)
        length = 2 * math.ceil(count / 2)
        spacing = 1.0 / (length * step)
        place = np.arange(1, length // 2)
        edges = self.power(spacing * (np.arange(1, length // 2 + 1) - 0.5))
        acts = np.flatnonzero(np.diff(edges) > 0.0)
        omega = 2.0 * math.pi * spacing * place[acts]
        half = 0.5 * omega * step
        draw = np.random.default_rng(self.seed).random((2, acts.size))
        level = np.sqrt(-2.0 * log(1.0 - draw[0]) * np.diff(edges)[acts]) / (sin(half) / half) ** 2
        phase = 2.0 * math.pi * draw[1]
        lines = level * cos(phase), level * sin(phase)

        def summed(real: Floats, imaginary: Floats) -> Floats:
            spectrum = np.zeros(length // 2 + 1, dtype=complex)
            spectrum.real[place[acts]], spectrum.imag[place[acts]] = real, imaginary
            return np.asarray(0.5 * length * np.fft.irfft(spectrum, length)[:count])

        way = summed(-lines[0] / omega**2, -lines[1] / omega**2)
        speed = summed(lines[1] / omega, -lines[0] / omega)
        ramp, ramp_1, ramp_2 = ramps(
            np.linspace(0.0, self.whole_s, count), self.whole_s, self.ramp_s, self.ramp_s
        )
        acceleration = ramp * summed(*lines) + 2.0 * ramp_1 * speed + ramp_2 * way
        return GroundMotion(name or self.name, step, acceleration, f"Random vibration {self._told(1.0)}")

    @property
    def name(self) -> str:
        """Name of the record."""
        low, high = self.frequency_hz[0], self.frequency_hz[-1]
        return f"random vibration from {low:.6g} to {high:.6g} Hz, seed {self.seed}"

    def words_at(self, scale: float) -> str:
        """Return a phrase for the base motion multiplied by `scale`."""
        return f"under random vibration {self._told(scale)}"

    def _told(self, scale: float) -> str:
        rms = abs(scale) * self.rms_m_s2
        return (
            f"from {self.frequency_hz[0]:.6g} to {self.frequency_hz[-1]:.6g} Hz with an rms of {rms:.4g} m/s² "
            f"({rms / STANDARD_GRAVITY:.3g} g), seed {self.seed}"
        )


def random_vibration_of(document: object) -> RandomVibration:
    """Read the definition of a random vibration from a document.

    Parameters
    ----------
    document : object
        Mapping with ``frequency_hz`` and one of `LEVELS`, which are lists of equal length, with ``duration_s``, and
        optionally with ``seed`` and ``name``.

    Raises
    ------
    StudyFaults
        If the document is invalid; the exception lists every fault.
    """
    others = (FREQUENCY.name, *LEVELS, "seed")
    given, found, faults = read_numbers(document, PLACE, NUMBERS, others, EXAMPLE)
    seed = read_seed(given, PLACE, faults)
    key = one_of(LEVELS, given, PLACE, faults, "the levels", "psd_g2_per_hz")
    frequencies = _column(FREQUENCY, given, faults)
    levels = _column(LEVELS[key], given, faults) if key else ()
    for place in range(1, len(frequencies)):
        low, high = frequencies[place - 1 : place + 1]
        if high <= low:
            told = f"{{field}} = {high:g} is not above the frequency before it, {low:g}."
            field, allowed = f"{PLACE}.frequency_hz[{place}]", f"a number above {low:g}"
            faults.append(Fault(field, f"{high:g}", allowed, "order the table by frequency", told))
    if frequencies and levels and len(levels) != len(frequencies):
        found_words, allowed = f"{len(levels)} levels", f"{len(frequencies)} levels, one for each frequency"
        told = f"{{field}} has {found_words} for {len(frequencies)} frequencies."
        faults.append(
            Fault(f"{PLACE}.{key}", found_words, allowed, "give one level for each frequency", told)
        )
    if faults:
        raise StudyFaults(faults)
    unit = STANDARD_GRAVITY**2 if key == "psd_g2_per_hz" else 1.0
    vibration = RandomVibration(frequencies, tuple(unit * each for each in levels), found["duration_s"], seed)
    why = f"{SAMPLES_PER_CYCLE} in each cycle of {frequencies[-1]:g} Hz over {vibration.whole_s:.4g} s with its ramps"
    faults = too_many_samples(f"{PLACE}.duration_s", vibration.samples, why, vibration.shorter)
    if faults:
        raise StudyFaults(faults)
    return vibration


def _column(quantity: Quantity, document: object, faults: list[Fault]) -> tuple[float, ...]:
    """Return one column of the table, or an empty tuple if the column is invalid."""
    field = f"{PLACE}.{quantity.name}"
    raw = document.get(quantity.name) if isinstance(document, dict) else None
    if not isinstance(raw, list | tuple) or not 2 <= len(raw) <= MOST_POINTS:
        allowed = f"a list of 2 to {MOST_POINTS} numbers"
        faults.append(
            Fault(field, describe(raw), allowed, f"write `{quantity.name}: {SHOWN[quantity.name]}`")
        )
        return ()
    before = len(faults)
    column = [
        attempt(partial(quantity.read, each, f"{field}[{place}]"), math.nan, faults)
        for place, each in enumerate(raw)
    ]
    return tuple(column) if len(faults) == before else ()


def random_vibration_schema() -> dict[str, Any]:
    """Return the JSON schema of the document that `random_vibration_of` reads."""
    columns = {
        each.name: {"type": "array", "minItems": 2, "maxItems": MOST_POINTS, "items": each.schema()}
        for each in (FREQUENCY, *LEVELS.values())
    }
    told = f"A Gaussian acceleration of the base with a power spectral density: `frequency_hz`, and one of {listing(LEVELS)}."
    return schema_of(told, NUMBERS, columns | SEED_SCHEMA, (FREQUENCY.name,))
