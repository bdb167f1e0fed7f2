"""Data of a study in the catalogue, and a worker's report on one block."""

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
"""Phases of a running study in which no block is computed. A study is `waiting` if no worker is left."""

TRASH_DAYS = 7
"""Time for which a study in the trash can be restored."""


@dataclass(frozen=True)
class Totals:
    """Sums over all studies in one state.

    Parameters
    ----------
    studies : int
        Number of studies.
    points, points_done, points_failed : int
        Numbers of all points, of points that are done, and of failed points.
    bytes : int
        Size of the cubes when they are complete.
    blocks_left : int
        Number of blocks that are not done.
    """

    studies: int
    points: int
    points_done: int
    points_failed: int
    bytes: int
    blocks_left: int


@dataclass(frozen=True)
class BlockOutcome:
    """Report of a worker on one block, sent after the file of the block is on the disk.

    Parameters
    ----------
    index : int
        Index of the block in the plan of the study.
    points, failed : int
        Number of points of the block, and number of points with a status of 2 or above.
    seconds, kernel_seconds : float
        Wall time of the whole block, and the part of this time spent in kernels [s].
    message : str, optional
        Reason why the block failed; None if the block did not fail.
    generation, checksum : str
        The generation in the name of the block's file, and the checksum of the block's values; see
        `damperlab.studies.store.cube.block_file.write_region`.
    reused : int
        Number of points reused from earlier studies.
    identity : str
        Identity of the solver, from `damperlab.studies.store.solver.identity_of`; empty for a failed block.
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
    """Data of a study in the catalogue at one moment.

    Parameters
    ----------
    id, name, state : str
        Id of the study, made of the digest and the version; name of the study; state, one of `STATES`.
    phase : str
        One of `PREPARATIONS` while the study is running and computes no block; otherwise the state.
    phase_done, phase_total : int, optional
        Number of compiled kernels, and number of kernels to compile, during the phase `compiling`; else None.
    points_total, points_done, points_failed, blocks_total, blocks_done : int
        Numbers of points and blocks. Failed points are included in `points_done`.
    created, started, finished : datetime
        Times of the submission, the start and the end in UTC; None before the start or the end.
    seconds_left : float, optional
        Expected wall time until the study ends [s]; None if the speed of the computation is unknown.
    definition : dict
        The study as JSON.
    digest : str
        Digest of the definition, 64 hex digits.
    chunk : tuple of int
        Largest extent of a block along each dimension.
    provenance : dict
        Versions, machine, user and time.
    message : str, optional
        Reason why the study or a block failed, why workers were excluded, or why the study waits.
    seconds, kernel_seconds : float
        Wall time and time in kernels, summed over the done blocks [s].
    owner : str, optional
        Owner of the claim on the study; None if no process works on the study.
    points_reused : int
        Number of points reused from earlier studies.
    revision : int
        Number that increases whenever blocks are done or invalidated. An unchanged number means an unchanged cube.
    reuse : bool
        Whether points may be taken from earlier studies.
    shape : tuple of int
        Number of points along each dimension.
    version : int
        1 for the submitted study. Each recomputation with another solver gets the next number.
    outdated : bool
        Whether a solver other than today's computed the results.
    priority : int
        The waiting study with the highest priority starts first; by default 0.
    tags : tuple of str
        Tags for finding the study, sorted.
    note : str
        The user's note.
    dimensions : tuple of str
        Names of the cube's dimensions, in the order of the axes.
    submitted_by : str, optional
        Owner of the access key with which the study was submitted; None if no key was used.
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
        """Whether the study has ended: it is done, cancelled or failed."""
        return self.state in ENDED

    def document(self) -> dict[str, Any]:
        """Return the record as JSON-able values; times are in ISO 8601 and in UTC."""
        document = dict(vars(self))
        for key in ("created", "started", "finished"):
            document[key] = None if document[key] is None else document[key].isoformat()
        for key in ("chunk", "shape", "tags", "dimensions"):
            document[key] = list(document[key])
        return document

    def summary(self) -> dict[str, Any]:
        """Return the record as JSON-able values, without the definition and the provenance."""
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
