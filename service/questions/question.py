"""A question about the cube of a study. All interfaces are made from one object, the `Question`.

The object determines the HTTP route, the command, the client method and the entry on the page. The functions of a
question import heavy modules only when needed, so the client and the command line do not load the solver or the server.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import suppress
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
    from damperlab.studies.brief import Brief
    from damperlab.studies.definition import Study
    from damperlab.studies.ground.motion import GroundMotion
    from damperlab.studies.ground.suite import Suite
    from damperlab.studies.store.record import Record
    from damperlab.studies.store.store import Store

    Table = tuple[tuple[str, ...], list[tuple[str, ...]]]

A = TypeVar("A", covariant=True)
"""Type of the answer in the client: a Dataset that can draw a figure."""


@dataclass(frozen=True)
class Subject:
    """The study that a question is about, and access to other studies.

    Parameters
    ----------
    record : Record
        The record of the study.
    store : Store
        The store that holds the cube of the study.
    called : str
        The command or the route of the question, as a name in messages.
    http : bool
        Whether the question came by HTTP. A request for a map by HTTP must name the axes, and the size of the
        map is limited.
    """

    record: "Record"
    store: "Store"
    called: str
    http: bool = False

    @cached_property
    def cube(self) -> "xr.Dataset":
        """The cube with the present results of the study."""
        return self.store.cube(self.record.id)

    def motions(self) -> "Mapping[str, GroundMotion]":
        """Read the records of a ground-motion suite, by their ids; empty if the file of a record is lost or damaged.

        Raises
        ------
        ShelfAway
            If the store does not answer.
        """
        from damperlab.studies.store.cube.definition import with_attachments
        from damperlab.studies.store.files.shelf import ShelfAway

        if self._stored is None:
            return {}
        shelf, _ = self.store.snapshot(self.record.id)
        try:
            suite = with_attachments(self._stored, shelf)
        except ShelfAway:
            raise
        except (OSError, ValueError):
            return {}
        return getattr(suite, "motions", {})

    def warned(self, answer: "xr.Dataset") -> "xr.Dataset":
        """Return an answer whose text begins with warnings about implausible values of the study."""
        from damperlab.studies.answers.phrases import first_said

        return answer.assign_attrs(first_said(answer.attrs, self.unusual))

    @cached_property
    def unusual(self) -> list[str]:
        """Warnings about implausible values of the study."""
        from damperlab.studies.understood import unusual_study

        return [] if self._stored is None else unusual_study(self._stored)

    def first_warned(self, brief: "Brief") -> Mapping[str, Any]:
        """Return a short answer for a terminal that begins with the same warnings."""
        document = brief.document()
        return {**document, "sentences": [*self.unusual, *document["sentences"]]}

    @cached_property
    def _stored(self) -> "Study | Suite | None":
        """The definition of the study; None if the definition is damaged.

        A damaged definition raises no error, because the cube can be read without the definition.
        """
        from damperlab.studies.store.cube.definition import DefinitionDamaged, parse_stored

        try:
            return parse_stored(self.record.definition, self.record.digest)
        except DefinitionDamaged:
            return None

    def beside(self, name: str) -> "Subject":
        """Find another study in the store, by its name or id."""
        return replace(self, record=self.store.find(name))


class Words(NamedTuple):
    """An answer for a terminal.

    Parameters
    ----------
    brief : mapping, optional
        The short answer, or None if `sentences` are the answer.
    sentences : list of str
        Sentences shown with the details.
    table : tuple, optional
        Column names and rows of a table.
    after : list of str
        Sentences after the table.
    """

    brief: Mapping[str, Any] | None
    sentences: list[str]
    table: "Table | None" = None
    after: tuple[str, ...] = ()


class Further(NamedTuple):
    """An extension of an answer, for which further studies are computed.

    Parameters
    ----------
    option : str
        Name of the option on the command line.
    help : str
        Description of the option.
    studies : callable
        Function that returns the further studies, given the `Subject`, the Dataset and the inputs. Afterwards, the
        input ``with_`` contains the ids of the further studies.
    """

    option: str
    help: str
    studies: "Callable[..., tuple[Study, ...]]"


@dataclass(frozen=True, kw_only=True)
class Question(Generic[A]):
    """A question that users can ask about a study.

    Parameters
    ----------
    route : str
        Last part of the address, from which the name of the client's method follows.
    command : str
        Name of the question on the command line.
    summary, help : str
        Descriptions of the question, for HTTP and for the command line.
    asks : tuple of type
        Frozen dataclasses of `damperlab.studies.questions` that hold the inputs.
    answer : callable
        Function that returns a Dataset, given a `Subject` and one value of each type in `asks`. The docstring of the
        function is the HTTP description.
    gives : type
        TypedDict that describes the document. The schema has the same name as this type.
    form : Form
        Conversion of the Dataset into a document, and back.
    draw : callable
        Function that returns a figure, given the Dataset and, for two studies, the names of the studies.
    tell : callable
        Function that returns `Words`, given the `Subject`, the Dataset, a flag for details, and the inputs.
    kinds : tuple of Kind
        Kinds of study that can answer the question. Studies of other kinds are refused.
    first : bool
        Whether the question is common. The help of the command line lists common questions first.
    draws_units : bool
        Whether the figure shows the quantities in units next to the ratios.
    details : bool
        Whether the command can show details in addition to a short answer.
    operation : str
        Name of the operation in the OpenAPI document. The default is ``ask_`` followed by the command.
    further : Further, optional
        Further studies that the command can compute to complete the answer.
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
        """All inputs of the question."""
        return tuple(each for asked in self.asks for each in fields_of(asked))

    @property
    def studies(self) -> tuple[str, ...]:
        """Names of the parameters that select further studies."""
        return tuple(each.key for each in self.fields if each.studies)

    @property
    def dimensions(self) -> tuple[str, ...]:
        """Dimensions for which a user may give a value: those of all kinds of study that can answer the question."""
        if SUITE in self.kinds:
            return EVERY_AXIS
        return (*BEFORE, *DIMENSIONS, *(() if self.kinds == (HARMONIC,) else (AMPLITUDE,)))

    def of(self, study: Subject, *asked: object) -> "xr.Dataset":
        """Answer the question, given one value of each type in `asks`.

        A study whose kind is not in `kinds` is refused. If blocks of a study are invalidated while the answer is
        computed, it is computed again.
        """
        from damperlab.studies.store.faults import StudyNotFound

        if SUITE not in self.kinds:
            from damperlab.studies.answers.suite import require_harmonic

            require_harmonic(study.record.dimensions, study.called, amplitudes=self.kinds != (HARMONIC,))
        needed = [study.record.id]
        for name in _further_studies(asked):
            with suppress(StudyNotFound):  # the function that answers refuses an unknown study
                needed.append(study.beside(name).record.id)
        return study.store.steadily(needed, lambda: self.answer(replace(study), *asked))


def _further_studies(asked: Iterable[object]) -> Iterator[str]:
    """Yield the names or ids of further studies in the inputs of a question."""
    for inputs in asked:
        kind: Any = type(inputs)
        for each in fields_of(kind):
            named = getattr(inputs, each.name) if each.studies else None
            if isinstance(named, str):
                yield named
            else:
                yield from named or ()


def in_front(record: "Record", answer: Mapping[str, Any]) -> dict[str, Any]:
    """Return an answer that begins with the id, the name and the state of the study."""
    return {"study": record.id, "name": record.name, "state": record.state, **answer}
