"""A design as stored: the specification, the studies that the search waits for, and how the design ended."""

from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Annotated, Any, NotRequired

from typing_extensions import TypedDict

from damperlab.studies.design.build import Built
from damperlab.studies.shapes import Count, Number, Says
from damperlab.studies.vocabulary import State


class Where(TypedDict):
    """Condition of a worst case: an excitation with its frequency and amplitude, or a record with its scale."""

    ratio: Number
    frequency_ratio: Number
    frequency_hz: Number
    base_amplitude_m: Number
    excitation: Annotated[str | None, Says(description="Its name, if there are several.")]
    record: NotRequired[
        Annotated[str | None, Says(description="The ground-motion record, of a design under records.")]
    ]
    record_name: NotRequired[
        Annotated[str | None, Says(description="Its name: its id, or the definition it was generated from.")]
    ]
    scale: NotRequired[Number]


class Worst(Where):
    """A worst case with its units, and the condition under which the worst case occurs."""

    measure: str
    value: Number
    error: Number
    units: str


class KnownDesign(TypedDict):
    """A damper, and its worst case without tolerances."""

    design: Built
    worst: Worst
    feasible: bool


class DesignSummary(TypedDict):
    """An entry in the list of designs."""

    id: Annotated[str, Says(description="First 12 hex digits of the digest.")]
    name: str
    state: State
    stage: Annotated[str | None, Says(description="What is computed now, in words.")]
    round: Annotated[Count, Says(description="Rounds of studies begun.")]
    points: Annotated[Count, Says(description="Points known when the round began.")]
    points_wanted: Annotated[Count, Says(description="Points of the round's studies.")]
    budget_points: Annotated[Count, Says(description="Largest number of points.")]
    known: Annotated[
        KnownDesign | None,
        Says(description="The best so far, as drawn; of a completed design the recommended one."),
    ]
    created: str
    started: str | None
    finished: str | None
    message: Annotated[str | None, Says(description="Why it failed, or what it waits for.")]
    digest: str


class KeptDocument(DesignSummary):
    """A design without its answer."""

    studies: Annotated[list[str], Says(description="Ids of the round's studies.")]
    specification: dict[str, Any]


@dataclass(frozen=True)
class Round:
    """The current round of a search.

    Parameters
    ----------
    stage : str
        The purpose of the studies.
    number : int
        Number of rounds so far, including this round.
    points, wanted : int
        Number of known points, and number of points of the studies.
    studies : tuple of str
        Ids of the studies.
    known : dict or None
        The best damper so far with its worst case without tolerances; None before the first dampers are computed.
    started : str
        Time at which the search began, in ISO 8601, UTC.
    message : str or None
        Reason why the search waits; None if the search waits for its studies only.
    """

    stage: str
    number: int
    points: int
    wanted: int
    studies: tuple[str, ...]
    known: KnownDesign | None
    started: str
    message: str | None = None


@dataclass(frozen=True)
class Kept:
    """A design as stored.

    Parameters
    ----------
    id, name, digest : str
        `id` is the first 12 hex digits of the digest, `name` is free text, and `digest` identifies the specification.
    state : str
        One of `STATES`.
    specification : dict
        The specification as given.
    budget_points : int
        Largest number of points.
    created : str
        Time of the request; times are in ISO 8601, UTC.
    finished : str or None
        Time at which the design ended; None before the end.
    message : str or None
        Reason why the design failed or waits.
    owner : str or None
        Owner of the design; None if the service uses no keys.
    round : Round or None
        The latest round.
    """

    id: str
    name: str
    digest: str
    state: State
    specification: dict[str, Any]
    budget_points: int
    created: str
    finished: str | None
    message: str | None
    owner: str | None
    round: Round | None

    @property
    def ended(self) -> bool:
        """Whether the design has ended."""
        return self.finished is not None

    @property
    def place(self) -> str:
        """Sort key of the designs in a folder: the time of the request, and the id."""
        return f"{int(1e6 * datetime.fromisoformat(self.created).timestamp()):020d}-{self.id}"

    def summary(self) -> DesignSummary:
        """Return the entry of this design in a list of designs."""
        at = self.round
        return {
            "id": self.id,
            "name": self.name,
            "state": self.state,
            "stage": None if at is None else at.stage,
            "round": 0 if at is None else at.number,
            "points": 0 if at is None else at.points,
            "points_wanted": 0 if at is None or self.ended else at.wanted,
            "budget_points": self.budget_points,
            "known": None if at is None else at.known,
            "created": self.created,
            "started": None if at is None else at.started,
            "finished": self.finished,
            "message": self.message,
            "digest": self.digest,
        }

    def document(self) -> KeptDocument:
        """Return the design as a JSON document, without the answer."""
        studies = [] if self.round is None else list(self.round.studies)
        return {**self.summary(), "studies": studies, "specification": self.specification}


def now() -> str:
    """Return the current time in ISO 8601, UTC."""
    return datetime.now(UTC).isoformat()
