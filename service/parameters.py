"""Makes the query parameters of HTTP routes from the fields of dataclasses."""

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from inspect import Parameter, Signature
from math import inf
from typing import Annotated, Any

from fastapi import Depends, Query
from pydantic import AfterValidator, AliasChoices, BaseModel, ConfigDict, WithJsonSchema, create_model
from pydantic import Field as Described
from starlette.requests import Request

from damperlab.studies.amplitudes import DIMENSIONS as AMPLITUDE_DIMENSIONS
from damperlab.studies.faults import Fault, StudyFaults
from damperlab.studies.field import Field, Ranges, fields_of
from damperlab.studies.ground.variables import DIMENSIONS as SUITE_DIMENSIONS
from damperlab.studies.ground.variables import RECORD
from damperlab.studies.questions import EVERY_AXIS, RANGED
from damperlab.studies.unit_names import ALIASES, COORDINATES, LONG_NAMES, RESULTS
from damperlab.studies.variables import DIMENSION_LONG_NAMES, VARIABLES

FREQUENCY = "frequency_ratio"
LONGEST = 2000
"""Largest number of characters of a text parameter."""


async def once(request: Request) -> None:
    """Refuse parameters that FastAPI would ignore: repeated parameters, and parameters of a route that takes none."""
    if request.query_params and request.url.path.startswith("/api/") and not _takes_any(request):
        raise StudyFaults(
            Fault(
                name,
                "a parameter",
                "no parameters",
                "leave it out",
                "{field} is not known: this request takes no parameters.",
            )
            for name in sorted({*request.query_params})
        )
    counts = Counter(name for name, _ in request.query_params.multi_items())
    twice = sorted(name for name, count in counts.items() if count > 1)
    if twice:
        raise StudyFaults(
            Fault(name, "several values", "one value", "keep one of them", "{field} is given more than once.")
            for name in twice
        )


def _takes_any(request: Request) -> bool:
    known = [request.scope["route"].dependant]
    for each in known:
        known += each.dependencies
    return any(each.query_params for each in known)


def asks(*questions: type, dimensions: Sequence[str] = EVERY_AXIS) -> Any:
    """Make a FastAPI dependency that reads the query parameters of a route into dataclasses.

    Parameters
    ----------
    *questions : type
        Dataclasses whose fields are defined with `damperlab.studies.field.asked`. The names of all fields must be
        unique. A field with the name of a dimension replaces the parameter of this dimension.
    dimensions : sequence of str
        Dimensions that parameters may name; by default the dimensions of every kind of study. Parameters may
        also name the quantities in SI units that correspond to the dimensions of harmonic studies.

    Returns
    -------
    Depends
        Dependency whose value is a tuple with an instance of each dataclass. Unknown parameters are refused.
    """
    return Depends(_Reader(questions, dimensions))


class _Reader:
    """Reads the query parameters of a route. FastAPI asks for the signature when it analyses the route."""

    def __init__(self, questions: Sequence[type], dimensions: Sequence[str]) -> None:
        self._questions = questions
        self._own = [each for question in questions for each in fields_of(question) if "http" in each.doors]
        self._taken = {each.key for each in self._own}.union(
            set(EVERY_AXIS).difference(dimensions, COORDINATES)
        )

    async def __call__(self, query: Any) -> tuple[Any, ...]:
        return tuple(_value(question, query, self._taken) for question in self._questions)

    @property
    def __signature__(self) -> Signature:
        definitions: dict[str, Any] = {}
        for each in self._own:
            definitions |= _named(each, self._taken) if each.is_named else {each.name: _single(each)}
        name = "".join(question.__name__ for question in self._questions) + "Query"
        model: type[BaseModel] = create_model(name, __config__=ConfigDict(extra="forbid"), **definitions)
        return Signature(
            [Parameter("query", Parameter.POSITIONAL_OR_KEYWORD, annotation=Annotated[model, Query()])]
        )


def _value(question: type, query: BaseModel, taken: Iterable[str]) -> Any:
    """Make an instance of a dataclass from the parsed parameters."""
    values: dict[str, Any] = {}
    for each in fields_of(question):
        if "http" not in each.doors:
            continue
        if each.is_named:
            found = ((name, getattr(query, name)) for name in _names(each, taken))
            named = {name: text for name, text in found if text is not None}
            values[each.name] = (
                {name: pair(text) for name, text in named.items()} if each.core == Ranges else named
            )
            continue
        value = getattr(query, each.name)
        if isinstance(value, str) and each.is_range:
            value = pair(value)
        elif each.is_list:
            parts = (part.strip() for part in (value or "").split(","))
            value = each.default if value is None else tuple(filter(None, parts))
        elif each.allowed:
            value = ALIASES.get(value, value)
        values[each.name] = value
    return question(**values)


def read_range(text: str) -> str:
    """Return the text of a range `lower,higher` unchanged. Raise `ValueError` if the text is not valid."""
    low, comma, high = text.partition(",")
    try:
        if comma and -inf < float(low) <= float(high) < inf:
            return text
    except ValueError:
        pass
    raise ValueError("two finite numbers, the lower one first, written as lower,higher")


def pair(text: str) -> tuple[float, float]:
    """Return the two numbers of a range `lower,higher` that `read_range` has checked."""
    low, _, high = text.partition(",")
    return float(low), float(high)


def described(field: Field) -> str:
    """Return the description of a field, with the syntax of its values unless the type shows the syntax."""
    sentences = [field.help]
    if field.is_range:
        sentences.append("Two numbers, `lower,higher`.")
    if field.is_list:
        sentences.append("Several values are separated by commas.")
    if field.meanings:
        sentences.append("; ".join(f"{name}: {meaning}" for name, meaning in field.meanings.items()) + ".")
    return " ".join(sentences)


def _single(field: Field) -> Any:
    # the dataclass checks the values; only an empty list is refused here, because it would mean the default
    text: Any = Annotated[
        str, Described(min_length=1), WithJsonSchema({"type": "string", "enum": list(field.allowed)})
    ]
    kind: Any = field.core if not field.allowed else text
    limits: dict[str, Any] = {"ge": field.least, "gt": field.above, "le": field.most}
    default = field.default
    if field.is_range:
        kind = Annotated[str, AfterValidator(read_range)]
        default = default and "{:g},{:g}".format(*default)
    elif field.is_list:
        kind, default = str, None
    if kind is float:
        limits["allow_inf_nan"] = False
    elif not field.allowed and (kind is str or field.is_range):
        limits["max_length"] = LONGEST
    more = {name: limit for name, limit in limits.items() if limit is not None}
    if field.example:
        more["examples"] = [field.example]
    # None as the default distinguishes a missing list from an empty list
    optional = default is None
    if field.needed:
        optional, default = False, ...
    return kind | None if optional else kind, Described(
        default, alias=field.key, description=described(field), **more
    )


def _names(field: Field, taken: Iterable[str]) -> Iterator[str]:
    """Return the names that a field accepts, except names with a separate parameter."""
    names = RANGED if field.core == Ranges else EVERY_AXIS
    return (name for name in names if name not in taken)


def _named(field: Field, taken: Iterable[str]) -> Mapping[str, Any]:
    """For a field that maps names to values or ranges, define a query parameter for each name."""
    ranged = field.core == Ranges
    also = {name: AliasChoices(name, alias) for alias, name in ALIASES.items()}
    found: dict[str, Any] = {}
    for name in _names(field, taken):
        words = _long_name(name)
        if ranged:
            meaning = f"`lower,higher` of the {words}: designs outside this range"
            results = {*VARIABLES, *RESULTS}
            meaning += " at any considered frequency are excluded." if name in results else " are excluded."
            if name == FREQUENCY:
                meaning = "Not accepted: give the range of frequency ratios as `band`."
            kind: Any = Annotated[str, AfterValidator(read_range)] | None
            found[name] = (
                kind,
                Described(None, max_length=100, description=meaning, validation_alias=also.get(name)),
            )
        elif name == RECORD:
            found[name] = str | None, Described(None, max_length=100, description=f"{words}, by its id.")
        else:
            meaning = f"{words}; the grid point nearest to this value is taken."
            if name in LONG_NAMES:
                meaning += " For a harmonic study, only if the study is given in SI units."
            found[name] = (
                float | None,
                Described(None, allow_inf_nan=False, description=meaning, validation_alias=also.get(name)),
            )
    return found


def _long_name(name: str) -> str:
    if name in DIMENSION_LONG_NAMES:
        return DIMENSION_LONG_NAMES[name]
    if name in SUITE_DIMENSIONS:
        return SUITE_DIMENSIONS[name][1]
    if name in AMPLITUDE_DIMENSIONS:
        return AMPLITUDE_DIMENSIONS[name][1]
    return LONG_NAMES[name] if name in LONG_NAMES else VARIABLES[name].long_name
