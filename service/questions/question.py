"""A question to a study's cube: all that any door needs to know of it, in one value.

Its route, its command, the client's method, the page's entry, the key under which its answer is kept, and the process that
computes it follow from the value. Functions import what is heavy where they need it: the client and the command line read
these values and load no solver, no cluster and no web.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, Generic, NamedTuple, TypeVar

from damperlab.studies.amplitudes import AMPLITUDE
from damperlab.studies.field import Field, fields_of
from damperlab.studies.kinds import HARMONIC, KINDS, SUITE, Kind
from damperlab.studies.questions import EVERY_AXIS
from damperlab.studies.variables import BEFORE, DIMENSIONS

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

    from damperlab.service.questions.forms import Form
    from damperlab.studies.store.record import Record
    from damperlab.studies.store.store import Store

    Table = tuple[tuple[str, ...], list[tuple[str, ...]]]

A = TypeVar("A", covariant=True)
"""What the client gives: the answer as a Dataset that draws itself."""


@dataclass(frozen=True)
class Subject:
    """The study that is asked, with the store in which others may stand beside it.

    Parameters
    ----------
    record : Record
        Of the study.
    store : Store
        Where its cube is.
    called : str
        What the door that asks calls the question.
    http : bool
        Whether a request asks: it names what it wants, and its answer is bounded.
    """

    record: "Record"
    store: "Store"
    called: str
    http: bool = False

    @cached_property
    def cube(self) -> "xr.Dataset":
        """Its results as they are now."""
        return self.store.cube(self.record.id)

    def beside(self, name: str) -> "Subject":
        """Find another study."""
        return replace(self, record=self.store.find(name))


class Words(NamedTuple):
    """An answer for a terminal.

    Parameters
    ----------
    brief : mapping, optional
        The short answer; where there is none, `sentences` are the answer.
    sentences : list of str
        What is said with the details.
    table : tuple, optional
        Head and rows, where they are shown.
    after : list of str
        What is said after the table.
    """

    brief: Mapping[str, Any] | None
    sentences: list[str]
    table: "Table | None" = None
    after: tuple[str, ...] = ()


@dataclass(frozen=True, kw_only=True)
class Question(Generic[A]):
    """A question.

    Parameters
    ----------
    route : str
        What stands behind the study in an address; the client's method is called so too.
    command : str
        Its name on the command line.
    summary, help : str
        What it is, for HTTP and for the command line.
    asks : tuple of type
        Frozen dataclasses of `damperlab.studies.questions`: what is asked.
    answer : callable
        Called with a `Subject` and one value of each of `asks`; gives a Dataset. HTTP describes the question with its
        docstring.
    gives : type
        The document's shape, a TypedDict; its schema bears the name of this class.
    form : Form
        How the Dataset becomes a document, and is read back.
    draw : callable
        Called with the Dataset and the names of the studies that it is about, where they are two; gives a figure.
    tell : callable
        Called with the `Subject`, the Dataset, whether details are wanted, and what was asked; gives `Words`.
    kinds : tuple of Kind
        Kinds of study that can be asked; of others it is refused.
    first : bool
        Whether a newcomer asks it: the help of the command line lists it before others.
    details : bool
        Whether the command has a short answer and details.
    operation : str
        Its name in the OpenAPI document; ``ask_`` and the command, unless it had another before.
    """

    route: str
    command: str
    summary: str
    help: str
    asks: tuple[type, ...]
    answer: "Callable[..., xr.Dataset]"
    gives: type
    form: "Form"
    draw: "Callable[[xr.Dataset, tuple[str, ...]], Figure]"
    tell: Callable[..., Words]
    kinds: tuple[Kind, ...] = KINDS
    first: bool = False
    details: bool = True
    operation: str = ""

    @property
    def method(self) -> str:
        """Its name in the client."""
        return self.route.replace("-", "_")

    @property
    def fields(self) -> tuple[Field, ...]:
        """Everything that is asked."""
        return tuple(each for asked in self.asks for each in fields_of(asked))

    @property
    def studies(self) -> tuple[str, ...]:
        """Parameters that name further studies, which the answer is made of too."""
        return tuple(each.key for each in self.fields if each.studies)

    @property
    def dimensions(self) -> tuple[str, ...]:
        """Dimensions by which a point may be named, of all kinds of study that can be asked."""
        if SUITE in self.kinds:
            return EVERY_AXIS
        return (*BEFORE, *DIMENSIONS, *(() if self.kinds == (HARMONIC,) else (AMPLITUDE,)))

    def of(self, study: Subject, *asked: object) -> "xr.Dataset":
        """Answer it, with one value of each of `asks`; refuse a study of a kind that has no answer."""
        if SUITE not in self.kinds:
            from damperlab.studies.answers.suite import require_harmonic

            require_harmonic(study.record.dimensions, study.called, amplitudes=self.kinds != (HARMONIC,))
        return self.answer(study, *asked)


def in_front(record: "Record", answer: Mapping[str, Any]) -> dict[str, Any]:
    """Put the study in front of its answer."""
    return {"study": record.id, "name": record.name, "state": record.state, **answer}
