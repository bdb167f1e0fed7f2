"""One way to name a design in every command: ``--at clearance_ratio=3``, or ``--clearance-ratio 3`` for short.

A command that is told a design has a parameter `at`. The decorators here give it the other spelling, from the tables
of dimensions, and hand it both as one list of ``name=value``.
"""

import inspect
from collections.abc import Callable, Mapping
from functools import wraps
from typing import Annotated, Any

import typer

from damperlab.service.cli.options import read_at, read_number
from damperlab.studies.ground.variables import RECORD
from damperlab.studies.registry import EVERY_DIMENSION
from damperlab.studies.variables import DIMENSION_LONG_NAMES, DIMENSIONS
from damperlab.studies.vocabulary import DESIGN_POINT

WORDS = ("tmd_criterion",)
"""Fields whose value is no number."""

Command = Callable[..., None]


def option_of(name: str) -> str:
    """Spell a field as an option: ``clearance_ratio`` is ``--clearance-ratio``."""
    return f"--{name.replace('_', '-')}"


def fixes_dimensions(command: Command) -> Command:
    """Let ``--clearance-ratio 3`` stand for ``--at clearance_ratio=3``, for every dimension of every kind of study.

    The short options are not listed in the help, where ``--at`` is. A command that has an option of the same name
    keeps it.
    """
    taken = inspect.signature(command).parameters
    names = [name for name in EVERY_DIMENSION if name not in taken]
    options = {name: Annotated[str | None, typer.Option(option_of(name), hidden=True)] for name in names}
    return _extended(command, options)


def names_a_design(command: Command) -> Command:
    """Give a command an option for each ratio of a design point, with the default of `DESIGN_POINT`; and ``--at``."""
    options = {
        name: Annotated[
            str | None,
            typer.Option(
                option_of(name),
                metavar="NUMBER",
                help=f"{_sentence(DIMENSION_LONG_NAMES[name])}; {DESIGN_POINT[name]:g} by default.",
                show_default=False,
            ),
        ]
        for name in DIMENSIONS
    }
    return _extended(command, options)


def merged(at: list[str] | None, given: Mapping[str, Any]) -> dict[str, Any]:
    """Put what ``--at`` says to what options of a command say.

    Parameters
    ----------
    at : list of str or None
        As ``clearance_m=0.01``.
    given : mapping
        Every field that the command has an option for; None where it was not given.
    """
    named = read_at(at, tuple(name for name in given if name not in WORDS))
    for name in named:
        if given[name] is not None:
            _refuse_twice(name)
    return {**given, **named}


def _extended(command: Command, options: Mapping[str, Any]) -> Command:
    signature = inspect.signature(command, eval_str=True)

    @wraps(command)
    def extended(**given: Any) -> None:
        at = list(given["at"] or ())
        named = {assignment.partition("=")[0] for assignment in at}
        for name in options:
            value = given.pop(name)
            if value is not None:
                if name in named:
                    _refuse_twice(name)
                if name != RECORD:
                    read_number(option_of(name), value)
                at.append(f"{name}={value}")
        command(**{**given, "at": at or None})

    more = [
        inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=None, annotation=option)
        for name, option in options.items()
    ]
    kept = [
        each.replace(kind=inspect.Parameter.KEYWORD_ONLY)
        if each.kind is inspect.Parameter.POSITIONAL_OR_KEYWORD
        else each
        for each in signature.parameters.values()
    ]
    extended.__signature__ = signature.replace(parameters=[*more, *kept])  # type: ignore[attr-defined]
    extended.__annotations__ = {each.name: each.annotation for each in (*more, *kept)}
    del extended.__wrapped__  # its signature is not this one
    return extended


def _sentence(text: str) -> str:
    # not str.capitalize, which would write Z small
    return text[:1].upper() + text[1:]


def _refuse_twice(name: str) -> None:
    raise typer.BadParameter(
        f"{name} is given twice, by --at and by {option_of(name)}. Leave one of them out.", param_hint="--at"
    )
