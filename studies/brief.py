"""The short answer to a question: the recommendation, the second best, and one next step."""

import shlex
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Annotated, Any, Literal, get_args

from typing_extensions import TypedDict

from damperlab.studies.shapes import Says, Sentences, Table

Damper = Literal["hybrid", "friction_alone", "particle_alone", "tuned_mass_damper", "no_damper"]
"""The dampers that a verdict may recommend."""
Severity = Literal["danger", "caution", "hint"]
"""Severity of a note. A danger changes the decision, a caution changes a number, and a hint suggests further work.
"""
DoubtKind = Literal[
    "one_frequency", "hidden_peak", "cut_off", "end_of_range", "neighbourhood_unknown", "rugged", "error"
]
"""Kinds of doubt about an optimum, the most serious first. Only `one_frequency` and `hidden_peak` can
concern the best design with impacts.
"""
DOUBTS: tuple[DoubtKind, ...] = get_args(DoubtKind)
MOST_SENTENCES, MOST_ROWS = 3, 6
PLACES = ("best", "second", "third", "fourth")
"""Names of the rows of a ranking."""
EQUAL = "equal"
"""Name of a row whose value equals the value of the row `best`."""


def damper_of(acts: bool, rubs: bool) -> Damper:
    """Return the kind of a damper with or without a particle, and with or without friction."""
    if acts:
        return "hybrid" if rubs else "particle_alone"
    return "friction_alone" if rubs else "no_damper"


class NoteDocument(TypedDict):
    """A note as plain data."""

    kind: str
    severity: Severity
    values: Table


Notes = Annotated[
    list[NoteDocument],
    Says(description="Notes as data, the gravest first; values in the units of this document."),
]


@dataclass(frozen=True)
class Note:
    """A remark on an answer, as data from which an interface forms a sentence.

    Parameters
    ----------
    kind : str
        Kind of the note, for example ``end_of_range``.
    severity : str
        See `Severity`.
    values : mapping
        Numbers of the note, in the units of the document with the note.
    """

    kind: str
    severity: Severity
    values: Mapping[str, Any] = field(default_factory=dict)


class BriefDocument(TypedDict):
    """A short answer as plain data."""

    damper: Damper | None
    sentences: Sentences
    rows: list[list[str]]
    next: str


InShort = Annotated[
    BriefDocument,
    Says(description="The short answer: the decision, the second best, and one next step."),
]


@dataclass(frozen=True)
class Brief:
    """The short answer.

    Parameters
    ----------
    damper : str or None
        The recommended damper; None if the answer recommends no damper.
    sentences : tuple of str
        The decision, followed by its conditions. Only the first `MOST_SENTENCES` sentences are kept.
    rows : tuple of tuple of str
        Name, value and description of each candidate. Only the first `MOST_ROWS` rows are kept.
    next : str
        The suggested next step.
    """

    damper: Damper | None
    sentences: tuple[str, ...]
    rows: tuple[tuple[str, str, str], ...] = ()
    next: str = ""

    def __post_init__(self) -> None:
        """Drop empty sentences, and keep the first `MOST_SENTENCES` sentences and `MOST_ROWS` rows."""
        kept = tuple(filter(None, self.sentences))[:MOST_SENTENCES]
        object.__setattr__(self, "sentences", kept)
        object.__setattr__(self, "rows", self.rows[:MOST_ROWS])

    def document(self) -> BriefDocument:
        """Return the short answer as plain data."""
        return {
            "damper": self.damper,
            "sentences": list(self.sentences),
            "rows": [list(row) for row in self.rows],
            "next": self.next,
        }


def command(verb: str, name: str, options: str = "") -> str:
    """Return a command about a study, with shell quoting. ``STUDY`` replaces a missing name."""
    return f"damperlab {verb} {shlex.quote(name) if name else 'STUDY'} {options}".rstrip()


def listed(words: Iterable[str]) -> str:
    """Write a list as ``a, b and c``."""
    *most, last = words
    return f"{', '.join(most)} and {last}" if most else last


def notes_document(notes: list[Note]) -> list[NoteDocument]:
    """Return notes as plain data, the most serious first."""
    order: list[Severity] = ["danger", "caution", "hint"]
    return [
        {"kind": each.kind, "severity": each.severity, "values": dict(each.values)}
        for each in sorted(notes, key=lambda each: order.index(each.severity))
    ]


def lines_of(brief: Mapping[str, Any]) -> list[str]:
    """Return the lines of a short answer on a terminal: the sentences, the rows in columns, and the next step."""
    rows = brief["rows"]
    widths = [max((len(row[column]) for row in rows), default=0) for column in (0, 1)]
    table = [f"  {name:<{widths[0]}}  {value:<{widths[1]}}  {what}".rstrip() for name, value, what in rows]
    return [*brief["sentences"], *table, *([f"Next: {brief['next']}"] if brief["next"] else [])]
