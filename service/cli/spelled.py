"""Error messages that name options of the command line instead of fields."""

import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace

from damperlab.service.cli.failures import UsageFault
from damperlab.studies.faults import Fault, StudyFaults
from damperlab.studies.field import fields_of


def options_of(question: type) -> dict[str, str]:
    """Map each field of the dataclass `question` to its command-line option.

    The keys are the names of the fields in documents.
    """
    return {each.key: each.options[0] for each in fields_of(question) if "command" in each.doors}


@contextmanager
def in_options(names: Mapping[str, str]) -> "Iterator[None]":
    """In faults raised inside the context, replace the names of fields by the names of options.

    Parameters
    ----------
    names : mapping of str
        Command-line option for each field, or for a field with a value, such as ``particle: false``.

    Raises
    ------
    StudyFaults
        If faults of a study are raised inside the context. The exception names the options.
    UsageFault
        If an error with a single fault is raised inside the context, and the field of the fault is a key of `names`.
    """
    try:
        yield
    except StudyFaults as error:
        raise StudyFaults(_spelled(fault, names) for fault in error.faults) from None
    except Exception as error:
        fault = getattr(error, "fault", None)
        if not isinstance(fault, Fault) or fault.field not in names:
            raise
        raise UsageFault(_spelled(fault, names)) from None


def _spelled(fault: Fault, names: Mapping[str, str]) -> Fault:
    # a fault in one item of a list is reported under the option of the list
    field = names.get(re.sub(r"\[\d+\]\Z", "", fault.field), fault.field)
    # a field within a document keeps its name, because the fault's texts also name other fields
    if "." in field:
        return fault
    texts = {part: _in_text(getattr(fault, part), names) for part in ("allowed", "advice", "message")}
    return replace(fault, field=field, **texts)


def _in_text(text: str, names: Mapping[str, str]) -> str:
    """Replace quoted settings in a text, for example `cycles` or `fit: {restitution: null}`, by options."""
    text = re.sub(r"`fit: \{(.+?)\}`", lambda found: _sought(found[1]), text)
    return re.sub(r"`([^`]+)`", lambda found: names.get(found[1], found[0]), text)


def _sought(entries: str) -> str:
    """Write parameters to estimate, for example ``restitution: null, clearance_m: [LOW, HIGH]``, as options --fit."""
    found = re.findall(r"(\w+): (?:null|\[(\w[\w.]*), (\w[\w.]*)\])", entries)
    return " ".join(f"--fit {name}={low},{high}" if low else f"--fit {name}" for name, low, high in found)
