"""A specification as validated data: structure, excitation, ranges, limits, tolerances, measure, budget."""

import hashlib
import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from damperlab.studies.specification.excitation import Amplitude, Excitation, Motion
from damperlab.studies.specification.measure import (
    DAMPER_LIMITS,
    LIMITS,
    MEASURES,
    RECORD_MEASURES,
    Measure,
)
from damperlab.studies.specification.records import Case, RecordCases, Under
from damperlab.studies.variables import MADE_BY

CHOSEN = ("clearance_m", "friction_force_n", "particle_mass_kg", "restitution")
"""Quantities of a damper, in this order everywhere."""
RATIO_OF = {
    "clearance_m": "clearance_ratio",
    "friction_force_n": "friction_ratio",
    "particle_mass_kg": "mass_ratio",
    "restitution": "restitution",
}
"""The dimension of a study for each quantity of the damper."""
STARTS = 12
"""Number of starts of one damper; one of them is rest."""
JUDGES = {
    "rest": "the response from rest",
    "worst": f"the largest response to {STARTS} starts",
    "likely": f"the response that most of {STARTS} starts lead to",
}
"""Choices of the response over a band if there are several."""
OF_STRUCTURE = ("mass_kg", "natural_frequency_hz", "damping_ratio")
"""Further quantities that may have tolerances, which are always relative."""
OF_DAMPER = (*CHOSEN, *MADE_BY.values())
"""Quantities of a damper, including the optional ones for the forces on its particle between impacts."""


@dataclass(frozen=True)
class Structure:
    """The structure.

    Parameters
    ----------
    mass_kg, natural_frequency_hz : float
        M and ω_n/2π; in a specification in ratios, 1 kg and 1/2π Hz, so that k = 1 N/m.
    damping_ratio : float
        ζ.
    stiffness_given, dashpot_given : bool
        Whether k and c were given instead of ω_n and ζ: a tolerance of the mass then leaves k and c unchanged.
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
        """Give the relative deviations of ω_n and ζ of the structure as built.

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
        """Give the amplitude of the constant quantity that gives a base amplitude of 1 m at the natural frequency, or a
        static displacement of 1 m.
        """
        return self.stiffness_n_per_m if motion.force else float(self.angular_frequency**motion.order)


def ratio_unit(limit: str, amplitude_m: float, structure: Structure) -> float:
    """Give the reference of a limit for a specification in ratios, in the limit's unit.

    Parameters
    ----------
    limit : str
        One of `LIMITS` or `DAMPER_LIMITS`.
    amplitude_m : float
        The largest base amplitude Z.
    structure : Structure
        The structure.
    """
    unit = (LIMITS[limit] if limit in LIMITS else DAMPER_LIMITS[limit]).unit
    omega = structure.angular_frequency
    return {
        "1": 1.0,
        "m": amplitude_m,
        "m/s": omega * amplitude_m,
        "m/s²": omega**2 * amplitude_m,
        "N": structure.stiffness_n_per_m * amplitude_m,
        "kg": structure.mass_kg,
    }[unit]


@dataclass(frozen=True)
class Choice:
    """The allowed values of one quantity of the damper.

    Parameters
    ----------
    start, stop : float
        Ends of the range, in the unit in the name of the quantity; they are equal if the quantity is given.
    values : tuple of float
        The only values allowed, ascending; empty for a range.
    names : tuple of str
        Names of the values, for example materials; empty without names.
    contact_times_s : tuple of float
        For a restitution, the contact time [s] of each value of a list, or one for all values; empty if impacts take no
        time. Two values of a list may be equal if their contact times differ.
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
        """Whether steps are relative to the value: if the range spans two octaves or more and excludes 0."""
        return not self.values and self.start > 0 and self.stop >= 4 * self.start

    def at(self, share: float) -> float:
        """Give the value at a fraction of the range, from 0 to 1; in a list, the nearest value."""
        if self.values:
            return self.values[self._place(share)]
        if share in (0.0, 1.0):
            return self.stop if share else self.start
        if self.logarithmic:
            return self.start * math.exp(share * math.log(self.stop / self.start))
        return self.start + share * (self.stop - self.start)

    def contact_time_s(self, share: float) -> float:
        """Give the contact time at a fraction of the range [s]; 0 if impacts take no time."""
        if len(self.contact_times_s) > 1:
            return self.contact_times_s[self._place(share)]
        return next(iter(self.contact_times_s), 0.0)

    def called(self, value: float, contact_time_s: float) -> str:
        """Give the name of a value in a list, found by the value and its contact time; empty if it has none."""
        times = (
            self.contact_times_s if len(self.contact_times_s) > 1 else (contact_time_s,) * len(self.values)
        )
        each = zip(self.names, self.values, times, strict=False)
        return next((name for name, *known in each if known == [value, contact_time_s]), "")

    def _place(self, share: float) -> int:
        """Give the index in the list nearest to a fraction of its length."""
        return round(share * (len(self.values) - 1))


def beside_rubbing(in_units: bool, choices: Mapping[str, Choice]) -> dict[str, bool]:
    """Say which features of a specification exclude friction and gravity, by their names in `NOT_WITH_RUBBING`."""
    return {
        "ratios": not in_units,
        "contact": any(choices["restitution"].contact_times_s),
    }


@dataclass(frozen=True)
class Tolerance:
    """A tolerance, to either side.

    Parameters
    ----------
    size : float
        In the unit of the quantity, or relative to its value.
    relative : bool
        Whether it is relative.
    """

    size: float
    relative: bool

    def of(self, value: float) -> float:
        """Give the tolerance of a value in the value's unit."""
        return self.size * value if self.relative else self.size

    def most(self, limit: float) -> float:
        """Give the largest value that, with its tolerance, stays within a limit; at most 0 if there is none."""
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
        Excitations over bands, applied one by one; the worst is judged. Empty if there are only records.
    choices : dict of Choice
        Every quantity in `OF_DAMPER`, restricted to the values that, with their tolerance, stay within the limits on
        the damper itself.
    limits : dict of float
        Limits on results, by the names of `LIMITS`, in their units.
    damper_limits : dict of float
        Limits on the damper itself as it is built, by the names of `DAMPER_LIMITS`, in their units.
    bounds : dict of str
        Limits that shortened a range at its end, by quantity.
    tolerances : dict of Tolerance
        By the names of `OF_DAMPER` and `OF_STRUCTURE`; absent if a quantity is exact.
    measure : Measure
        The measure to minimise.
    judge : str
        Which response over a band is judged if there are several: one of `JUDGES`.
    confidence : float
        Confidence of errors and intervals.
    budget_points : int or None
        Largest number of points; None for the number expected within `budget_minutes`.
    budget_minutes : float
        Minutes of one core.
    builds : int
        Number of builds drawn within the tolerances.
    in_units : bool
        Whether lengths, forces and masses are in units; else all are ratios.
    document : dict
        The document as given; records with the digest of their samples.
    records : tuple of RecordCases
        The ground-motion records and sweeps, instead of excitations over a band or together with them.
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
        """The quantities that are chosen."""
        return tuple(name for name in OF_DAMPER if self.choices[name].free)

    @property
    def rubs(self) -> bool:
        """Whether friction or gravity acts on the particle, for any allowed damper."""
        return any(self.choices[name].stop > 0.0 or name in self.tolerances for name in MADE_BY.values())

    @property
    def toleranced(self) -> list[str]:
        """Quantities with a tolerance, in a fixed order."""
        return [name for name in (*CHOSEN, *OF_STRUCTURE, *MADE_BY.values()) if name in self.tolerances]

    @property
    def cases(self) -> tuple[Case, ...]:
        """Every record at every scale; empty without records."""
        return tuple(case for records in self.records for case in records.cases)

    def records_of(self, case: Case) -> RecordCases:
        """Give the excitation to which a case belongs; no record is in two excitations."""
        return next(each for each in self.records if case.source in each.sources)

    def measured(self, under: Under) -> Measure:
        """Give the measure for the results under an amplitude, or under a record."""
        return (RECORD_MEASURES if isinstance(under, Case) else MEASURES)[self.measure.name]

    def limit_key(self, limit: str) -> str:
        """Give the name of a limit in the document; in a specification in ratios, the name of its ratio."""
        return limit if self.in_units else (LIMITS[limit] if limit in LIMITS else DAMPER_LIMITS[limit]).ratio

    def as_limited(self, limit: str, value: float) -> float:
        """Give a value of a limited quantity as in the document: in its unit, or as a ratio."""
        return value if self.in_units else value / ratio_unit(limit, self.largest_m, self.structure)

    def limited(self, limit: str, under: Under) -> tuple[str, ...]:
        """Give the variables whose product a limit on results restricts; empty if the results under this condition
        do not determine it.
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
        """Whether a limit is on the measure itself."""
        return self.measure.limit in self.limits

    @property
    def unit(self) -> str:
        """The unit of the measure; 1 for a specification in ratios."""
        return self.measure.unit if self.in_units else "1"

    @property
    def largest_m(self) -> float:
        """The largest base amplitude Z at the nominal natural frequency, or static displacement, of any excitation;
        the reference of ratios.
        """
        return max(each.highest_m for each in self.excitations)

    def level(self, amplitude: Amplitude) -> float:
        """Give the amplitude of the constant quantity, in its unit."""
        return amplitude.reference_m * self.structure.per_metre(amplitude.excitation.motion)

    @cached_property
    def digest(self) -> str:
        """SHA-256 of the document as given, without its name, in hexadecimal."""
        asked = {key: value for key, value in self.document.items() if key != "name"}
        return hashlib.sha256(json.dumps(asked, sort_keys=True).encode()).hexdigest()
