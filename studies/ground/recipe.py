"""Functions that all generated records share: read numbers from a document, and compute the envelope of a motion."""

from collections.abc import Mapping
from functools import partial
from math import isnan
from typing import Any

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.faults import NOTHING, Fault, StudyFaults, attempt, describe, path, unknown_key
from damperlab.studies.ground.motion import MOST_SAMPLES
from damperlab.studies.quantity import Quantity, read_count

Floats = NDArray[np.float64]
MOST_LETTERS = 200
LARGEST_SEED = 2**63 - 1
SEED_SCHEMA = {"seed": {"type": "integer", "minimum": 0, "maximum": LARGEST_SEED, "default": 0}}
Numbers = Mapping[str, tuple[Quantity, float | None]]
"""Bounds and default of each number. The default is None for a required number, and `OPTIONAL` for an optional one."""
OPTIONAL = float("nan")
"""Marks an optional number, which has no default."""


def read_numbers(
    document: object,
    place: str,
    numbers: Numbers,
    others: tuple[str, ...],
    example: str,
) -> tuple[Mapping[Any, Any], dict[str, float], list[Fault]]:
    """Read the numbers of a generated record, and check its name.

    Parameters
    ----------
    document : object
        The document as written by the user.
    place : str
        Name of the method. The field of every fault begins with this name.
    numbers : Numbers
        Bounds and defaults of the numbers to read.
    others : tuple of str
        Further allowed keys, apart from ``name``.
    example : str
        Example of a valid document, for the advice in faults.

    Returns
    -------
    document : mapping
        The document as a mapping.
    found : dict of float
        The valid numbers of the document, and the defaults of missing numbers.
    faults : list of Fault
        Faults in the keys, the numbers and the name.

    Raises
    ------
    StudyFaults
        If the document is not a mapping.
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
    """Return the JSON schema of a document for `read_numbers`, with further properties and required keys."""
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
    """Return the seed in a document, 0 by default."""
    return attempt(lambda: read_count(document.get("seed", 0), 0, LARGEST_SEED, f"{place}.seed"), 0, faults)


def too_many_samples(field: str, samples: int, why: str, advice: str) -> list[Fault]:
    """Return a fault if a record has too many samples. In the message, `why` explains the number of samples."""
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
    """Return the first known key in a document. Record a fault if the document has none or several."""
    given = [key for key in known if key in document]
    allowed = f"one of {', '.join(known)}"
    if not given:
        told = f"{{field}} does not state {what}: give {allowed}."
        faults.append(Fault(place, NOTHING, allowed, f"add `{usual}`", told))
    for key in given[1:]:
        told = f"{{field}} and `{place}.{given[0]}` both state {what}."
        faults.append(Fault(f"{place}.{key}", describe(document[key]), allowed, "keep one of them", told))
    return given[0] if given else ""


def ramps(time_s: Floats, duration_s: float, rise_s: float, fall_s: float) -> tuple[Floats, Floats, Floats]:
    """Return an envelope that rises from 0 to 1, stays at 1 and falls to 0, with its first and second time derivatives.

    Parameters
    ----------
    time_s : ndarray
        Times from 0 to the end [s].
    duration_s, rise_s, fall_s : float
        Durations of the whole motion, of the rise and of the fall [s]. Rise and fall do not overlap.
    """
    rise, rise_1, rise_2 = _step(time_s / rise_s)
    fall, fall_1, fall_2 = _step((duration_s - time_s) / fall_s)
    return (
        rise * fall,
        rise_1 / rise_s * fall - rise * fall_1 / fall_s,
        rise_2 / rise_s**2 * fall + rise * fall_2 / fall_s**2,
    )


def _step(share: Floats) -> tuple[Floats, Floats, Floats]:
    """Return a smooth step from 0 to 1, and its first two derivatives.

    The first three derivatives of the step are 0 at both ends.
    """
    s = np.clip(share, 0.0, 1.0)
    rest = 1.0 - s
    square, both = s * s, s * rest
    return (
        square * square * (35.0 + s * (-84.0 + s * (70.0 - 20.0 * s))),
        140.0 * both * both * both,
        420.0 * both * both * (1.0 - 2.0 * s),
    )
