"""A specification as validated data: structure, excitation, ranges, limits, tolerances, measure, budget."""

import hashlib
import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from damperlab.studies.specification.excitation import Amplitude, Case, Excitation, Motion, RecordCases, Under
from damperlab.studies.specification.measure import (
    EVERY_LIMIT,
    LIMITS,
    MEASURES,
    RECORD_MEASURES,
    Measure,
)
from damperlab.studies.variables import MADE_BY

CHOSEN = ("clearance_m", "friction_force_n", "particle_mass_kg", "restitution")
"""Quantities of a damper, in a fixed order."""
RATIO_OF = {
    "clearance_m": "clearance_ratio",
    "friction_force_n": "friction_ratio",
    "particle_mass_kg": "mass_ratio",
    "restitution": "restitution",
}
"""For each quantity of the damper, the corresponding dimension of a study."""
STARTS = 12
"""Number of initial states of one damper, including rest."""
JUDGES = {
    "rest": "the response from rest",
    "worst": f"the largest response from {STARTS} starts",
    "likely": f"the response that most of {STARTS} starts lead to",
}
"""Rules for excitations over a band: which response counts if a damper has several responses."""
OF_STRUCTURE = ("mass_kg", "natural_frequency_hz", "damping_ratio")
"""Quantities of the structure that may have tolerances, which are stored as relative tolerances."""
OF_DAMPER = (*CHOSEN, *MADE_BY.values())
"""Quantities of a damper, including the optional friction coefficient and tilt of the cavity."""


@dataclass(frozen=True)
class Structure:
    """The structure.

    Parameters
    ----------
    mass_kg, natural_frequency_hz : float
        Mass M and natural frequency ω_n/2π. In a specification in ratios, M = 1 kg and ω_n = 1 rad/s, so that
        k = 1 N/m.
    damping_ratio : float
        Damping ratio ζ.
    stiffness_given, dashpot_given : bool
        Whether k was given instead of ω_n, and c instead of ζ. A tolerance of the mass leaves given k and c unchanged.
    """

    mass_kg: float
    natural_frequency_hz: float
    damping_ratio: float
    stiffness_given: bool = False
    dashpot_given: bool = False

    @property
    def angular_frequency(self) -> float:
        """ω_n [rad/s]."""
        return 2.0 * math.pi * self.natural_frequency_hz

    @property
    def stiffness_n_per_m(self) -> float:
        """k = M ω_n²."""
        return self.mass_kg * self.angular_frequency**2

    def built_off(self, mass: Any, frequency: Any, damping: Any) -> tuple[Any, Any]:
        """Return the relative deviations of ω_n and ζ of the structure as built.

        Parameters
        ----------
        mass, frequency, damping : float or ndarray
            Relative deviations within the tolerances. If the stiffness is given, the tolerance of the frequency refers
            to √k. If the dashpot is given, the tolerance of the damping refers to c.
        """
        shift = (1.0 + frequency) / np.sqrt(1.0 + mass) - 1.0 if self.stiffness_given else frequency
        if self.dashpot_given:
            damping = (1.0 + damping) / ((1.0 + mass) * (1.0 + shift)) - 1.0
        return shift, damping

    def per_metre(self, motion: Motion) -> float:
        """Return the factor that converts a length to the amplitude of a motion or a force.

        For a motion, the length is the base amplitude at ω_n; for a force, it is the static displacement.
        """
        return self.stiffness_n_per_m if motion.force else float(self.angular_frequency**motion.order)

    def reference(self, unit: str, amplitude_m: float) -> float:
        """Return the quantity with a given unit to which ratios refer, for the largest base amplitude Z."""
        omega = self.angular_frequency
        return {
            "1": 1.0,
            "m": amplitude_m,
            "m/s": omega * amplitude_m,
            "m/s²": omega**2 * amplitude_m,
            "N": self.stiffness_n_per_m * amplitude_m,
            "kg": self.mass_kg,
        }[unit]


@dataclass(frozen=True)
class Choice:
    """The allowed values of one quantity of the damper.

    Parameters
    ----------
    start, stop : float
        Ends of the range, in the unit that the name of the quantity states. The ends of a fixed quantity are equal.
    values : tuple of float
        The allowed values of a list, ascending; empty for a range.
    names : tuple of str
        Names of the values, for example materials; empty without names.
    contact_times_s : tuple of float
        For a restitution, the contact time [s] of each value of a list, or one contact time for all values. Empty if
        impacts take no time. Two values of a list may be equal if their contact times differ.
    """

    start: float
    stop: float
    values: tuple[float, ...] = ()
    names: tuple[str, ...] = ()
    contact_times_s: tuple[float, ...] = ()

    @property
    def free(self) -> bool:
        """Whether there is more than one allowed value."""
        return self.stop > self.start or len(self.values) > 1

    @property
    def logarithmic(self) -> bool:
        """Whether the range is divided logarithmically. Such a range excludes 0 and spans two octaves or more."""
        return not self.values and self.start > 0 and self.stop >= 4 * self.start

    def at(self, share: float) -> float:
        """Return the value at a fraction of the range, from 0 to 1. For a list, return the nearest listed value."""
        if self.values:
            return self.values[self._place(share)]
        if share in (0.0, 1.0):
            return self.stop if share else self.start
        if self.logarithmic:
            return self.start * math.exp(share * math.log(self.stop / self.start))
        return self.start + share * (self.stop - self.start)

    def contact_time_s(self, share: float) -> float:
        """Return the contact time [s] at a fraction of the range; 0 if impacts take no time."""
        if len(self.contact_times_s) > 1:
            return self.contact_times_s[self._place(share)]
        return next(iter(self.contact_times_s), 0.0)

    def called(self, value: float, contact_time_s: float) -> str:
        """Return the name of the listed pair of a value and a contact time; empty if the pair has no name."""
        times = (
            self.contact_times_s if len(self.contact_times_s) > 1 else (contact_time_s,) * len(self.values)
        )
        each = zip(self.names, self.values, times, strict=False)
        return next((name for name, *known in each if known == [value, contact_time_s]), "")

    def _place(self, share: float) -> int:
        """Return the index nearest to a fraction: 0 is the first of `values`, and 1 the last."""
        return round(share * (len(self.values) - 1))


def beside_rubbing(in_units: bool, choices: Mapping[str, Choice]) -> dict[str, bool]:
    """Return which features of `NOT_WITH_RUBBING` a specification has."""
    return {
        "ratios": not in_units,
        "contact": any(choices["restitution"].contact_times_s),
    }


@dataclass(frozen=True)
class Tolerance:
    """A symmetric tolerance.

    Parameters
    ----------
    size : float
        Size in the unit of the quantity, or relative to the value of the quantity.
    relative : bool
        Whether the size is relative.
    """

    size: float
    relative: bool

    def of(self, value: float) -> float:
        """Return the tolerance of a value, in the unit of the value."""
        return self.size * value if self.relative else self.size

    def most(self, limit: float) -> float:
        """Return the largest value that, with its tolerance, stays within a limit.

        The result is 0 or negative if no positive value stays within the limit.
        """
        return limit / (1.0 + self.size) if self.relative else limit - self.size


@dataclass(frozen=True)
class Specification:
    """The requirements of a damper, and the allowed values of its parameters.

    Parameters
    ----------
    name : str
        Free text.
    structure : Structure
        The structure.
    excitations : tuple of Excitation
        Excitations over bands, applied one at a time. The worst excitation determines the result. Empty if all
        excitations are records.
    choices : dict of Choice
        Allowed values of every quantity in `OF_DAMPER`. Including tolerances, all values are within
        `damper_limits`.
    limits : dict of float
        Limits on results. The keys are names of `LIMITS`, which also gives the units.
    damper_limits : dict of float
        Limits on the damper as built. The keys are names of `DAMPER_LIMITS`, which also gives the units.
    bounds : dict of str
        Name of the limit that shortened the range of a quantity, by quantity.
    tolerances : dict of Tolerance
        Tolerances. The keys are names of `OF_DAMPER` and `OF_STRUCTURE`. Exact quantities have no entry.
    measure : Measure
        The measure to minimise.
    judge : str
        Rule for excitations over a band, one of `JUDGES`: which response counts if a damper has several responses.
    confidence : float
        Confidence level of errors and intervals.
    budget_points : int or None
        Largest number of points; None for the number expected within `budget_minutes`.
    budget_minutes : float
        Budget of computing time, in minutes of one core.
    builds : int
        Number of builds drawn within the tolerances.
    in_units : bool
        Whether lengths, forces and masses are in SI units instead of ratios.
    document : dict
        The document as given, with a hash of the samples added to each record.
    records : tuple of RecordCases
        Excitations by ground-motion records and sweeps, in addition to `excitations` or instead of them.
    """

    name: str
    structure: Structure
    excitations: tuple[Excitation, ...]
    choices: dict[str, Choice]
    limits: dict[str, float]
    damper_limits: dict[str, float]
    bounds: dict[str, str]
    tolerances: dict[str, Tolerance]
    measure: Measure
    judge: str
    confidence: float
    budget_points: int | None
    budget_minutes: float
    builds: int
    in_units: bool
    document: dict[str, Any]
    records: tuple[RecordCases, ...] = ()

    @property
    def budget_key(self) -> str:
        """Name of the field with the budget."""
        return "budget_minutes" if self.budget_points is None else "budget_points"

    @property
    def free(self) -> tuple[str, ...]:
        """Quantities of the damper that have more than one allowed value."""
        return tuple(name for name in OF_DAMPER if self.choices[name].free)

    @property
    def rubs(self) -> bool:
        """Whether friction or gravity acts on the particle of any allowed damper."""
        return any(self.choices[name].stop > 0.0 or name in self.tolerances for name in MADE_BY.values())

    @property
    def toleranced(self) -> list[str]:
        """Quantities with a tolerance, in a fixed order."""
        return [name for name in (*CHOSEN, *OF_STRUCTURE, *MADE_BY.values()) if name in self.tolerances]

    @property
    def cases(self) -> tuple[Case, ...]:
        """The cases of all excitations that consist of records: every combination of a record and a scale."""
        return tuple(case for records in self.records for case in records.cases)

    def records_of(self, case: Case) -> RecordCases:
        """Return the excitation to which a case belongs. No record is in two excitations."""
        return next(each for each in self.records if case.source in each.sources)

    def measured(self, under: Under) -> Measure:
        """Return the measure under a condition. A condition is an amplitude over a band, or a record at a scale."""
        return (RECORD_MEASURES if isinstance(under, Case) else MEASURES)[self.measure.name]

    def limit_key(self, limit: str) -> str:
        """Return the name of a limit in the document.

        If the specification is in ratios, the result is the name of the limit as a ratio.
        """
        return limit if self.in_units else EVERY_LIMIT[limit].ratio

    def as_limited(self, limit: str, value: float) -> float:
        """Convert a value to the form of a limit in the document: in the unit of the limit, or as a ratio."""
        if self.in_units:
            return value
        return value / self.structure.reference(EVERY_LIMIT[limit].unit, self.largest_m)

    def limited(self, limit: str, under: Under) -> tuple[str, ...]:
        """Return the variables whose product must stay within a limit.

        Empty if the limit does not apply under this condition.
        """
        about = LIMITS[limit]
        if isinstance(under, Case):
            return (about.under_record,) if about.under_record else ()
        return about.over_band

    @property
    def limited_at_all(self) -> bool:
        """Whether there is any limit, on results or on the damper itself."""
        return bool(self.limits or self.damper_limits)

    @property
    def limits_measure(self) -> bool:
        """Whether the measure itself has a limit."""
        return self.measure.limit in self.limits

    @property
    def unit(self) -> str:
        """The unit of the measure; 1 for a specification in ratios."""
        return self.measure.unit if self.in_units else "1"

    @property
    def largest_m(self) -> float:
        """Reference length of ratios: the largest base amplitude at the nominal ω_n, or the largest static displacement."""
        return max(each.highest_m for each in self.excitations)

    def level(self, amplitude: Amplitude) -> float:
        """Return the amplitude of the quantity that is constant over the band, in the unit of this quantity."""
        return amplitude.reference_m * self.structure.per_metre(amplitude.excitation.motion)

    @cached_property
    def digest(self) -> str:
        """SHA-256 hash of the document without the name, 64 hexadecimal digits."""
        asked = {key: value for key, value in self.document.items() if key != "name"}
        return hashlib.sha256(json.dumps(asked, sort_keys=True).encode()).hexdigest()
