"""A ground motion: base acceleration at equal time steps, interpolated linearly between the samples."""

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
"""Standard gravity g [m/s²]."""

MOST_SAMPLES = 400_000
SHORTEST_STEP, LONGEST_STEP = 1e-5, 1.0
"""Smallest and largest time step of a record [s]."""
MOST_ACCELERATION = 1e4
"""Largest allowed acceleration of a record [m/s²], a thousand times the largest acceleration ever recorded."""

FARTHEST_M = 12.0
"""Largest plausible displacement of the ground [m]. In the Chi-Chi earthquake of 1999, the ground moved about 10 m."""


class MotionSummary(TypedDict):
    """Summary of a record in SI units."""

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
    """Summary of a record that has an id."""

    id: str


class GroundMotionDocument(MotionOfId):
    """Summary of a stored record, with its owner."""

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
        Base acceleration [m/s²], linear between samples. The base is at rest before the first sample.
    source : str
        Origin of the record, as a text.
    """

    name: str
    step_s: float
    acceleration_m_s2: NDArray[np.float64] = field(repr=False)
    source: str = ""

    @property
    def content(self) -> bytes:
        """Time step and samples as bytes of little-endian float64 numbers."""
        return np.concatenate(([self.step_s], self.acceleration_m_s2)).astype("<f8").tobytes()

    @property
    def sha256(self) -> str:
        """SHA-256 of `content`, 64 hex digits. The name of a record does not change this hash."""
        return hashlib.sha256(self.content).hexdigest()

    @property
    def digest(self) -> str:
        """First twelve hex digits of `sha256`."""
        return self.sha256[:12]

    @property
    def duration_s(self) -> float:
        """Time from the first to the last sample [s]."""
        return (self.acceleration_m_s2.size - 1) * self.step_s

    @property
    def peak_m_s2(self) -> float:
        """Largest |acceleration| [m/s²]."""
        return float(np.abs(self.acceleration_m_s2).max())

    def base_motion(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the velocity [m/s] and displacement [m] at the samples, integrated exactly from rest."""
        a, h = self.acceleration_m_s2, self.step_s
        velocity = np.concatenate(([0.0], np.cumsum(h * (a[:-1] + a[1:]) / 2)))
        way = velocity[:-1] * h + h * h * (2 * a[:-1] + a[1:]) / 6
        return velocity, np.concatenate(([0.0], np.cumsum(way)))

    def summary(self) -> MotionSummary:
        """Return the summary of the record."""
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
    """Check that a motion can be used in a computation, and return the motion.

    Raises
    ------
    StudyFaults
        If the number of samples, the time step or the peak acceleration is out of bounds, or the base does not move.
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
    """Return a warning if a record moves the base by more than `FARTHEST_M`; otherwise an empty text."""
    if moved_m <= FARTHEST_M:
        return ""
    return f"Beware: the record moves its base by {moved_m:.3g} m. Check its units, its baseline and its largest sample."


def refused(place: str, found: str, allowed: str, advice: str, told: str = "") -> StudyFaults:
    """Return the exception for one fault of a record.

    `place` is a field or a line, and `told` is the text of the message.
    """
    in_line = f"{place.capitalize()} must be {allowed}, not {found}." if place.startswith("line ") else ""
    return StudyFaults([Fault(place, found, allowed, advice, told or in_line)])
