"""A question to a study's cube: one value that holds everything the interfaces need.

Its route, command, client method, entry on the page, cache key and process all follow from this value. Functions import
heavy modules only when needed, so the client and the command line can read these values without loading solver, cluster
or web.
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
    from damperlab.studies.definition import Study
    from damperlab.studies.store.record import Record
    from damperlab.studies.store.store import Store

    Table = tuple[tuple[str, ...], list[tuple[str, ...]]]

A = TypeVar("A", covariant=True)
"""The client's answer: a Dataset with its own figure."""


@dataclass(frozen=True)
class Subject:
    """The study of the question, and access to other studies.

    Parameters
    ----------
    record : Record
        Of the study.
    store : Store
        The store of its cube.
    called : str
        The study as the user named it.
    http : bool
        Whether the question came by HTTP. The axes of a map must then be named, and its size is limited.
    """

    record: "Record"
    store: "Store"
    called: str
    http: bool = False

    @cached_property
    def cube(self) -> "xr.Dataset":
        """The present results of the study."""
        return self.store.cube(self.record.id)

    def beside(self, name: str) -> "Subject":
        """Find another study."""
        return replace(self, record=self.store.find(name))


class Words(NamedTuple):
    """An answer for a terminal.

    Parameters
    ----------
    brief : mapping, optional
        The short answer; without one, `sentences` are the answer.
    sentences : list of str
        Sentences of the details.
    table : tuple, optional
        Head and rows, if they are shown.
    after : list of str
        Sentences after the table.
    """

    brief: Mapping[str, Any] | None
    sentences: list[str]
    table: "Table | None" = None
    after: tuple[str, ...] = ()


class Further(NamedTuple):
    """Something that an answer can say once further studies are computed.

    Parameters
    ----------
    option : str
        Its name on the command line.
    help : str
        Its description.
    studies : callable
        Called with the `Subject`, the Dataset and the inputs; gives the studies. The input ``with_`` then names them.
    """

    option: str
    help: str
    studies: "Callable[..., tuple[Study, ...]]"


@dataclass(frozen=True, kw_only=True)
class Question(Generic[A]):
    """A question.

    Parameters
    ----------
    route : str
        Last part of the address; also the name of the client's method.
    command : str
        Its name on the command line.
    summary, help : str
        Its description, for HTTP and for the command line.
    asks : tuple of type
        Frozen dataclasses of `damperlab.studies.questions`: its inputs.
    answer : callable
        Called with a `Subject` and one value of each of `asks`; gives a Dataset. Its docstring is the HTTP
        description.
    gives : type
        The shape of the document, a TypedDict; the schema gets its name.
    form : Form
        Conversion of the Dataset into a document, and back.
    draw : callable
        Called with the Dataset and, if there are two studies, their names; gives a figure.
    tell : callable
        Called with the `Subject`, the Dataset, whether details are wanted, and the inputs; gives `Words`.
    kinds : tuple of Kind
        Kinds of study that can answer; others refuse.
    first : bool
        Whether it is common: the help of the command line lists it first.
    draws_units : bool
        Whether its figure shows the quantities in units next to the ratios.
    details : bool
        Whether the command has a short answer and details.
    operation : str
        Its name in the OpenAPI document; by default ``ask_`` and the command.
    further : Further, optional
        What the command can compute to complete the answer.
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
    draws_units: bool = False
    details: bool = True
    operation: str = ""
    further: Further | None = None

    @property
    def method(self) -> str:
        """Name of the question's method in the client."""
        return self.route.replace("-", "_")

    @property
    def fields(self) -> tuple[Field, ...]:
        """All its inputs."""
        return tuple(each for asked in self.asks for each in fields_of(asked))

    @property
    def studies(self) -> tuple[str, ...]:
        """Names of the parameters that name further studies, whose results are part of the answer."""
        return tuple(each.key for each in self.fields if each.studies)

    @property
    def dimensions(self) -> tuple[str, ...]:
        """Dimensions by which a point may be named, of all kinds of study that can answer."""
        if SUITE in self.kinds:
            return EVERY_AXIS
        return (*BEFORE, *DIMENSIONS, *(() if self.kinds == (HARMONIC,) else (AMPLITUDE,)))

    def of(self, study: Subject, *asked: object) -> "xr.Dataset":
        """Answer the question, with one value of each of `asks`; refuse a study of a kind that cannot answer."""
        if SUITE not in self.kinds:
            from damperlab.studies.answers.suite import require_harmonic

            require_harmonic(study.record.dimensions, study.called, amplitudes=self.kinds != (HARMONIC,))
        return self.answer(study, *asked)


def in_front(record: "Record", answer: Mapping[str, Any]) -> dict[str, Any]:
    """Put the study in front of the answer."""
    return {"study": record.id, "name": record.name, "state": record.state, **answer}
