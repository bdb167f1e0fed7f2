"""A ground motion: base acceleration at equal time steps, taken as linear in between."""

import hashlib
from dataclasses import dataclass, field
from typing import NotRequired

import numpy as np
from numpy.typing import NDArray
from typing_extensions import TypedDict

from damperlab.studies.faults import Fault, StudyFaults
from damperlab.studies.shapes import Count, Measured
from damperlab.studies.vocabulary import ACCELERATION_UNITS

STANDARD_GRAVITY = ACCELERATION_UNITS["g"]
"""m/s² in one g."""

MOST_SAMPLES = 400_000
SHORTEST_STEP, LONGEST_STEP = 1e-5, 1.0
"""Bounds of a time step [s]."""
MOST_ACCELERATION = 1e4
"""Bound on a sample [m/s²], a thousand times the strongest ever recorded: beyond it the unit must be wrong."""

FARTHEST_M = 12.0
"""Largest displacement of measured ground: Chi-Chi 1999 by about 10 m."""


class MotionSummary(TypedDict):
    """An entry in a list of records, in SI units."""

    name: str
    source: str
    samples: Count
    step_s: Measured
    duration_s: Measured
    peak_acceleration_m_s2: Measured
    peak_acceleration_g: Measured
    peak_velocity_m_s: Measured
    peak_displacement_m: Measured
    digest: str


class MotionOfId(MotionSummary):
    """An entry for a record with an id."""

    id: str


class GroundMotionDocument(MotionOfId):
    """An entry for a stored record, with its owner."""

    submitted_by: NotRequired[str]


@dataclass(frozen=True)
class GroundMotion:
    """A record of base acceleration.

    Parameters
    ----------
    name : str
        Name of the record.
    step_s : float
        Time between samples [s].
    acceleration_m_s2 : ndarray, shape (samples,)
        Base acceleration [m/s²], linear from sample to sample; the base is at rest before the first.
    source : str
        Where it comes from, in words.
    """

    name: str
    step_s: float
    acceleration_m_s2: NDArray[np.float64] = field(repr=False)
    source: str = ""

    @property
    def content(self) -> bytes:
        """Time step and samples, as little-endian float64: all data on which a response depends."""
        return np.concatenate(([self.step_s], self.acceleration_m_s2)).astype("<f8").tobytes()

    @property
    def sha256(self) -> str:
        """SHA-256 of `content`, 64 hex digits; it is the same for the same motion under another name."""
        return hashlib.sha256(self.content).hexdigest()

    @property
    def digest(self) -> str:
        """First twelve hex digits of `sha256`."""
        return self.sha256[:12]

    @property
    def duration_s(self) -> float:
        """Time from the first sample to the last [s]."""
        return (self.acceleration_m_s2.size - 1) * self.step_s

    @property
    def peak_m_s2(self) -> float:
        """Largest |acceleration| [m/s²]."""
        return float(np.abs(self.acceleration_m_s2).max())

    def base_motion(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Velocity [m/s] and displacement [m] of the base at the samples, from rest, exact for the linear pieces."""
        a, h = self.acceleration_m_s2, self.step_s
        velocity = np.concatenate(([0.0], np.cumsum(h * (a[:-1] + a[1:]) / 2)))
        way = velocity[:-1] * h + h * h * (2 * a[:-1] + a[1:]) / 6
        return velocity, np.concatenate(([0.0], np.cumsum(way)))

    def summary(self) -> MotionSummary:
        """Return the entry for a list of records, in SI units."""
        velocity, displacement = self.base_motion()
        return {
            "name": self.name,
            "source": self.source,
            "samples": int(self.acceleration_m_s2.size),
            "step_s": self.step_s,
            "duration_s": self.duration_s,
            "peak_acceleration_m_s2": self.peak_m_s2,
            "peak_acceleration_g": self.peak_m_s2 / STANDARD_GRAVITY,
            "peak_velocity_m_s": float(np.abs(velocity).max()),
            "peak_displacement_m": float(np.abs(displacement).max()),
            "digest": self.digest,
        }


def checked(motion: GroundMotion, place: str = "record") -> GroundMotion:
    """Return the motion if it can be used in a computation.

    Raises
    ------
    StudyFaults
        If it is too short or too long, its step is out of bounds, or the base does not move.
    """
    size = motion.acceleration_m_s2.size
    if not 2 <= size <= MOST_SAMPLES:
        told = f"The record has {size:,} samples; it must have from 2 to {MOST_SAMPLES:,}."
        allowed = f"from 2 to {MOST_SAMPLES:,}"
        raise refused(place, f"{size:,} samples", allowed, "cut or resample the record", told)
    if not SHORTEST_STEP <= motion.step_s <= LONGEST_STEP:
        allowed = f"a time step from {SHORTEST_STEP:g} to {LONGEST_STEP:g} s"
        told = f"The record has a time step of {motion.step_s:g} s; it must be from {SHORTEST_STEP:g} to {LONGEST_STEP:g} s."
        raise refused(place, f"a step of {motion.step_s:g} s", allowed, "check the unit of time", told)
    peak = motion.peak_m_s2
    if not peak <= MOST_ACCELERATION:
        allowed = f"at most {MOST_ACCELERATION:g} m/s²"
        found = f"an acceleration of {peak:.6g} m/s²"
        told = f"The record has {found}; {allowed} is allowed."
        raise refused(place, found, allowed, "check the unit of acceleration", told)
    if peak < 1e-9:
        raise refused(
            place,
            f"a peak of {peak:g} m/s²",
            "a base that moves",
            "check the unit of acceleration",
            f"The base does not move in this record: its peak acceleration is {peak:g} m/s².",
        )
    return motion


def doubt_of(moved_m: float) -> str:
    """Warn of a record that moves its base by `moved_m` if ground never moves so far; otherwise empty."""
    if moved_m <= FARTHEST_M:
        return ""
    return f"Beware: the record moves its base by {moved_m:.3g} m. Check its units, its baseline and its largest sample."


def refused(place: str, found: str, allowed: str, advice: str, told: str = "") -> StudyFaults:
    """Return the exception that refuses a record for one fault, in a field or a line; `told` is its sentence."""
    in_line = f"{place.capitalize()} must be {allowed}, not {found}." if place.startswith("line ") else ""
    return StudyFaults([Fault(place, found, allowed, advice, told or in_line)])
