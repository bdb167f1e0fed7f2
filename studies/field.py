"""Fields of questions about a study: names, types, defaults, limits and help for every interface."""

import math
from collections.abc import Mapping
from dataclasses import MISSING, dataclass, field, fields
from functools import cache
from types import MappingProxyType, UnionType
from typing import Any, Literal, TypeVar, Union, get_args, get_origin, get_type_hints

Range = tuple[float, float]
"""Lowest and highest value."""

Ranges = Mapping[str, Range]
"""Ranges. The keys are names of dimensions or results."""

At = Mapping[str, float | str]
"""Values of dimensions by name; the value of the dimension `record` is a name."""

Door = Literal["http", "command", "client"]
DOORS: tuple[Door, ...] = get_args(Door)

NONE: Mapping[str, Any] = MappingProxyType({})
"""A read-only empty mapping."""

_T = TypeVar("_T")


@dataclass(frozen=True)
class Field:
    """Description of one field, for every interface.

    Parameters
    ----------
    help : str
        Meaning of the field. Includes unit and default if the type does not show them.
    least, above, most : float, optional
        Limits of a number; the value `above` itself is excluded.
    allowed : tuple of str
        Allowed names; empty if every name is allowed.
    meanings : mapping of str
        Meaning of each allowed name.
    form : str
        Form of a value on the command line, as in ``LO,HI``.
    example : str
        Example of a value, shown in the HTTP reference.
    key : str
        Name of the field in an HTTP query.
    options : tuple of str
        Names of the option on the command line.
    doors : tuple of str
        Interfaces that offer the field. An interface that itself sets the value does not offer the field.
    studies : bool
        Whether the values of the field are names of other studies, whose results the answer also contains.
    default : object
        Default of the field; `MISSING` if the field is required.
    name, type
        Name and type of the dataclass field, filled in by `fields_of`.
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
        """The type of the field, without None."""
        if get_origin(self.type) in (Union, UnionType):
            (core,) = (each for each in get_args(self.type) if each is not type(None))
            return core
        return self.type

    @property
    def needed(self) -> bool:
        """Whether the field is required, because it has no default."""
        return self.default is MISSING

    @property
    def is_named(self) -> bool:
        """Whether the field is a mapping from names of dimensions to values or ranges."""
        return get_origin(self.core) is get_origin(Ranges)

    @property
    def is_list(self) -> bool:
        """Whether the field holds a list of names."""
        return get_args(self.core)[1:] == (Ellipsis,)

    @property
    def is_repeated(self) -> bool:
        """Whether the option is repeated for each value of a list. Otherwise one option has all values, ``A,B``."""
        return self.is_list and "," not in self.form

    @property
    def is_range(self) -> bool:
        """Whether the field is a range: a pair of lowest and highest value."""
        return bool(self.core == Range)


def asked(default: Any, help: str, **more: Any) -> Any:
    """Define a field of a question; see `Field`.

    Parameters
    ----------
    default : object
        Default of the field; `MISSING` if the field is required.
    help, **more
        The parameters of `Field`.
    """
    about = {"field": Field(help, default=default, **more)}
    if isinstance(default, Mapping):  # a dataclass cannot take a mutable default directly
        return field(default_factory=lambda: default, metadata=about)
    return field(default=default, metadata=about)


def asked_at() -> Any:
    """Define the field `at`, which fixes values of dimensions."""
    return asked(NONE, "Fix a dimension at the grid point nearest to a value.", form="DIMENSION=VALUE")


@cache
def fields_of(question: type) -> tuple[Field, ...]:
    """Return the fields of a question in order, with the types and defaults of the dataclass."""
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
    """Describe the limits of a number in words. Return an empty text if there are no limits."""
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
    """Return whether a number is finite and within the limits of its field."""
    low = (limited.least is None or value >= limited.least) and (
        limited.above is None or value > limited.above
    )
    return math.isfinite(value) and low and (limited.most is None or value <= limited.most)


def option_of(name: str) -> str:
    """Spell a field as an option: ``clearance_ratio`` is ``--clearance-ratio``."""
    return f"--{name.replace('_', '-')}"


def given(question: object) -> dict[str, Any]:
    """Return the fields of a question whose values differ from the defaults, by name."""
    kind: Any = type(question)
    values = ((each, getattr(question, each.name)) for each in fields_of(kind))
    return {each.name: value for each, value in values if value != each.default}
