"""A question to a time history: known values of the prototype, and the parameters to estimate."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.choices import Contact, InstantContact
from damperlab.studies.fit.history.history import History
from damperlab.studies.fit.question import NAMED, Free, drop
from damperlab.studies.variables import BEFORE

OVER_BASE = ("base_amplitude_m", "clearance_ratio", "friction_ratio", *BEFORE)
"""Quantities without meaning unless the base has a harmonic amplitude."""
KNOWN: tuple[str, ...] = tuple(name for name in NAMED if name not in OVER_BASE)
"""Values of a prototype that may be known."""
FREE: tuple[str, ...] = tuple(name for name in KNOWN if name != "mass_kg")
"""Parameters that may be estimated."""
INSTANT = InstantContact()
RELEASE = "initial_displacement_m"
"""Position of the release. It is estimated too, since the first sample is as noisy as the others."""


@dataclass(frozen=True)
class HistoryQuestion:
    """A time history, and the question to it.

    Parameters
    ----------
    measured : History
        The displacements.
    known : mapping of float
        Known values of the prototype, by the names of `KNOWN`.
    free : tuple of Free
        Parameters to estimate; `RELEASE` is last if the structure is released.
    particle : bool
        Whether the prototype has a particle.
    contact : Contact
        The model of an impact.
    confidence : float
        Of the intervals.
    seed : int
        Of all draws.
    """

    measured: History
    known: Mapping[str, float]
    free: tuple[Free, ...]
    particle: bool = True
    contact: Contact = INSTANT
    confidence: float = 0.95
    seed: int = 0

    def values(self, shares: NDArray[np.float64]) -> dict[str, float]:
        """Give the parameters at given fractions of their ranges, each from 0 to 1."""
        return {each.name: float(each.values(share)) for each, share in zip(self.free, shares, strict=True)}

    def given(self, values: Mapping[str, float]) -> dict[str, float]:
        """Combine known and estimated values; the latter take precedence."""
        found = dict(self.known)
        for name, value in values.items():
            drop(found, name)
            found[name] = value
        return found

    @property
    def frequency_hz(self) -> float:
        """The natural frequency, or the middle of its range [Hz]."""
        middle = np.full(len(self.free), 0.5)
        return self.given(self.values(middle))["natural_frequency_hz"]
