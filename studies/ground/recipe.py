"""What is generated, read from a document: its numbers and its name, with every fault of them."""

from collections.abc import Mapping
from functools import partial
from math import isnan
from typing import Any

from damperlab.studies.faults import NOTHING, Fault, StudyFaults, attempt, describe, path, unknown_key
from damperlab.studies.ground.motion import MOST_SAMPLES
from damperlab.studies.quantity import Quantity, read_count

MOST_LETTERS = 200
LARGEST_SEED = 2**63 - 1
SEED_SCHEMA = {"seed": {"type": "integer", "minimum": 0, "maximum": LARGEST_SEED, "default": 0}}
Numbers = Mapping[str, tuple[Quantity, float | None]]
"""Bounds and default of each number: None where it must be given, `OPTIONAL` where it may be missing."""
OPTIONAL = float("nan")
"""The default of a number that may be missing."""


def read_numbers(
    document: object,
    place: str,
    numbers: Numbers,
    others: tuple[str, ...],
    example: str,
) -> tuple[Mapping[Any, Any], dict[str, float], list[Fault]]:
    """Read the numbers of what is generated, and look at its name.

    Parameters
    ----------
    document : object
        As it is written.
    place : str
        The way of generating it, with which every fault begins.
    numbers : Numbers
        What they are.
    others : tuple of str
        Keys besides these and ``name``.
    example : str
        What to write.

    Returns
    -------
    document : mapping
        The same.
    found : dict of float
        The numbers that are given and valid, and defaults.
    faults : list of Fault
        What is wrong with them.

    Raises
    ------
    StudyFaults
        Where the document is no mapping.
    """
    if not isinstance(document, dict):
        raise StudyFaults([Fault(place, describe(document), "a mapping", f"write {example}")])
    known = (*numbers, *others, "name")
    faults = [unknown_key(path((place, key)), key, known, document) for key in document if key not in known]
    found: dict[str, float] = {}
    for key, (quantity, default) in numbers.items():
        if key in document:
            value = attempt(partial(quantity.read, document[key], f"{place}.{key}"), None, faults)
            found |= {} if value is None else {key: value}
        elif default is None:
            faults.append(Fault(f"{place}.{key}", NOTHING, quantity.allowed, f"add `{key}`"))
        elif not isnan(default):
            found[key] = default
    name = document.get("name", "")
    if not isinstance(name, str) or len(name) > MOST_LETTERS or not name.isprintable():
        faults.append(Fault(f"{place}.name", describe(name), "a short text on one line", "shorten it"))
    return document, found, faults


def schema_of(
    description: str, numbers: Numbers, more: Mapping[str, Any] | None = None, required: tuple[str, ...] = ()
) -> dict[str, Any]:
    """Return the JSON schema of what `read_numbers` reads; `more` properties, and which of them must be there."""
    return {
        "type": "object",
        "description": description,
        "required": [*required, *(name for name, (_, default) in numbers.items() if default is None)],
        "additionalProperties": False,
        "properties": {
            **(more or {}),
            **{name: quantity.schema(default) for name, (quantity, default) in numbers.items()},
            "name": {"type": "string", "maxLength": MOST_LETTERS, "default": ""},
        },
    }


def read_seed(document: Mapping[Any, Any], place: str, faults: list[Fault]) -> int:
    """Read the seed of what is drawn; 0 where none is given."""
    return attempt(lambda: read_count(document.get("seed", 0), 0, LARGEST_SEED, f"{place}.seed"), 0, faults)


def too_many_samples(field: str, samples: int, why: str, advice: str) -> list[Fault]:
    """Refuse a record with more samples than it may have; `why` says what they are."""
    if samples <= MOST_SAMPLES:
        return []
    found, allowed = f"{samples:,} samples", f"at most {MOST_SAMPLES:,} samples"
    told = f"{{field}} makes {found}: {why}; a record may have at most {MOST_SAMPLES:,}."
    return [Fault(field, found, allowed, advice, told)]


def one_of(
    known: Mapping[str, Quantity],
    document: Mapping[Any, Any],
    place: str,
    faults: list[Fault],
    what: str,
    usual: str,
) -> str:
    """Give which of some keys the document has; a fault where it has none, and one for each beyond the first."""
    given = [key for key in known if key in document]
    allowed = f"one of {', '.join(known)}"
    if not given:
        told = f"{{field}} does not say {what}: give {allowed}."
        faults.append(Fault(place, NOTHING, allowed, f"add `{usual}`", told))
    for key in given[1:]:
        told = f"{{field}} and `{place}.{given[0]}` both say {what}."
        faults.append(Fault(f"{place}.{key}", describe(document[key]), allowed, "keep one of them", told))
    return given[0] if given else ""
