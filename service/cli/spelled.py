"""Errors of a question, expressed in the names of the options that were used."""

import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace

from damperlab.service.cli.failures import UsageFault
from damperlab.studies.faults import Fault, StudyFaults
from damperlab.studies.field import fields_of


def options_of(question: type) -> dict[str, str]:
    """Give the option of each field of a question on the command line, by the field's name in documents."""
    return {each.key: each.options[0] for each in fields_of(question) if "command" in each.doors}


@contextmanager
def in_options(names: Mapping[str, str]) -> "Iterator[None]":
    """Name the options instead of the fields in faults.

    Parameters
    ----------
    names : mapping of str
        Options by field. A setting that an option makes, as ``particle: false``, may be a key too.

    Raises
    ------
    StudyFaults
        The faults that are raised inside the context, with these names.
    UsageFault
        For an error with a single fault, if its field is among these names.
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
    # an item of a list is named by the repeated option
    field = names.get(re.sub(r"\[\d+\]\Z", "", fault.field), fault.field)
    if "." in field:  # a field within a document; the texts name fields of the document too
        return fault
    texts = {part: _in_text(getattr(fault, part), names) for part in ("allowed", "advice", "message")}
    return replace(fault, field=field, **texts)


def _in_text(text: str, names: Mapping[str, str]) -> str:
    """Translate quoted settings in a text, as in `cycles`, `particle: false` or `fit: {restitution: null}`."""
    text = re.sub(r"`fit: \{(.+?)\}`", lambda found: _sought(found[1]), text)
    return re.sub(r"`([^`]+)`", lambda found: names.get(found[1], found[0]), text)


def _sought(entries: str) -> str:
    """Translate the parameters to estimate: ``restitution: null, clearance_m: [LOW, HIGH]``."""
    found = re.findall(r"(\w+): (?:null|\[(\w[\w.]*), (\w[\w.]*)\])", entries)
    return " ".join(f"--fit {name}={low},{high}" if low else f"--fit {name}" for name, low, high in found)
