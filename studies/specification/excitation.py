"""The excitations of a structure: over a band and a range of amplitudes, or by records at several scales."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.amplitudes import CONSTANT
from damperlab.studies.ground.generated import Recipe
from damperlab.studies.ground.motion import GroundMotion
from damperlab.studies.ground.source import RecordSource

Numbers = TypeVar("Numbers", float, NDArray[np.float64])
"""A number, or an array of numbers."""
ONCE = (1.0,)
"""Placeholder for the frequency axis of the response to a record."""


@dataclass(frozen=True)
class Motion:
    """The quantity whose amplitude is constant over frequency: a motion of the base, or a force on the structure.

    Parameters
    ----------
    key : str
        Name in the specification.
    unit, words : str
        Unit of the quantity, and its name in sentences.
    constant : str or None
        The key of this quantity in `damperlab.studies.amplitudes.CONSTANT`; None for a displacement or a force.
    force : bool
        Whether the quantity is a force on the structure, with a fixed base.
    """

    key: str
    unit: str
    words: str
    constant: str | None = None
    force: bool = False

    @property
    def order(self) -> int:
        """Order of the quantity as a derivative of the displacement: 0, 1 or 2."""
        return 0 if self.constant is None else CONSTANT[self.constant]


MOTIONS = {
    each.key: each
    for each in (
        Motion("base_amplitude_m", "m", "base amplitude"),
        Motion("base_velocity_m_per_s", "m/s", "base velocity", "velocity"),
        Motion("base_acceleration_m_per_s2", "m/s²", "base acceleration", "acceleration"),
        Motion("force_n", "N", "force amplitude", force=True),
    )
}
"""Quantities, one of which is constant over the band of an excitation. Each quantity is given as an
amplitude, not as an rms value.
"""


@dataclass(frozen=True)
class Excitation:
    """Motion of the base, or a force, at every frequency of the band and with every amplitude of the range.

    Parameters
    ----------
    lowest_m, highest_m : float
        Base amplitude Z at the nominal natural frequency, or the static displacement F₀/k of a force on the nominal
        structure. Both are equal for a single amplitude.
    low, high : float
        Ends of the band, as frequency ratios of the nominal structure. Both are equal for a single frequency.
    motion : Motion
        The quantity that is constant over the band.
    name : str
        Name of the excitation, if there are several.
    """

    lowest_m: float
    highest_m: float
    low: float
    high: float
    motion: Motion = MOTIONS["base_amplitude_m"]
    name: str = ""

    def base_m(self, reference_m: float, frequency_ratio: Numbers) -> Numbers:
        """Return the base amplitude Z [m] at frequency ratios of the nominal structure. At ratio 1, Z is `reference_m`.

        A velocity V gives Z = V/ω, an acceleration A gives Z = A/ω², and a force F₀ gives Z = F₀/k.
        """
        return reference_m / frequency_ratio**self.motion.order

    def over(self, length_m: float) -> "Excitation":
        """Return the same excitation with the amplitudes divided by a length."""
        return replace(self, lowest_m=self.lowest_m / length_m, highest_m=self.highest_m / length_m)

    @property
    def largest(self) -> "Amplitude":
        """The largest amplitude of the excitation."""
        return Amplitude(self, self.highest_m)

    def amplitudes(self, count: int) -> tuple["Amplitude", ...]:
        """Return `count` amplitudes in geometric progression over the range. Equal ends give one amplitude."""
        low, high = self.lowest_m, self.highest_m
        if low == high:
            return (self.largest,)
        inner = (low * (high / low) ** (k / (count - 1)) for k in range(1, count - 1))
        return tuple(Amplitude(self, each) for each in (low, *inner, high))


@dataclass(frozen=True)
class Amplitude:
    """One amplitude of an excitation over the band.

    Parameters
    ----------
    excitation : Excitation
        The excitation.
    reference_m : float
        Base amplitude Z at the nominal natural frequency, or static displacement.
    """

    excitation: Excitation
    reference_m: float

    def base_m(self, frequency_ratio: Numbers) -> Numbers:
        """Return the base amplitude Z [m] at frequency ratios of the nominal structure."""
        return self.excitation.base_m(self.reference_m, frequency_ratio)


@dataclass(frozen=True)
class Case:
    """One record at one scale.

    Parameters
    ----------
    source : RecordSource
        The record.
    scale : float
        Factor on the record.
    """

    source: RecordSource
    scale: float

    @property
    def name(self) -> str:
        """Name in a sentence."""
        return f"{self.source.called} × {self.scale:g}"


@dataclass(frozen=True)
class RecordCases:
    """One excitation of a specification that consists of records, each at several scales.

    The worst combination of record and scale determines the result.

    Parameters
    ----------
    sources : tuple of RecordSource
        Records in ascending order of id.
    scales : tuple of float
        Factors on the records, ascending.
    tail_s : float
        Free vibration after every record [s].
    motions : mapping of GroundMotion
        Samples of each record by id, if available.
    name : str
        Name that distinguishes this excitation from other excitations.
    """

    sources: tuple[RecordSource, ...]
    scales: tuple[float, ...]
    tail_s: float
    motions: Mapping[str, GroundMotion] = field(default_factory=dict, compare=False, repr=False)
    name: str = ""

    @property
    def cases(self) -> tuple[Case, ...]:
        """The cases of the excitation: every combination of a record and a scale."""
        return tuple(Case(source, scale) for source in self.sources for scale in self.scales)

    @property
    def alone(self) -> Recipe | None:
        """The recipe of a single generated record; None for several records or a stored record."""
        return self.sources[0].generated if len(self.sources) == 1 else None

    @property
    def nouns(self) -> tuple[str, ...]:
        """Noun for each record in sentences, for example ``ground-motion record``."""
        every = [source.generated for source in self.sources]
        return tuple("ground-motion record" if each is None else each.noun for each in every)


Under = Amplitude | Case
"""The condition under which a damper is evaluated: one amplitude over a band, or one record at one scale."""
