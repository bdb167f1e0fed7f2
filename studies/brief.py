"""The short answer to a question: what to do, what comes second, and one next step. Everything else is detail."""

import shlex
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Annotated, Any, Literal, get_args

from typing_extensions import TypedDict

from damperlab.studies.shapes import Says, Sentences, Table

Damper = Literal["hybrid", "friction_alone", "particle_alone", "tuned_mass_damper", "no_damper"]
"""The dampers that a verdict may recommend."""
Severity = Literal["danger", "caution", "hint"]
"""Effect of a note: it changes what to build, changes the stated number, or says where to look further."""
DoubtKind = Literal[
    "one_frequency", "hidden_peak", "cut_off", "end_of_range", "neighbourhood_unknown", "rugged", "error"
]
"""Kinds of doubt, the gravest first. Those after `hidden_peak` concern only the optimum, not the best design with
impacts.
"""
DOUBTS: tuple[DoubtKind, ...] = get_args(DoubtKind)
MOST_SENTENCES, MOST_ROWS = 3, 6
PLACES = ("best", "second", "third", "fourth")
"""Names of the rows of a ranking."""
EQUAL = "equal"
"""Name of a further row with the value of the best."""


def damper_of(acts: bool, rubs: bool) -> Damper:
    """Name a damper by whether its particle acts and whether it has friction."""
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
    """A remark on an answer, as data; its sentence is formed where it is displayed.

    Parameters
    ----------
    kind : str
        Its kind, for example ``end_of_range``.
    severity : str
        See `Severity`.
    values : mapping
        Its numbers, in the units of the document that holds it.
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
        The recommended damper; None if there is none.
    sentences : tuple of str
        The decision first, then its conditions; the first `MOST_SENTENCES` are shown.
    rows : tuple of tuple of str
        The other candidates: name, value, description; the first `MOST_ROWS` are shown.
    next : str
        One next step.
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
        """Give it as plain data."""
        return {
            "damper": self.damper,
            "sentences": list(self.sentences),
            "rows": [list(row) for row in self.rows],
            "next": self.next,
        }


def command(verb: str, name: str, options: str = "") -> str:
    """Write a command about a study with shell quoting; `STUDY` stands for one without a name."""
    return f"damperlab {verb} {shlex.quote(name) if name else 'STUDY'} {options}".rstrip()


def listed(words: Iterable[str]) -> str:
    """Write a list as ``a, b and c``."""
    *most, last = words
    return f"{', '.join(most)} and {last}" if most else last


def notes_document(notes: list[Note]) -> list[NoteDocument]:
    """Give notes as plain data, the gravest first."""
    order: list[Severity] = ["danger", "caution", "hint"]
    return [
        {"kind": each.kind, "severity": each.severity, "values": dict(each.values)}
        for each in sorted(notes, key=lambda each: order.index(each.severity))
    ]


def lines_of(brief: Mapping[str, Any]) -> list[str]:
    """Lay out the document of a `Brief` for a terminal: its sentences, its rows in columns, its next step."""
    rows = brief["rows"]
    widths = [max((len(row[column]) for row in rows), default=0) for column in (0, 1)]
    table = [f"  {name:<{widths[0]}}  {value:<{widths[1]}}  {what}".rstrip() for name, value, what in rows]
    return [*brief["sentences"], *table, *([f"Next: {brief['next']}"] if brief["next"] else [])]
