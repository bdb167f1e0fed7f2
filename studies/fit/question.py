"""The definition of a fit of a frequency response: known values of the prototype, and the parameters to estimate."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.definition import Study, parse_harmonic
from damperlab.studies.fit.columns import CONDITIONS
from damperlab.studies.fit.measured import Measurement
from damperlab.studies.physical import DERIVATIONS, EXCITATION_FREQUENCY, QUANTITIES
from damperlab.studies.portable import power
from damperlab.studies.quantity import QUANTITY_OF, Quantity
from damperlab.studies.variables import BEFORE
from damperlab.studies.vocabulary import OF_PARTICLE

RATIO_OF = {each.source: each.ratio for each in DERIVATIONS.values()}
"""Ratio that each quantity in SI units determines."""
NAMED: dict[str, Quantity] = {
    name: each for name, each in QUANTITY_OF.items() if name != "frequency_ratio"
} | {each.name: each for each in QUANTITIES if each is not EXCITATION_FREQUENCY}
"""Every quantity of a prototype whose value may be known, by name."""
FREE: tuple[str, ...] = (*(name for name in NAMED if name not in ("mass_kg", "base_amplitude_m")),)
"""Parameters that may be estimated. Mass and base amplitude are excluded: the other quantities are estimated
relative to them.
"""
BESIDE_AXES = ("damping_ratio", *BEFORE)
"""Ratios that a study states as keys of their own, instead of in `axes`."""
METRICS = ("amplitude_ratio", "amplitude_error", "impacts_per_cycle", "stick_fraction", "response_class")
"""Results computed for each measured row."""

WIDE = 10.0
"""Smallest ratio of the ends of a range that is searched on a logarithmic scale."""


@dataclass(frozen=True)
class Free:
    """A parameter to estimate.

    Parameters
    ----------
    name : str
        Name in a study: a ratio, or a quantity in SI units.
    low, high : float
        Ends of the range that is searched.
    """

    name: str
    low: float
    high: float

    @property
    def logarithmic(self) -> bool:
        """Whether the range is searched on a logarithmic scale."""
        return self.low > 0.0 and self.high >= WIDE * self.low

    def values(self, shares: NDArray[np.float64]) -> NDArray[np.float64]:
        """Convert fractions of the range, 0 at the low end and 1 at the high end, into values."""
        if self.logarithmic:
            return np.asarray(self.low * power(self.high / self.low, shares))
        return np.asarray(self.low + (self.high - self.low) * shares)


class Sought:
    """Base class of the definitions of a fit, with known values and parameters to estimate."""

    known: Mapping[str, float]
    free: tuple[Free, ...]

    def values(self, shares: NDArray[np.float64]) -> dict[str, float]:
        """Return the values of the parameters at given fractions of the ranges, from 0 to 1."""
        return {each.name: float(each.values(share)) for each, share in zip(self.free, shares, strict=True)}

    def given(self, *found: Mapping[str, float]) -> dict[str, float]:
        """Return the known values, overridden by each mapping of `found` in turn."""
        given = dict(self.known)
        for more in found:
            for name, value in more.items():
                drop(given, name)
                given[name] = value
        return given


@dataclass(frozen=True)
class FitQuestion(Sought):
    """The definition of a fit: a measured frequency response, known values, and the parameters to estimate.

    Parameters
    ----------
    measured : Measurement
        The measured frequency response.
    known : mapping of float
        Known values of the prototype. The keys are names of `NAMED`, as in a study.
    free : tuple of Free
        Parameters to estimate.
    settings : mapping
        The entries `name`, `particle`, `contact`, `start` and `steady` of the study that computes a response.
    share : float, optional
        Standard deviation of each amplitude as a share of the amplitude, if the measurement states none. Without any
        given deviation, the deviation is estimated from the scatter.
    confidence : float
        Confidence of the intervals.
    seed : int
        Seed of all random draws.
    """

    measured: Measurement
    known: Mapping[str, float]
    free: tuple[Free, ...]
    settings: Mapping[str, Any] = field(default_factory=dict)
    share: float | None = None
    confidence: float = 0.95
    seed: int = 0

    @property
    def in_shares(self) -> bool:
        """Whether standard deviations are relative to the amplitudes, so that logarithms of amplitudes are compared."""
        return self.measured.deviation is None

    @property
    def deviation(self) -> NDArray[np.float64] | None:
        """Standard deviation of each amplitude in the unit of the amplitude; None if estimated from the scatter."""
        if self.measured.deviation is not None:
            return self.measured.deviation
        return None if self.share is None else self.share * self.measured.amplitude

    @cached_property
    def configurations(self) -> tuple[tuple[dict[str, float], NDArray[np.intp]], ...]:
        """Every set of conditions, with the indices of the rows that were measured under these conditions."""
        columns = {name: self.measured.columns[name] for name in CONDITIONS if name in self.measured.columns}
        found: dict[tuple[float | None, ...], list[int]] = {}
        for row in range(self.measured.rows):
            cells = (float(column[row]) for column in columns.values())
            key = tuple(None if math.isnan(cell) else cell for cell in cells)
            found.setdefault(key, []).append(row)
        return tuple(
            (
                {name: value for name, value in zip(columns, key, strict=True) if value is not None},
                np.array(rows),
            )
            for key, rows in found.items()
        )

    def study(self, given: Mapping[str, float], frequencies: list[float]) -> Study:
        """Make the study of one configuration.

        Parameters
        ----------
        given : mapping of float
            Values of the prototype, as returned by the method `given`.
        frequencies : list of float
            Frequency ratios.

        Raises
        ------
        StudyFaults
            If the definition is invalid. The exception contains all faults.
        """
        return parse_harmonic(self.document(given, frequencies) | {"metrics": list(METRICS)})

    def document(self, given: Mapping[str, float], frequencies: Any) -> dict[str, Any]:
        """Write the study of one configuration. `given` may contain axes instead of numbers."""
        return study_document(self.settings, given, frequencies)

    def ratios(self, given: Mapping[str, float], rows: NDArray[np.intp]) -> NDArray[np.float64]:
        """Return the frequency ratios of some rows."""
        frequency = self.measured.frequency[rows]
        return frequency / given["natural_frequency_hz"] if self.measured.in_hertz else frequency

    def scale(self, given: Mapping[str, float]) -> float:
        """Return the factor that converts an amplitude ratio into the unit of the measured amplitudes."""
        return given["base_amplitude_m"] if self.measured.in_metres else 1.0


def drop(numbers: dict[str, Any], name: str) -> None:
    """Remove every form of the quantity `name`: the ratio, and all quantities that determine this ratio."""
    ratio = RATIO_OF.get(name, name)
    for other in [other for other in numbers if RATIO_OF.get(other, other) == ratio]:
        del numbers[other]


def study_document(
    settings: Mapping[str, Any], given: Mapping[str, float], frequencies: Any
) -> dict[str, Any]:
    """Return the definition of a study that computes a prototype.

    Parameters
    ----------
    settings : mapping
        Settings that are not numbers: `particle`, `contact`, …
    given : mapping of float
        Values of the prototype. The keys are names of `NAMED`; axes may replace numbers.
    frequencies : object
        The axis of frequency ratios.
    """
    beside = {name: value for name, value in given.items() if name in BESIDE_AXES}
    axes = {name: value for name, value in given.items() if name in QUANTITY_OF and name not in beside}
    physical = {name: value for name, value in given.items() if name not in QUANTITY_OF}
    if not settings.get("particle", True):
        for part in (axes, physical):
            for name in [name for name in part if RATIO_OF.get(name, name) in OF_PARTICLE]:
                del part[name]
    document: dict[str, Any] = {**settings, **beside, "axes": {**axes, "frequency_ratio": frequencies}}
    if physical:
        document["physical"] = physical
    return document
