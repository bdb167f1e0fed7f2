"""A study in the catalogue, and the result of one block."""

from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Annotated, Any, Literal, get_args

from typing_extensions import TypeAliasType, TypedDict

from damperlab.studies.html import card
from damperlab.studies.shapes import Like, Says
from damperlab.studies.vocabulary import ENDED, State

Preparation = Literal["starting", "compiling", "waiting"]
Phase = Literal[Preparation, State]
PREPARATIONS: tuple[Preparation, ...] = get_args(Preparation)
"""Phases of a running study that computes no block: its workers start, kernels that they lack are compiled, none is left."""

TRASH_DAYS = 7
"""How long a study that was put into the trash can be restored."""


@dataclass(frozen=True)
class Totals:
    """Sums over the studies in one state.

    Parameters
    ----------
    studies, points, points_done, points_failed, bytes : int
        How many; their design points, those stored, those that failed; the cubes at full size.
    blocks_left : int
        Blocks that are not computed.
    """

    studies: int
    points: int
    points_done: int
    points_failed: int
    bytes: int
    blocks_left: int


@dataclass(frozen=True)
class BlockOutcome:
    """What a worker reports about one block once its region is on the disk.

    Parameters
    ----------
    index : int
        Index of the block in its plan.
    points, failed : int
        Points of the block, and how many of them ended with a status of 2 or above.
    seconds, kernel_seconds : float
        Wall time of the whole block, and the part of it spent in kernels [s].
    message : str, optional
        Why the block failed, where it did.
    generation, checksum : str
        Which files are the block's, and what they hold; see `damperlab.studies.store.cube.cube.write_region`.
    reused : int
        Points that were taken from earlier studies.
    identity : str
        What computed it, see `damperlab.studies.store.solver.identity_of`; empty for a block that was given up.
    """

    index: int
    points: int
    failed: int
    seconds: float = 0.0
    kernel_seconds: float = 0.0
    message: str | None = None
    generation: str = ""
    checksum: str | None = None
    reused: int = 0
    identity: str = ""


@dataclass(frozen=True)
class Record:
    """One study in the catalogue at one moment.

    Parameters
    ----------
    id, name, state : str
        The first 12 hex digits of the digest; the study's free text; one of `STATES`.
    phase : str
        One of `PREPARATIONS` while a running study computes no block, else its state.
    phase_done, phase_total : int, optional
        Kernels compiled, of how many, while the phase is compiling; None in every other.
    points_total, points_done, points_failed, blocks_total, blocks_done : int
        Progress; failed points count as done.
    created, started, finished : datetime
        In UTC; None for what has not happened.
    seconds_left : float, optional
        Expected wall time to the end at the pace since the study last began to run [s]; None where there
        is no pace to go by.
    definition : dict
        The study as JSON.
    digest : str
        Of the definition, 64 hex digits.
    chunk : tuple of int
        Largest extent of a block along each dimension.
    provenance : dict
        Versions, machine, who and when.
    message : str, optional
        Why the study or its first failed block failed; which workers are left out and why; what the study waits for.
    seconds, kernel_seconds : float
        Summed over the done blocks [s].
    owner : str, optional
        Who works on the study now.
    points_reused : int
        Points that were taken from earlier studies instead of being computed.
    revision : int
        Grows with every block that is done, or lost and given up: equal revisions, equal cubes.
    reuse : bool
        Whether points may be taken from earlier studies.
    shape : tuple of int
        Points along each dimension.
    version : int
        1 for a study as it was submitted; computed anew by a later solver, it gets the next, beside the older ones.
    outdated : bool
        Whether results are there and another solver than today's computed them; they stay as they are.
    priority : int
        Of the studies that wait the one with the highest begins first; 0 unless somebody asked for another.
    tags : tuple of str
        What somebody wants to find it by, sorted.
    note : str
        What somebody says of it.
    dimensions : tuple of str
        The dimensions of the cube, in its order.
    submitted_by : str, optional
        Owner of the key that it was submitted with.
    """

    id: Annotated[str, Says(description="First 12 hex digits of the digest; -2 behind them for version 2.")]
    name: str
    state: State
    phase: Annotated[Phase, Says(description="The state, or what a running study does before its blocks.")]
    phase_done: Annotated[int | None, Says(description="Kernels compiled.")]
    phase_total: Annotated[int | None, Says(description="Kernels to compile.")]
    points_total: int
    points_done: int
    points_failed: int
    blocks_total: int
    blocks_done: int
    created: datetime
    started: datetime | None
    finished: datetime | None
    seconds_left: Annotated[float | None, Says(description="Expected wall time to the end, in seconds.")]
    definition: Annotated[dict[str, Any], Says(description="The study; submit it again to get this record.")]
    digest: str
    chunk: tuple[int, ...]
    provenance: dict[str, str]
    message: str | None
    seconds: float
    kernel_seconds: float
    owner: str | None
    points_reused: Annotated[int, Says(description="Points reused from earlier studies.")]
    revision: int
    reuse: bool
    shape: tuple[int, ...]
    version: Annotated[
        int, Says(description="1 as submitted; computed again by a later solver, it gets the next.")
    ]
    outdated: Annotated[
        bool, Says(description="Another solver than today's computed the results; POST /recompute.")
    ]
    priority: Annotated[
        int, Says(description="Of the studies that wait the one with the highest begins first.")
    ]
    tags: tuple[str, ...]
    note: str
    dimensions: Annotated[tuple[str, ...], Says(description="Those of the cube, in its order.")]
    submitted_by: Annotated[
        str | None,
        Says(description="Owner of the key that it was submitted with; null where no keys are asked for."),
    ]

    def _repr_html_(self) -> str:
        """Show a notebook the state and the progress."""
        rows = [
            ("id", self.id),
            ("state", self.state if self.phase == self.state else f"{self.state} ({self.phase})"),
            ("points", f"{self.points_done:,} of {self.points_total:,}, {self.points_failed:,} failed"),
            ("created", f"{self.created:%Y-%m-%d %H:%M:%S} UTC"),
            ("message", self.message),
        ]
        return card(f"Study {self.name}".strip(), rows)

    @property
    def ended(self) -> bool:
        """Whether nothing more happens unless somebody asks for it."""
        return self.state in ENDED

    def document(self) -> dict[str, Any]:
        """Give the record as JSON-able values; times in ISO 8601, UTC."""
        document = dict(vars(self))
        for key in ("created", "started", "finished"):
            document[key] = None if document[key] is None else document[key].isoformat()
        for key in ("chunk", "shape", "tags", "dimensions"):
            document[key] = list(document[key])
        return document

    def summary(self) -> dict[str, Any]:
        """Give it without its definition, which may be long, and its provenance."""
        return {
            name: value for name, value in self.document().items() if name not in ("definition", "provenance")
        }


RecordDocument = TypeAliasType("RecordDocument", Annotated[dict[str, Any], Like(Record)])
RecordSummary = TypeAliasType(
    "RecordSummary", Annotated[dict[str, Any], Like(Record, "definition", "provenance")]
)


class RecordsDocument(TypedDict):
    """Records without their definitions."""

    studies: list[RecordSummary]


class RecordPage(RecordsDocument):
    """A page of them."""

    cursor: str | None


@dataclass(frozen=True)
class Page:
    """One page of records, newest first.

    Parameters
    ----------
    records : tuple of Record
        The records of the page.
    cursor : str, optional
        Ask with it for the next page; None at the end.
    """

    records: tuple[Record, ...]
    cursor: str | None


def utc(seconds: float | None) -> datetime | None:
    """Give seconds since 1970 as a time in UTC, and None as None."""
    return None if seconds is None else datetime.fromtimestamp(seconds, UTC)
