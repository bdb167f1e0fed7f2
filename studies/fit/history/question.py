"""A measured time history, and the definition of its fit: known values and the parameters to estimate."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.choices import Contact, InstantContact
from damperlab.studies.fit.question import NAMED, Free, Sought
from damperlab.studies.variables import BEFORE

Column = NDArray[np.float64]

OVER_BASE = ("base_amplitude_m", "clearance_ratio", "friction_ratio", *BEFORE)
"""Quantities that are defined only if the base moves harmonically."""
KNOWN: tuple[str, ...] = tuple(name for name in NAMED if name not in OVER_BASE)
"""Quantities of a prototype whose values may be known."""
FREE: tuple[str, ...] = tuple(name for name in KNOWN if name != "mass_kg")
"""Parameters that may be estimated."""
INSTANT = InstantContact()
RELEASE = "initial_displacement_m"
"""Name of the release position, which is estimated because the first sample is as noisy as all other samples."""


@dataclass(frozen=True)
class History:
    """A displacement over time, from the beginning of the motion.

    Parameters
    ----------
    name : str
        Name of the measurement.
    step_s : float
        Time between samples [s].
    displacement_m : ndarray, shape (rows,)
        Displacement of the structure [m]. If the base rests, the displacement is measured from the structure's rest
        position without friction.
    relative : bool
        Whether the displacement is relative to the base. Without base motion, relative and absolute displacement agree.
    base_m_s2 : ndarray, shape (rows,), optional
        Acceleration of the base [m/s²], linear between samples; None if the base rests and the structure is
        released.
    deviation_m : ndarray, shape (rows,), optional
        Standard deviation of each displacement [m]; None if it is estimated from the scatter.
    before_release : int
        Number of rows before the release, which are left out of the columns.
    """

    name: str
    step_s: float
    displacement_m: Column = field(repr=False)
    relative: bool = True
    base_m_s2: Column | None = field(default=None, repr=False)
    deviation_m: Column | None = field(default=None, repr=False)
    before_release: int = 0

    @property
    def rows(self) -> int:
        """Number of samples."""
        return self.displacement_m.size

    @property
    def time_s(self) -> Column:
        """Times of the samples, from 0 [s]."""
        return np.asarray(np.arange(self.rows) * self.step_s, np.float64)

    @property
    def duration_s(self) -> float:
        """Time from the first sample to the last [s]."""
        return (self.rows - 1) * self.step_s

    @property
    def released(self) -> bool:
        """Whether the structure is released and the base rests."""
        return self.base_m_s2 is None

    @property
    def largest_m(self) -> float:
        """Largest |displacement| [m]."""
        return float(np.abs(self.displacement_m).max())


@dataclass(frozen=True)
class HistoryQuestion(Sought):
    """The definition of a fit: a measured time history, known values, and the parameters to estimate.

    Parameters
    ----------
    measured : History
        The measured time history.
    known : mapping of float
        Known values of the prototype, by the names of `KNOWN`.
    free : tuple of Free
        Parameters to estimate; `RELEASE` is last if the structure is released.
    particle : bool
        Whether the prototype has a particle.
    contact : Contact
        The model of an impact.
    confidence : float
        Confidence of the intervals.
    seed : int
        Seed of all random draws.
    """

    measured: History
    known: Mapping[str, float]
    free: tuple[Free, ...]
    particle: bool = True
    contact: Contact = INSTANT
    confidence: float = 0.95
    seed: int = 0

    @property
    def frequency_hz(self) -> float:
        """The natural frequency [Hz], or the middle of the range of natural frequencies."""
        middle = np.full(len(self.free), 0.5)
        return self.given(self.values(middle))["natural_frequency_hz"]
