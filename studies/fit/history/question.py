"""The definition of a fit of a time history: known values of the prototype, and the parameters to estimate."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from damperlab.studies.choices import Contact, InstantContact
from damperlab.studies.fit.history.history import History
from damperlab.studies.fit.question import NAMED, Free, Sought
from damperlab.studies.variables import BEFORE

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
