"""A field of a question: defined once, with the question, and offered by every interface.

The HTTP query, the command line and the client derive their names, types, defaults, limits and help from it.
"""

import math
from collections.abc import Mapping
from dataclasses import MISSING, dataclass, field, fields
from functools import cache
from types import MappingProxyType, UnionType
from typing import Any, Literal, TypeVar, Union, get_args, get_origin, get_type_hints

Range = tuple[float, float]
"""Lowest and highest value."""

Ranges = Mapping[str, Range]
"""Ranges by the name of a dimension or of a result."""

At = Mapping[str, float | str]
"""Values of dimensions by name; the value of a record is its name."""

Door = Literal["http", "command", "client"]
DOORS: tuple[Door, ...] = get_args(Door)

NONE: Mapping[str, Any] = MappingProxyType({})
"""Empty mapping; read-only."""

_T = TypeVar("_T")


@dataclass(frozen=True)
class Field:
    """Description of one field, for every interface.

    Parameters
    ----------
    help : str
        Its meaning, in sentences. They name the unit and the default if the type does not show them.
    least, above, most : float, optional
        Limits of a number; `above` itself is excluded.
    allowed : tuple of str
        Allowed names; empty if every name is allowed.
    meanings : mapping of str
        Meaning of each name.
    form : str
        How the command line writes a value, as in ``LO,HI``.
    example : str
        A value for the HTTP reference.
    key : str
        Its name in a query.
    options : tuple of str
        Its spellings on the command line; a list repeats the option.
    doors : tuple of str
        The interfaces that offer the field; an interface that handles the value itself is left out.
    studies : bool
        Whether it names other studies, whose results are part of the answer.
    default : object
        Its default; `MISSING` for none.
    name, type
        Name of the dataclass field; filled in by `fields_of`.
    """

    help: str
    least: float | None = None
    above: float | None = None
    most: float | None = None
    allowed: tuple[str, ...] = ()
    meanings: Mapping[str, str] = field(default_factory=dict)
    form: str = ""
    example: str = ""
    key: str = ""
    options: tuple[str, ...] = ()
    doors: tuple[Door, ...] = DOORS
    studies: bool = False
    default: Any = None
    name: str = ""
    type: Any = str

    @property
    def core(self) -> Any:
        """The type without None."""
        if get_origin(self.type) in (Union, UnionType):
            (core,) = (each for each in get_args(self.type) if each is not type(None))
            return core
        return self.type

    @property
    def needed(self) -> bool:
        """Whether it has no default."""
        return self.default is MISSING

    @property
    def is_named(self) -> bool:
        """Whether it holds values, or ranges of values, by the names of dimensions."""
        return get_origin(self.core) is get_origin(Ranges)

    @property
    def is_list(self) -> bool:
        """Whether it holds any number of names."""
        return get_args(self.core)[1:] == (Ellipsis,)

    @property
    def is_repeated(self) -> bool:
        """Whether the option is repeated for each value; else one text lists the values, as in ``A,B``."""
        return self.is_list and "," not in self.form

    @property
    def is_range(self) -> bool:
        """Whether it is a pair of lowest and highest value."""
        return bool(self.core == Range)


def asked(default: Any, help: str, **more: Any) -> Any:
    """Define a field of a question; see `Field`.

    Parameters
    ----------
    default : object
        Its default; `MISSING` for none.
    help, **more
        As in `Field`.
    """
    about = {"field": Field(help, default=default, **more)}
    if isinstance(default, Mapping):  # a dataclass cannot take a mutable default directly
        return field(default_factory=lambda: default, metadata=about)
    return field(default=default, metadata=about)


def asked_at() -> Any:
    """Define the field that fixes a design or another point of a study; it is the same in every question."""
    return asked(NONE, "Fix a dimension at the grid point nearest to a value.", form="DIMENSION=VALUE")


@cache
def fields_of(question: type) -> tuple[Field, ...]:
    """Give the fields of a question in order, with the types and defaults of the dataclass."""
    hints = get_type_hints(question)
    found = []
    for each in fields(question):
        about: Field = each.metadata["field"]
        bare = each.name.rstrip("_")
        more = {"name": each.name, "type": hints[each.name]}
        more["key"] = about.key or bare
        more["options"] = about.options or (option_of(bare),)
        found.append(Field(**{**vars(about), **more}))
    return tuple(found)


def words_of(limited: Field) -> str:
    """Describe the limits of a number in words; empty without limits."""
    below = "" if limited.most is None else f"at most {limited.most:g}"
    if limited.above is not None:
        above = f"above {limited.above:g}"
    elif limited.least is not None and limited.most is not None:
        return f"a number from {limited.least:g} to {limited.most:g}"
    else:
        above = "" if limited.least is None else f"at least {limited.least:g}"
    both = " and ".join(filter(None, (above, below)))
    return f"a number {both}" if both else ""


def admits(limited: Field, value: float) -> bool:
    """Whether a number is finite and within the limits of its field."""
    low = (limited.least is None or value >= limited.least) and (
        limited.above is None or value > limited.above
    )
    return math.isfinite(value) and low and (limited.most is None or value <= limited.most)


def option_of(name: str) -> str:
    """Spell a field as an option: ``clearance_ratio`` is ``--clearance-ratio``."""
    return f"--{name.replace('_', '-')}"


def given(question: object) -> dict[str, Any]:
    """Give the fields of a question that differ from their defaults, by name.

    Defaults are omitted, because each kind of study refuses the fields of other kinds.
    """
    kind: Any = type(question)
    values = ((each, getattr(question, each.name)) for each in fields_of(kind))
    return {each.name: value for each, value in values if value != each.default}
