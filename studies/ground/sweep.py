"""A swept sine of the base: the motion in closed form, and the record that is sampled from it."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from damperlab.studies.ground.motion import GroundMotion
from damperlab.studies.ground.recipe import ramps
from damperlab.studies.portable import cos, exp, expm1, sin

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
        """Return a phrase that describes the base motion after multiplication by a factor."""
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
