"""A specification as validated data: structure, excitation, what is chosen, limits, tolerances, measure, budget."""

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
"""What makes a damper, in this order everywhere."""
RATIO_OF = {
    "clearance_m": "clearance_ratio",
    "friction_force_n": "friction_ratio",
    "particle_mass_kg": "mass_ratio",
    "restitution": "restitution",
}
"""The dimension of a study that each of them makes."""
STARTS = 12
"""Starts of one damper, one of them rest."""
JUDGES = {
    "rest": "the response from rest",
    "worst": f"the largest response to {STARTS} starts",
    "likely": f"the response that most of {STARTS} starts lead to",
}
"""Which response over a band counts where there are several."""
OF_STRUCTURE = ("mass_kg", "natural_frequency_hz", "damping_ratio")
"""What else may be off by a tolerance, always a share."""
OF_DAMPER = (*CHOSEN, *MADE_BY.values())
"""What makes a damper, with what acts on its particle between impacts, which may be left out."""


@dataclass(frozen=True)
class Structure:
    """What is to be kept quiet.

    Parameters
    ----------
    mass_kg, natural_frequency_hz : float
        M and ω_n/2π; 1 kg and 1/2π Hz where the specification is in ratios, so that k = 1 N/m.
    damping_ratio : float
        ζ.
    stiffness_given, dashpot_given : bool
        Whether k and c were given in place of ω_n and ζ: a tolerance of the mass then leaves them as they are.
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
        """Give by which shares ω_n and ζ of the structure are off as built.

        Parameters
        ----------
        mass, frequency, damping : float or ndarray
            Shares within the tolerances. Of a given stiffness the tolerance of the frequency is that of √k, of a given dashpot
            that of the damping is that of c.
        """
        shift = (1.0 + frequency) / np.sqrt(1.0 + mass) - 1.0 if self.stiffness_given else frequency
        if self.dashpot_given:
            damping = (1.0 + damping) / ((1.0 + mass) * (1.0 + shift)) - 1.0
        return shift, damping

    def per_metre(self, motion: Motion) -> float:
        """Give what a base amplitude of 1 m at the natural frequency makes of what is constant, or a static displacement."""
        return self.stiffness_n_per_m if motion.force else float(self.angular_frequency**motion.order)


def ratio_unit(limit: str, amplitude_m: float, structure: Structure) -> float:
    """Give what a limit is over where only ratios mean anything, in the limit's unit.

    Parameters
    ----------
    limit : str
        One of `LIMITS` or `DAMPER_LIMITS`.
    amplitude_m : float
        The largest base amplitude Z.
    structure : Structure
        What is kept quiet.
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
    """What one quantity of the damper may be.

    Parameters
    ----------
    start, stop : float
        A range, in the unit of its name; equal where the quantity is given.
    values : tuple of float
        The only values allowed, ascending; empty for a range.
    names : tuple of str
        What the values are called, such as materials; empty without names.
    contact_times_s : tuple of float
        Of a restitution, how long the particle and the wall touch [s]: of each value of a list, or one for all; empty where
        impacts take no time. Two values of a list may be equal where their contact times are not.
    """

    start: float
    stop: float
    values: tuple[float, ...] = ()
    names: tuple[str, ...] = ()
    contact_times_s: tuple[float, ...] = ()

    @property
    def free(self) -> bool:
        """Whether there is anything to choose."""
        return self.stop > self.start or len(self.values) > 1

    @property
    def logarithmic(self) -> bool:
        """Whether steps are shares of the value: over two octaves or more, away from 0."""
        return not self.values and self.start > 0 and self.stop >= 4 * self.start

    def at(self, share: float) -> float:
        """Give the value at a share of the range, from 0 to 1; of a list the nearest."""
        if self.values:
            return self.values[self._place(share)]
        if share in (0.0, 1.0):
            return self.stop if share else self.start
        if self.logarithmic:
            return self.start * math.exp(share * math.log(self.stop / self.start))
        return self.start + share * (self.stop - self.start)

    def contact_time_s(self, share: float) -> float:
        """Give how long particle and wall touch at a share of the range [s]; 0 where impacts take no time."""
        if len(self.contact_times_s) > 1:
            return self.contact_times_s[self._place(share)]
        return next(iter(self.contact_times_s), 0.0)

    def called(self, value: float, contact_time_s: float) -> str:
        """Name a value of a list by itself and how long particle and wall touch; empty where it has no name."""
        times = (
            self.contact_times_s if len(self.contact_times_s) > 1 else (contact_time_s,) * len(self.values)
        )
        each = zip(self.names, self.values, times, strict=False)
        return next((name for name, *known in each if known == [value, contact_time_s]), "")

    def _place(self, share: float) -> int:
        """Give the place in the list that is nearest to a share of it."""
        return round(share * (len(self.values) - 1))


def beside_rubbing(in_units: bool, choices: Mapping[str, Choice]) -> dict[str, bool]:
    """Say which of `consistency.NOT_WITH_RUBBING` a specification has: what friction or gravity is not computed with."""
    return {
        "ratios": not in_units,
        "contact": any(choices["restitution"].contact_times_s),
    }


@dataclass(frozen=True)
class Tolerance:
    """How far what is built may be off, to either side.

    Parameters
    ----------
    size : float
        In the unit of the quantity, or a share of its value.
    relative : bool
        Whether it is a share.
    """

    size: float
    relative: bool

    def of(self, value: float) -> float:
        """Give the tolerance of a value in the value's unit."""
        return self.size * value if self.relative else self.size

    def most(self, limit: float) -> float:
        """Give the largest value that does not exceed a limit by its tolerance; not above 0 where there is none."""
        return limit / (1.0 + self.size) if self.relative else limit - self.size


@dataclass(frozen=True)
class Specification:
    """What a damper shall do, and what it may be made of.

    Parameters
    ----------
    name : str
        Free text.
    structure : Structure
        What is to be kept quiet.
    excitations : tuple of Excitation
        What shakes it over bands, one at a time; the worst of them is judged. Empty where records alone do.
    choices : dict of Choice
        By the names of `OF_DAMPER`, all six; of the values only those whose tolerance keeps the limits on the damper itself.
    limits : dict of float
        Limits on results, by the names of `LIMITS`, in their units.
    damper_limits : dict of float
        Limits on the damper itself as it is built, by the names of `DAMPER_LIMITS`, in their units.
    bounds : dict of str
        Limits that cut a range short at its end: the limit by the quantity.
    tolerances : dict of Tolerance
        By the names of `OF_DAMPER` and `OF_STRUCTURE`; absent where a quantity is exact.
    measure : Measure
        What shall be small.
    judge : str
        Which response over a band counts where there are several: one of `JUDGES`.
    confidence : float
        Of errors and intervals.
    budget_points : int or None
        Most points; None for what `budget_minutes` are expected to hold.
    budget_minutes : float
        Minutes of one core.
    builds : int
        Builds drawn within the tolerances.
    in_units : bool
        Whether lengths, forces and masses mean anything; else only ratios do.
    document : dict
        As it was given; records with the digest of their samples.
    records : tuple of RecordCases
        The ground-motion records and sweeps that shake it, in place of excitations over a band or beside them.
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
        """Name of the field that bounds the search."""
        return "budget_minutes" if self.budget_points is None else "budget_points"

    @property
    def free(self) -> tuple[str, ...]:
        """What is chosen."""
        return tuple(name for name in OF_DAMPER if self.choices[name].free)

    @property
    def rubs(self) -> bool:
        """Whether friction or gravity acts on the particle, with any damper that may be chosen."""
        return any(self.choices[name].stop > 0.0 or name in self.tolerances for name in MADE_BY.values())

    @property
    def toleranced(self) -> list[str]:
        """What has a tolerance, in a fixed order."""
        return [name for name in (*CHOSEN, *OF_STRUCTURE, *MADE_BY.values()) if name in self.tolerances]

    @property
    def cases(self) -> tuple[Case, ...]:
        """Every record at every scale; none where no record shakes it."""
        return tuple(case for records in self.records for case in records.cases)

    def records_of(self, case: Case) -> RecordCases:
        """Give the excitation that a case is of: no record is in two of them."""
        return next(each for each in self.records if case.source in each.sources)

    def measured(self, under: Under) -> Measure:
        """Give the measure as it is made of the results under an amplitude, or under a record."""
        return (RECORD_MEASURES if isinstance(under, Case) else MEASURES)[self.measure.name]

    def limit_key(self, limit: str) -> str:
        """Give what a limit is called in the document: by its ratio where only ratios mean anything."""
        return limit if self.in_units else (LIMITS[limit] if limit in LIMITS else DAMPER_LIMITS[limit]).ratio

    def as_limited(self, limit: str, value: float) -> float:
        """Give a value of what a limit is about as the document has it: in its unit, or as a ratio."""
        return value if self.in_units else value / ratio_unit(limit, self.largest_m, self.structure)

    def limited(self, limit: str, under: Under) -> tuple[str, ...]:
        """Give the variables whose product a limit on results is about; none where the results under this do not tell it."""
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
        """Whether a limit is on what is measured."""
        return self.measure.limit in self.limits

    @property
    def unit(self) -> str:
        """The unit of the measure; 1 where only ratios mean anything."""
        return self.measure.unit if self.in_units else "1"

    @property
    def largest_m(self) -> float:
        """The largest base amplitude Z at the nominal natural frequency, or static displacement, of any excitation; what
        ratios are over."""
        return max(each.highest_m for each in self.excitations)

    def level(self, amplitude: Amplitude) -> float:
        """Give the amplitude of what is constant over the band, in its unit."""
        return amplitude.reference_m * self.structure.per_metre(amplitude.excitation.motion)

    @cached_property
    def digest(self) -> str:
        """SHA-256 of the document as it was given, without its name, in hexadecimal."""
        asked = {key: value for key, value in self.document.items() if key != "name"}
        return hashlib.sha256(json.dumps(asked, sort_keys=True).encode()).hexdigest()
