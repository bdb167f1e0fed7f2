"""Errors of the command line. Each error gives an exit status, and a message or, with --json, a problem document."""

import re
from collections.abc import Iterable
from dataclasses import replace

import typer

from damperlab.service.cli.output import note, print_json
from damperlab.studies.faults import Fault, StudyFaults, nearest
from damperlab.studies.field import Field, option_of
from damperlab.studies.kinds import EVERY_DIMENSION
from damperlab.studies.questions import EVERY_AXIS
from damperlab.studies.unit_names import ALIASES, COORDINATE_SOURCES
from damperlab.studies.variables import DIMENSION_LONG_NAMES, MADE_BY

RATIOS = COORDINATE_SOURCES | {of: ratio for ratio, of in MADE_BY.items()}
"""Ratio that corresponds to each quantity in SI units."""
DONE = 0
FAILED = 1
BAD_USAGE = 2


class CommandFailed(Exception):
    """Error of a command that could not do its task. The text gives the reason and the remedy.

    Parameters
    ----------
    kind : str
        Short name by which programs distinguish failures.
    text : str
        Reason and remedy, in one or two sentences.
    """

    def __init__(self, kind: str, text: str) -> None:
        super().__init__(text)
        self.kind = kind


class UsageFault(Exception):
    """Error of a command whose options have invalid values.

    Parameters
    ----------
    *faults : Fault
        One fault for each option with an invalid value.
    """

    def __init__(self, *faults: Fault) -> None:
        super().__init__(" ".join(map(str, faults)))
        self.faults = faults


SPELLED: dict[str, str] = {}
"""Command-line option for each field of a question, recorded when the options of a command are made. Names of dimensions
are left out, because they may also be fields of a study.
"""


def note_options(fields: Iterable[Field]) -> None:
    """Record the option of each field, so that messages can name the options."""
    for each in fields:
        SPELLED.update(
            {name: each.options[0] for name in (each.key, each.name) if name not in EVERY_DIMENSION}
        )


def report(error: Exception, as_json: bool) -> int:
    """Report an error to the user, unless the error is a defect of the program.

    Parameters
    ----------
    error : Exception
        The exception of a command.
    as_json : bool
        Whether standard output must hold a JSON document.

    Returns
    -------
    int
        The exit status: 2 for bad usage or a bad study, 1 for any other failure.

    Raises
    ------
    Exception
        If `error` is a defect of the program, `error` is raised again.
    """
    if isinstance(error, typer.TyperException):
        return _report_usage(error, as_json)
    faults: tuple[Fault, ...] = ()
    kind, status, text = "failed", FAILED, str(error)
    if isinstance(error, CommandFailed):
        kind = error.kind
    elif isinstance(error, StudyFaults):
        kind, status, faults = "invalid", BAD_USAGE, error.faults
        text = f"The request has {len(faults)} fault{'' if len(faults) == 1 else 's'}; nothing was stored."
    elif isinstance(error, UsageFault):
        kind, status, faults = "usage", BAD_USAGE, error.faults
    elif isinstance(fault := getattr(error, "fault", None), Fault):
        # Store and cluster raise their own errors, each with a single fault.
        kind, faults = _kebab(type(error).__name__), (fault,)
        status = BAD_USAGE if kind in ("study-not-found", "design-not-found", "query-fault") else FAILED
    elif isinstance(error, OSError):
        kind, text = "system", _of_system(error)
    else:
        raise error
    if as_json:
        _print_problem(kind, status, text if isinstance(error, StudyFaults) else _spelled(text), faults)
    else:
        # names in the faults of a study are not replaced: a field of the study may have the same name as an option
        lines = [str(fault) for fault in faults] or [text]
        for line in lines if isinstance(error, StudyFaults) else map(_spelled, lines):
            note(f"damperlab: {line}")
    return status


def _of_system(error: OSError) -> str:
    """Describe an error of the operating system, with the name of the file but without the error number."""
    if error.strerror is None:
        return str(error)
    return f"{error.strerror}{'' if error.filename is None else f': {error.filename}'}."


def _report_usage(error: typer.TyperException, as_json: bool) -> int:
    faults = _faults_of_value(error)
    # pydantic puts "Value error, " before the message of an exception
    text = " ".join(map(str, faults)) or _with_nearest(error.format_message().replace("Value error, ", ""))
    text = _ratio_for(error) or text
    if as_json:
        _print_problem("usage", error.exit_code, text, faults)
    else:
        note(text if _asks_for_help(error) else f"damperlab: {text}")
        if not _asks_for_help(error):
            note("`damperlab --help` lists the commands, `damperlab COMMAND --help` their options.")
    return error.exit_code


def _ratio_for(error: typer.TyperException) -> str:
    """Write a message that names the ratio to give instead of an SI quantity.

    Return "" if the command has no such ratio.
    """
    option, context = getattr(error, "option_name", None), getattr(error, "ctx", None)
    if option is None or context is None:
        return ""
    name = option.lstrip("-").replace("-", "_")
    ratio = RATIOS.get(ALIASES.get(name, name), "")
    if not any(option_of(ratio) in each.opts for each in context.command.params):
        return ""
    return f"This command has no {option}, because it takes ratios: give {option_of(ratio)}, the {DIMENSION_LONG_NAMES[ratio]}."


def _faults_of_value(error: typer.TyperException) -> tuple[Fault, ...]:
    """Convert an error of the option parser into faults.

    Return an empty tuple if the error's own message is readable.
    """
    cause, param = error.__cause__, getattr(error, "param", None)
    if cause is None or param is None:
        return ()
    from pydantic import ValidationError

    from damperlab.studies.pydantic_faults import value_fault

    if not isinstance(cause, ValidationError):
        return ()
    field = param.opts[0] if param.opts[0].startswith("-") else param.human_readable_name
    entries = [each for each in cause.errors(include_url=False) if each["type"] != "value_error"]
    faults = (value_fault(field, each) for each in entries)
    return tuple(replace(each, allowed=f"{each.allowed}{_bounds(param, each.allowed)}") for each in faults)


def _bounds(option: object, allowed: str) -> str:
    """Write the limits of a numeric option.

    The text is empty if the option has no limits, or if `allowed` states them.
    """
    low, high = getattr(option, "min", None), getattr(option, "max", None)
    if "number" not in allowed:
        return ""
    if low is not None and high is not None:
        return f" from {low:,} to {high:,}"
    return f" of at least {low:,}" if low is not None else f" of at most {high:,}" if high is not None else ""


def _with_nearest(text: str) -> str:
    """If a message lists the allowed choices, add the choice that was probably meant."""
    found = re.search(r"'([^']*)' is not one of (.+)\.$", text)
    near = nearest(found[1], re.findall(r"'([^']*)'", found[2])) if found else None
    return f"{text} Did you mean {near}?" if near else text


def _spelled(text: str) -> str:
    """Replace field names in a message (`field` or `field=value`) by the options of the command line."""
    text = re.sub(r"`(\w+)`", lambda found: SPELLED.get(found[1], found[0]), text)
    return re.sub(r"`(\w+)=([^`]*)`", lambda found: _with_value(found[1], found[2]) or found[0], text)


def _with_value(name: str, value: str) -> str:
    """Write the name and the value as an option. Return "" if the name is neither a field nor a dimension."""
    option = SPELLED.get(name) or (option_of(name) if name in EVERY_AXIS else "")
    return f"{option} {value}".rstrip() if option else ""


def _kebab(name: str) -> str:
    return re.sub(r"(?<!^)(?=[A-Z])", "-", name).lower()


def _asks_for_help(error: typer.TyperException) -> bool:
    """Return whether a command was called without arguments.

    The message of such an error is the help of the command.
    """
    return type(error).__name__ == "NoArgsIsHelpError"


def _print_problem(kind: str, status: int, detail: str, faults: tuple[Fault, ...]) -> None:
    print_json(
        {
            "type": f"urn:damperlab:problem:{kind}",
            "title": "Bad usage" if status == BAD_USAGE else "Failed",
            "exit_status": status,
            "detail": detail,
            "errors": [fault.document() for fault in faults],
        }
    )
