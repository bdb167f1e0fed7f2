"""Transient excitations: records, stored or generated, each at several scales."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from damperlab.studies.ground.generated import Recipe
from damperlab.studies.ground.motion import GroundMotion
from damperlab.studies.ground.source import RecordSource
from damperlab.studies.specification.excitation import Amplitude

ONCE = (1.0,)
"""The frequencies of a case: a record has one response and no frequency, so its response has a single point."""


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
    """Records with their scales, one excitation of a specification; the worst pair is judged.

    Parameters
    ----------
    sources : tuple of RecordSource
        By id, ascending.
    scales : tuple of float
        Ascending.
    tail_s : float
        Free vibration after every record [s].
    motions : mapping of GroundMotion
        Samples by id, if available.
    name : str
        Name among other excitations.
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
        """The definition of the record, if it is the only one and describes the base motion."""
        return self.sources[0].generated if len(self.sources) == 1 else None

    @property
    def nouns(self) -> tuple[str, ...]:
        """Kind of each record."""
        every = [source.generated for source in self.sources]
        return tuple("ground-motion record" if each is None else each.noun for each in every)


Under = Amplitude | Case
"""A condition for judging a damper: an amplitude over its band, or a record."""
