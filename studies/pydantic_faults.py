"""What pydantic found wrong, as faults of the study."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from pydantic import ValidationError

from damperlab.studies.faults import NOTHING, Fault, StudyFaults, describe, path, unknown_key

_CHOICES = ("contact", "solver", "start")
"""Fields that are a choice of models: pydantic puts the name of the choice into the location."""


def faults_of(error: ValidationError, keys: Mapping[str, tuple[str, ...]]) -> list[Fault]:
    """Translate every error that validation of a study raised.

    Parameters
    ----------
    error : ValidationError
        What was raised.
    keys : mapping of str to tuple of str
        The keys that the mapping at each path may have, for advice; ``""`` is the document.
    """
    faults: list[Fault] = []
    for found in error.errors(include_url=False):
        where = list(found["loc"])
        parent = path(where[:-1])
        if len(where) > 1 and where[0] in _CHOICES:
            del where[1]
        faults.extend(_translate(path(where), keys.get(parent, ()), found, keys))
    return faults


def _translate(
    field: str, known: tuple[str, ...], found: Any, keys: Mapping[str, tuple[str, ...]]
) -> list[Fault]:
    kind, value, context = found["type"], found["input"], found.get("ctx", {})
    if kind == "value_error" and isinstance(context.get("error"), StudyFaults):
        return [fault.under(field) for fault in context["error"].faults]
    if kind in ("extra_forbidden", "invalid_key"):
        return [_unknown(field, found["loc"][-1], known, keys)]
    if kind == "missing":
        return [Fault(field, NOTHING, "a value", f"add `{found['loc'][-1]}`", "{field} is missing.")]
    if kind == "literal_error":
        return [Fault(field, describe(value), context["expected"].replace("'", ""), "choose one of these")]
    if kind == "model_type":
        allowed = f"a mapping of {', '.join(keys.get(field, ()))}"
        return [Fault(field, describe(value), allowed, "write keys and values")]
    return [Fault(field, describe(value), "a valid value", found["msg"])]


def _unknown(field: str, key: object, known: tuple[str, ...], keys: Mapping[str, tuple[str, ...]]) -> Fault:
    fault = unknown_key(field, key, known)
    homes = [place for place, names in keys.items() if key in names and "." not in place]
    if not homes:
        return fault
    advice = f"write it inside `{homes[0]}`" if homes[0] else "write it at the top of the document, outside"
    return replace(fault, advice=advice)
