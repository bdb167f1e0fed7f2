"""Options that are made from the dataclasses in `damperlab.studies.questions`.

If the type of a command's parameter is such a dataclass, `asks` replaces the parameter by one option for each field.
All commands take the values of a design in the same way: ``--at clearance_ratio=3``, or ``--clearance-ratio 3`` for
short.
"""

import inspect
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import is_dataclass
from functools import wraps
from typing import Annotated, Any, Literal, get_args, get_origin

import typer

from damperlab.service.cli.failures import UsageFault, note_options
from damperlab.service.cli.options import read_named, read_number, read_range
from damperlab.studies.faults import Fault, describe
from damperlab.studies.field import At, Field, Ranges, admits, fields_of, option_of, words_of
from damperlab.studies.ground.variables import RECORD
from damperlab.studies.quantity import Quantity
from damperlab.studies.questions import EVERY_AXIS, RANGED
from damperlab.studies.unit_names import ALIASES

Command = Callable[..., None]
Values = dict[str, float]
"""Numbers by name."""

WIDE = 14
"""Largest width of choices shown as the metavar of an option [characters]. Wider choices are listed in its help text."""
LARGE = 1_000_000
"""Limits above this value are not shown in the help."""


def asks(command: Command) -> Command:
    """Replace each parameter whose type is a dataclass by one option for each field of the dataclass.

    The field that maps dimensions to values becomes ``--at NAME=VALUE``. Every dimension also gets a short option, which
    the help does not list. A short option is left out if the command has another option with the same name.
    """
    signature = inspect.signature(command, eval_str=True)
    questions = {
        name: each.annotation
        for name, each in signature.parameters.items()
        if isinstance(each.annotation, type) and is_dataclass(each.annotation)
    }
    offered = [each for kind in questions.values() for each in fields_of(kind) if "command" in each.doors]
    note_options(offered)
    kept = [each for name, each in signature.parameters.items() if name not in questions]
    more = {each.name: (_option(each), _default(each)) for each in offered}
    if any(each.is_named and each.core != Ranges for each in offered):
        spelled = {spelling for each in offered for spelling in each.options}
        for name in (each for each in EVERY_AXIS if option_of(each) not in spelled):
            spellings = [option_of(each) for each in (name, *(a for a, of in ALIASES.items() if of == name))]
            more[f"of_{name}"] = Annotated[str | None, typer.Option(*spellings, hidden=True)], None

    @wraps(command)
    def asking(**given: Any) -> None:
        short = {
            name.removeprefix("of_"): value
            for name in list(given)
            if name.startswith("of_") and (value := given.pop(name)) is not None
        }
        asked = {name: _value(kind, given, short) for name, kind in questions.items()}
        command(**{each.name: given[each.name] for each in kept}, **asked)

    parameters: list[inspect.Parameter] = []
    for name, each in signature.parameters.items():
        if name in questions:  # in the help, the options take the position of the parameter
            mine = [field.name for field in fields_of(questions[name]) if field.name in more]
            parameters += [parameter(field, *more.pop(field)) for field in mine]
        else:
            parameters.append(each.replace(kind=inspect.Parameter.KEYWORD_ONLY))
    parameters += [parameter(name, *rest) for name, rest in more.items()]
    return with_parameters(asking, parameters)


def names_a_design(
    meanings: Mapping[str, str], quantities: Mapping[str, Quantity], listed: str = ""
) -> Callable[[Command], Command]:
    """Return a decorator that adds the option ``--at`` to a command, and an option for each number of a design.

    Parameters
    ----------
    meanings : mapping of str
        Meaning of each number, with its default. The texts are empty if the help of ``--at`` lists the numbers.
    quantities : mapping of Quantity
        Limits of the numbers. A number without an entry is checked later.
    listed : str, optional
        Help of ``--at`` with a list of all numbers. If it is given, the help omits the options for single numbers.

    Returns
    -------
    callable
        The decorator. The command's parameter `design` receives a mapping of the given numbers.
    """

    def extend(command: Command) -> Command:
        signature = inspect.signature(command, eval_str=True)
        options = [
            parameter(
                name,
                Annotated[
                    str | None,
                    typer.Option(
                        option_of(name),
                        metavar="NUMBER",
                        help=sentence(meaning),
                        show_default=False,
                        hidden=bool(listed),
                    ),
                ],
                None,
            )
            for name, meaning in meanings.items()
        ]
        spelled = Annotated[
            list[str] | None,
            typer.Option(
                metavar="NAME=VALUE",
                help=listed
                or "Another way to give these numbers, as in --at restitution=0.5. May be repeated.",
            ),
        ]

        @wraps(command)
        def extended(**given: Any) -> None:
            short = {name: given.pop(name) for name in meanings}
            design = {
                name: _of_quantity(option_of(name), text, quantities.get(name))
                for name, text in short.items()
                if text is not None
            }
            for name, text in read_named("--at", given.pop("at"), tuple(meanings)):
                if name in design:
                    refuse_twice(name)
                design[name] = _of_quantity("--at", text, quantities.get(name))
            command(**given, design=design)

        kept = [
            each.replace(kind=inspect.Parameter.KEYWORD_ONLY)
            for name, each in signature.parameters.items()
            if name != "design"
        ]
        first = 1 if _has_argument(kept) else 0
        return with_parameters(
            extended, [*kept[:first], *options, parameter("at", spelled, None), *kept[first:]]
        )

    return extend


def _of_quantity(option: str, text: str, quantity: Quantity | None) -> float:
    return read_number(option, text) if quantity is None else read_number(option, text, quantity.allowed)


def _has_argument(parameters: list[inspect.Parameter]) -> bool:
    """Return whether the first parameter is a positional argument, which must stay first."""
    about = getattr(parameters[0].annotation, "__metadata__", ())
    return any(isinstance(each, type(typer.Argument())) for each in about)


def with_parameters(command: Any, parameters: list[inspect.Parameter]) -> Command:
    """Set the signature of a command. typer reads the parameters from the signature."""
    command.__signature__ = inspect.Signature(parameters)
    command.__annotations__ = {each.name: each.annotation for each in parameters}
    del command.__wrapped__  # the wrapped command has other parameters
    return command  # type: ignore[no-any-return]


def sentence(text: str) -> str:
    """Capitalise the first letter of a text, and append a full stop. `str.capitalize` would also change Z into z."""
    return f"{text[:1].upper()}{text[1:]}."


def parameter(name: str, annotation: Any, default: Any) -> inspect.Parameter:
    """Make a parameter of a command."""
    return inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=default, annotation=annotation)


def _option(field: Field) -> Any:
    """Make the option of a field."""
    about: dict[str, Any] = {"help": field.help, "metavar": field.form or None}
    kind: Any = field.core
    words = [str(word) for word in get_args(kind)] if get_origin(kind) is Literal else []
    if len("|".join(words)) > WIDE:
        about = {"help": f"{field.help} One of {', '.join(words)}.", "metavar": "NAME"}
    if field.is_repeated or field.is_named:
        kind = list[str]
        spelled = (
            " Write --at clearance_ratio=3, or for short --clearance-ratio 3." if field.core == At else ""
        )
        about["help"] = f"{field.help}{spelled} May be repeated."
    elif field.is_range or field.is_list:
        kind = str
    elif kind is int:
        about |= {"min": _whole(field.least), "max": _whole(field.most), "metavar": field.form or "N"}
    optional = _default(field) is None
    return Annotated[kind | None if optional else kind, typer.Option(*field.options, **about)]


def _default(field: Field) -> Any:
    if field.needed:
        return inspect.Parameter.empty
    if field.is_repeated or field.is_named:
        return None
    if field.is_range and field.default is not None:
        return "{:g},{:g}".format(*field.default)
    return field.default


def _whole(limit: float | None) -> int | None:
    """Return a limit that typer checks and shows in the help, or None if `_within_limits` checks the limit."""
    return None if limit is None or limit > LARGE else int(limit)


def _value(question: type, given: dict[str, Any], short: dict[str, str]) -> Any:
    """Return an object of the class `question` with the values of the options."""
    values: dict[str, Any] = {}
    for each in fields_of(question):
        if "command" not in each.doors:
            continue
        raw, option = given.pop(each.name), each.options[0]
        if each.is_named:
            values[each.name] = _by_name(each, raw, short)
        elif each.is_repeated:
            values[each.name] = tuple(raw) if raw else each.default
        elif raw is not None and each.is_range:
            values[each.name] = read_range(option, raw)
        elif raw is not None and each.is_list:
            values[each.name] = tuple(part.strip() for part in raw.split(","))
        else:
            values[each.name] = ALIASES.get(raw, raw) if each.allowed else _within_limits(each, raw)
    return question(**values)


def _within_limits(field: Field, value: Any) -> Any:
    """Refuse a number outside the limits of its field. typer has already checked most limits of whole numbers."""
    limited = words_of(field) if isinstance(value, int | float) else ""
    if limited and not admits(field, value):
        advice = "correct the value" + (", or leave it out" if field.default is None else "")
        raise UsageFault(Fault(field.options[0], describe(value), limited, advice))
    return value


def _by_name(field: Field, written: Iterable[str] | None, short: dict[str, str]) -> dict[str, Any]:
    """Read texts ``name=value`` and the short options, and return the values by name."""
    option = field.options[0]
    if field.core == Ranges:
        return {
            name: read_range(option, text) for name, text in _named(option, written, RANGED, "name=lo,hi")
        }
    found: dict[str, Any] = {}
    for name, text in _named(option, written, EVERY_AXIS, "dimension=value"):
        found[name] = text if name == RECORD else read_number(option, text)
    for name, text in short.items():
        if name in found:
            refuse_twice(name)
        found[name] = text if name == RECORD else read_number(option_of(name), text)
    return found


def _named(
    option: str, written: Iterable[str] | None, names: tuple[str, ...], form: str
) -> Iterator[tuple[str, str]]:
    """Read texts ``name=value`` with `read_named`.

    Names from a study's block `physical`, such as `excitation_frequency_hz`, are accepted as well (`ALIASES`).
    """
    assignments = (
        f"{ALIASES.get(name, name)}{equals}{text}"
        for name, equals, text in (each.partition("=") for each in written or ())
    )
    yield from read_named(option, assignments, names, form)


def refuse_twice(name: str) -> None:
    """Refuse a value that both ``--at`` and a separate option give."""
    raise typer.BadParameter(
        f"{name} is given twice, by --at and by {option_of(name)}. Leave one of them out.", param_hint="--at"
    )
