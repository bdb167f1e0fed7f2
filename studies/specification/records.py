"""Transient excitations: records, stored or generated, each at several scales."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from damperlab.studies.ground.generated import Recipe
from damperlab.studies.ground.motion import GroundMotion
from damperlab.studies.ground.source import RecordSource
from damperlab.studies.specification.excitation import Amplitude

ONCE = (1.0,)
"""Placeholder for the frequency axis of the response to a record."""


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
    """Records with their scales: one excitation of a specification.

    The result is that of the worst combination of record and scale.

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
        """Every record at every scale."""
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
