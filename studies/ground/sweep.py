"""A swept sine of the base, read from a document: the motion in closed form, and the record sampled from it."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from damperlab.studies.faults import Fault, StudyFaults, listing
from damperlab.studies.ground.motion import GroundMotion
from damperlab.studies.ground.recipe import OPTIONAL, one_of, ramps, read_numbers, schema_of, too_many_samples
from damperlab.studies.physical import BASE_AMPLITUDE
from damperlab.studies.portable import cos, exp, expm1, sin
from damperlab.studies.quantity import Quantity

Floats = NDArray[np.float64]

SAMPLES_PER_CYCLE = 72
"""Number of samples per cycle of the highest frequency.

Linear interpolation over a step h has an error of at most h²/8·max |a''|. For a sine, the error is (ωh)²/8 = 9.5e-4
of the amplitude. Ramps of `FEWEST_RAMP_CYCLES` increase a'' by less than 5 %.
"""
FEWEST_RAMP_CYCLES = 4.0
SPELLED: tuple[tuple[str, str], ...] = (
    ("base amplitude", "m"),
    ("base velocity", "m/s"),
    ("base acceleration", "m/s²"),
)
"""Name and unit of the constant amplitude of a sweep, for displacement, velocity and acceleration."""

PLACE = "sweep"
ENDS: dict[str, Quantity] = {
    name: Quantity(name, meaning, 0.02, 1000.0, "give it in Hz")
    for name, meaning in (
        ("start_hz", "frequency at the beginning [Hz]"),
        ("stop_hz", "frequency at the end [Hz]; lower than at the beginning in a run-down"),
    )
}
PACES: dict[str, Quantity] = {
    each.name: each
    for each in (
        Quantity("rate_hz_per_s", "change of the frequency [Hz/s]", 1e-6, 1e6, "give it in Hz/s"),
        Quantity("rate_octaves_per_minute", "octaves in a minute", 1e-6, 1e6, "one octave in a minute is usual"),
        Quantity("duration_s", "duration of a sweep at a constant rate in Hz/s [s]", 1e-3, 1e6, "give it in s"),
    )
}  # fmt: skip
"""Keys for the rate of a sweep, which is positive also in a run-down. A document has exactly one of
the keys.
"""
AMPLITUDES: dict[str, Quantity] = {
    each.name: each
    for each in (
        BASE_AMPLITUDE,
        Quantity("base_velocity_m_per_s", "amplitude of the base velocity [m/s]", 1e-12, 1e12, "give it in m/s"),
        Quantity(
            "base_acceleration_m_per_s2", "amplitude of the base acceleration [m/s²]", 1e-12, 1e12, "give it in m/s²"
        ),
    )
}  # fmt: skip
"""Keys for the constant amplitude of displacement, velocity or acceleration."""
RAMP_CYCLES = Quantity(
    "ramp_cycles",
    "cycles of `start_hz` in which the amplitude rises, and of `stop_hz` in which it falls",
    FEWEST_RAMP_CYCLES,
    1000.0,
    f"{FEWEST_RAMP_CYCLES:g} is the default",
)
NUMBERS: dict[str, tuple[Quantity, float | None]] = {
    **{name: (quantity, None) for name, quantity in ENDS.items()},
    **{name: (quantity, OPTIONAL) for name, quantity in (PACES | AMPLITUDES).items()},
    RAMP_CYCLES.name: (RAMP_CYCLES, FEWEST_RAMP_CYCLES),
}


@dataclass(frozen=True)
class Sweep:
    """A sine of the base whose frequency changes from `start_hz` to `stop_hz`.

    The base displacement is z = w·(a/ωⁿ)·sin φ with φ = ∫ω dt from 0. The window w rises from 0 to 1 over the first
    cycles and falls over the last cycles. Velocity and acceleration are exact derivatives of the displacement.

    Parameters
    ----------
    start_hz, stop_hz : float
        Frequency at the beginning and at the end [Hz]. In a run-down, `stop_hz` is below `start_hz`.
    duration_s : float
        Total duration [s], with the ramps.
    logarithmic : bool
        True for a constant rate in octaves per minute, False for a constant rate in Hz/s.
    amplitude : float
        Constant amplitude of the displacement [m], the velocity [m/s] or the acceleration [m/s²].
    order : int
        Number of time derivatives: 0 if `amplitude` is a displacement, 1 for a velocity, 2 for an acceleration.
    ramp_cycles : float
        Duration of the rise in cycles of `start_hz`, and duration of the fall in cycles of `stop_hz`.
    """

    start_hz: float
    stop_hz: float
    duration_s: float
    logarithmic: bool
    amplitude: float
    order: int
    ramp_cycles: float

    noun = "sweep"
    shorter = "sweep faster, over a narrower band, or at lower frequencies"

    @property
    def highest_hz(self) -> float:
        """The higher of `start_hz` and `stop_hz`."""
        return max(self.start_hz, self.stop_hz)

    @property
    def rise_s(self) -> float:
        """Duration of the rise of the amplitude [s]."""
        return self.ramp_cycles / self.start_hz

    @property
    def fall_s(self) -> float:
        """Duration of the fall of the amplitude [s]."""
        return self.ramp_cycles / self.stop_hz

    @property
    def growth_per_s(self) -> float:
        """Rate of change of log frequency in a logarithmic sweep [1/s]."""
        return math.log(self.stop_hz / self.start_hz) / self.duration_s

    @property
    def samples(self) -> int:
        """Number of samples of the record."""
        return math.ceil(self.duration_s * self.highest_hz * SAMPLES_PER_CYCLE) + 1

    def frequency_hz(self, time_s: ArrayLike) -> Floats:
        """Return the frequency at times from 0 to the end [Hz]."""
        time = np.asarray(time_s, dtype=float)
        if self.logarithmic:
            return np.asarray(self.start_hz * exp(self.growth_per_s * time))
        return np.asarray(self.start_hz + (self.stop_hz - self.start_hz) / self.duration_s * time)

    def phase(self, time_s: ArrayLike) -> Floats:
        """Return the phase 2π∫f dt, which is 0 at time 0 [rad]."""
        time = np.asarray(time_s, dtype=float)
        if self.logarithmic:
            rate = self.growth_per_s
            return np.asarray(2.0 * math.pi * self.start_hz * expm1(rate * time) / rate)
        half_rate = (self.stop_hz - self.start_hz) / self.duration_s / 2.0
        return np.asarray(2.0 * math.pi * (self.start_hz + half_rate * time) * time)

    def base(self, time_s: ArrayLike) -> tuple[Floats, Floats, Floats]:
        """Return displacement [m], velocity [m/s] and acceleration [m/s²] of the base at times from 0 to the end.

        With the envelope E = w·a/ωⁿ: z = E sin φ, z' = E' sin φ + Eω cos φ, z'' = (E'' − Eω²) sin φ + (2E'ω + Eω') cos φ.
        """
        time = np.asarray(time_s, dtype=float)
        omega, phase = 2.0 * math.pi * self.frequency_hz(time), self.phase(time)
        # ω'/ω and ω''/ω
        if self.logarithmic:
            slope = np.full_like(time, self.growth_per_s)
            bend = slope**2
        else:
            slope = 2.0 * math.pi * (self.stop_hz - self.start_hz) / self.duration_s / omega
            bend = np.zeros_like(time)
        n = self.order
        level = self.amplitude / omega**n
        level_1 = -n * slope * level
        level_2 = (n * (n + 1) * slope**2 - n * bend) * level
        ramp, ramp_1, ramp_2 = ramps(time, self.duration_s, self.rise_s, self.fall_s)
        envelope = ramp * level
        envelope_1 = ramp_1 * level + ramp * level_1
        envelope_2 = ramp_2 * level + 2.0 * ramp_1 * level_1 + ramp * level_2
        sine, cosine = sin(phase), cos(phase)
        return (
            envelope * sine,
            envelope_1 * sine + envelope * omega * cosine,
            (envelope_2 - envelope * omega**2) * sine
            + (2.0 * envelope_1 + envelope * slope) * omega * cosine,
        )

    def motion(self, name: str = "") -> GroundMotion:
        """Return the record, with at least `SAMPLES_PER_CYCLE` samples per cycle of the highest frequency.

        Parameters
        ----------
        name : str
            Name of the record; by default the name of the sweep.
        """
        count = self.samples
        _, _, acceleration = self.base(np.linspace(0.0, self.duration_s, count))
        source = f"{self.words[:1].upper()}{self.words[1:]}"
        return GroundMotion(name or self.name, self.duration_s / (count - 1), acceleration, source)

    @property
    def name(self) -> str:
        """Name of the sweep, which states both end frequencies and the rate."""
        return f"sweep {self._course}"

    @property
    def words(self) -> str:
        """Description of the base motion, such as "swept from 6 to 10 Hz at …"."""
        return self.words_at(1.0)

    def words_at(self, scale: float) -> str:
        """Return a phrase for the base motion multiplied by `scale`."""
        constant, unit = SPELLED[self.order]
        value = scale * self.amplitude
        level = f"{value:.4g} {unit}"
        if unit != "m/s²" and value < 1.0:
            level = f"{1e3 * value:.4g} m{unit}"
        return f"swept {self._course} with a {constant} of {level}"

    @property
    def _course(self) -> str:
        ends = f"from {self.start_hz:.6g} to {self.stop_hz:.6g} Hz"
        if self.logarithmic:
            octaves = abs(math.log2(self.stop_hz / self.start_hz))
            return f"{ends} at {60.0 * octaves / self.duration_s:.4g} octaves per minute"
        return f"{ends} at {abs(self.stop_hz - self.start_hz) / self.duration_s:.4g} Hz/s"


def sweep_of(document: object) -> Sweep:
    """Read a sweep from a document.

    Parameters
    ----------
    document : object
        Mapping with ``start_hz``, ``stop_hz``, one of `PACES`, one of `AMPLITUDES`, and optionally ``ramp_cycles`` and
        ``name``.

    Raises
    ------
    StudyFaults
        If the document is invalid; the exception lists every fault.
    """
    example = '{"start_hz": 6, "stop_hz": 10, "rate_hz_per_s": 0.2, "base_amplitude_m": 0.001}'
    given, found, faults = read_numbers(document, PLACE, NUMBERS, (), example)
    pace = one_of(PACES, given, PLACE, faults, "how fast the frequency changes", "rate_hz_per_s")
    amplitude = one_of(AMPLITUDES, given, PLACE, faults, "how far the base moves", "base_amplitude_m")
    start, stop = (found.get(key) for key in ENDS)
    if start is not None and start == stop:
        told = f"{{field}} = {stop:g} is also the frequency at which the sweep begins; the two must differ."
        advice = "give another frequency"
        faults.append(Fault(f"{PLACE}.stop_hz", f"{stop:g}", "another frequency than start_hz", advice, told))
    if faults or start is None or stop is None:
        raise StudyFaults(faults)
    sweep = Sweep(
        start,
        stop,
        _duration_s(pace, found[pace], start, stop),
        pace == "rate_octaves_per_minute",
        found[amplitude],
        list(AMPLITUDES).index(amplitude),
        found[RAMP_CYCLES.name],
    )
    why = f"{SAMPLES_PER_CYCLE} in each cycle of {sweep.highest_hz:g} Hz over {sweep.duration_s:.4g} s"
    faults = _too_short(sweep, pace) + too_many_samples(f"{PLACE}.{pace}", sweep.samples, why, sweep.shorter)
    if faults:
        raise StudyFaults(faults)
    return sweep


def sweep_schema() -> dict[str, Any]:
    """Return the JSON schema of a sweep."""
    told = "A sinusoidal base motion whose frequency runs from `start_hz` to `stop_hz`, with one of "
    return schema_of(f"{told}{listing(PACES)}, and one of {listing(AMPLITUDES)}.", NUMBERS)


def _duration_s(pace: str, value: float, start: float, stop: float) -> float:
    if pace == "rate_hz_per_s":
        return abs(stop - start) / value
    if pace == "rate_octaves_per_minute":
        return 60.0 * abs(math.log2(stop / start)) / value
    return value


def _too_short(sweep: Sweep, pace: str) -> list[Fault]:
    ramps = sweep.rise_s + sweep.fall_s
    if ramps <= sweep.duration_s:
        return []
    found, allowed = f"{sweep.duration_s:.4g} s", f"a sweep of at least {ramps:.4g} s"
    told = (
        f"{{field}} makes a sweep of {found}, but the amplitude takes {ramps:.4g} s to rise and fall, "
        f"{sweep.ramp_cycles:g} cycles at either end."
    )
    return [Fault(f"{PLACE}.{pace}", found, allowed, "sweep slower, or over a wider band", told)]
