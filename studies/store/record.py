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
"""Phases in which a running study computes no block: workers start, missing kernels are compiled, or no worker is left.
"""

TRASH_DAYS = 7
"""Time for which a study in the trash can be restored."""


@dataclass(frozen=True)
class Totals:
    """Sums over the studies in one state.

    Parameters
    ----------
    studies, points, points_done, points_failed, bytes : int
        Number of studies; their design points, those stored, and those that failed; bytes of the complete cubes.
    blocks_left : int
        Blocks yet to be computed.
    """

    studies: int
    points: int
    points_done: int
    points_failed: int
    bytes: int
    blocks_left: int


@dataclass(frozen=True)
class BlockOutcome:
    """Report of a worker on one block once its region is on the disk.

    Parameters
    ----------
    index : int
        Index of the block in its plan.
    points, failed : int
        Points of the block, and the number with a status of 2 or above.
    seconds, kernel_seconds : float
        Wall time of the whole block, and the part of it spent in kernels [s].
    message : str, optional
        Reason of a failed block.
    generation, checksum : str
        The generation in the name of the block's file, and the checksum of its values; see
        `damperlab.studies.store.cube.cube.write_region`.
    reused : int
        Points reused from earlier studies.
    identity : str
        Solver, see `damperlab.studies.store.solver.identity_of`; empty for a failed block.
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
        The first 12 hex digits of the digest; the study's name; one of `STATES`.
    phase : str
        One of `PREPARATIONS` while a running study computes no block, else its state.
    phase_done, phase_total : int, optional
        Number of compiled kernels, and their total, while the phase is compiling; else None.
    points_total, points_done, points_failed, blocks_total, blocks_done : int
        Progress; failed points count as done.
    created, started, finished : datetime
        In UTC; None if it has not happened.
    seconds_left : float, optional
        Expected wall time to the end at the pace since the study was last started [s]; None without a pace.
    definition : dict
        The study as JSON.
    digest : str
        Digest of the definition, 64 hex digits.
    chunk : tuple of int
        Largest extent of a block along each dimension.
    provenance : dict
        Versions, machine, user and time.
    message : str, optional
        Why the study or its first failed block failed, which workers were excluded and why, or why it waits.
    seconds, kernel_seconds : float
        Wall time and time in kernels, summed over the done blocks [s].
    owner : str, optional
        Owner of the claim on the study; None if no process works on it.
    points_reused : int
        Points reused from earlier studies instead of being computed.
    revision : int
        Increases with every block that is done or invalidated; at equal revisions cubes are equal.
    reuse : bool
        Whether points may be taken from earlier studies.
    shape : tuple of int
        Points along each dimension.
    version : int
        1 for a study as submitted; each computation by a later solver gets the next number, and older ones stay.
    outdated : bool
        Whether its results come from a solver other than today's; they are unchanged.
    priority : int
        The waiting study with the highest priority starts first; by default 0.
    tags : tuple of str
        Tags for finding it, sorted.
    note : str
        The user's note.
    dimensions : tuple of str
        The dimensions of the cube, in its order.
    submitted_by : str, optional
        Owner of the key of its submission.
    """

    id: Annotated[str, Says(description="First 12 hex digits of the digest; followed by -2 for version 2.")]
    name: str
    state: State
    phase: Annotated[
        Phase, Says(description="The state, or the phase of a running study before it computes blocks.")
    ]
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
        int, Says(description="1 as submitted; each computation by a later solver gets the next number.")
    ]
    outdated: Annotated[
        bool,
        Says(
            description="Whether a solver other than today's computed the results; POST /recompute "
            "computes them again."
        ),
    ]
    priority: Annotated[
        int, Says(description="Of the studies that wait, the one with the highest priority starts first.")
    ]
    tags: tuple[str, ...]
    note: str
    dimensions: Annotated[tuple[str, ...], Says(description="The dimensions of the cube, in its order.")]
    submitted_by: Annotated[
        str | None,
        Says(
            description="Owner of the key that it was submitted with; null if the service requires no keys."
        ),
    ]

    def _repr_html_(self) -> str:
        """Show the state and the progress in a notebook."""
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
        """Whether the study has ended, so that nothing more happens without a request."""
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
        """Give the record as JSON-able values, without its definition, which may be long, and its provenance."""
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
    """A page of records."""

    cursor: str | None


@dataclass(frozen=True)
class Page:
    """One page of records, newest first.

    Parameters
    ----------
    records : tuple of Record
        The records of the page.
    cursor : str, optional
        Cursor of the next page; None at the end.
    """

    records: tuple[Record, ...]
    cursor: str | None


def utc(seconds: float | None) -> datetime | None:
    """Convert seconds since 1970 to a time in UTC, and None to None."""
    return None if seconds is None else datetime.fromtimestamp(seconds, UTC)
