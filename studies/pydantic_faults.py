"""Translation of validation errors of pydantic into faults of a study."""

import re
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from pydantic import ValidationError

from damperlab.studies.faults import NOTHING, Fault, StudyFaults, describe, path, sentence, unknown_key
from damperlab.studies.spelled_numbers import NUMBER_ALONE, number_advice

_CHOICES = ("contact", "solver", "start")
"""Fields with a choice of models. pydantic adds the name of the chosen model to the location of an error."""


_ALLOWED = {
    "bool_parsing": "true or false",
    "int_parsing": "a whole number",
    "int_from_float": "a whole number",
    "int_parsing_size": "a whole number of fewer digits",
    "float_parsing": "a number",
    "finite_number": "a finite number",
    "greater_than_equal": "at least {ge:.15g}",
    "greater_than": "above {gt:.15g}",
    "less_than_equal": "at most {le:.15g}",
    "less_than": "below {lt:.15g}",
    "string_too_short": "a text of {min_length} or more characters",
    "string_too_long": "a text of at most {max_length} characters",
    "string_pattern_mismatch": "a text of the form {pattern}",
    "byte_size": "a size, such as 50GB",
    "byte_size_unit": "a size, such as 50GB",
}
"""Allowed values in words, by the type of a pydantic error."""
_NUMBER = re.compile(r"\s*[-+]?[0-9.]{1,30}(e[-+]?[0-9]{1,3})?\s*", re.IGNORECASE)
_CHOSEN = ("literal_error", "enum")


def value_fault(field: str, found: Mapping[str, Any]) -> Fault:
    """Translate an error of pydantic about one value.

    Parameters
    ----------
    field : str
        Name of the value for the user: a key, a request parameter or an option.
    found : mapping
        One entry of ``ValidationError.errors()``.
    """
    kind, context = str(found["type"]), found.get("ctx", {})
    if kind in _CHOSEN:
        return Fault(
            field, _given(found["input"]), context["expected"].replace("'", ""), "choose one of these"
        )
    if kind in _ALLOWED:
        advice = "correct the value"
        if kind == "float_parsing":
            spelled = number_advice(found["input"])
            advice = advice if spelled == NUMBER_ALONE else spelled
        return Fault(field, _given(found["input"]), _ALLOWED[kind].format_map(context), advice)
    message = str(found["msg"]).removeprefix("Value error, ")
    bound = message.removeprefix("Input should be ")
    told = "" if bound != message else f"{{field}} is {_given(found['input'])}. {sentence(message)}"
    return Fault(field, _given(found["input"]), bound, "correct the value", told)


def _given(value: object) -> str:
    """Describe a value.

    A text that is a number is shown without quotes, because every value in a URL or an option is a text.
    """
    return value.strip() if isinstance(value, str) and _NUMBER.fullmatch(value) else describe(value)


def faults_of(
    error: ValidationError, keys: Mapping[str, tuple[str, ...]], document: object = None
) -> list[Fault]:
    """Translate all errors of a validation into faults.

    Parameters
    ----------
    error : ValidationError
        The exception.
    keys : mapping of str to tuple of str
        Allowed keys of the mapping at each path, for advice. The path of the whole document is ``""``.
    document : object
        The validated document. Keys that the document already has are not suggested.
    """
    faults: list[Fault] = []
    for found in error.errors(include_url=False):
        where = list(found["loc"])
        parent = path(where[:-1])
        beside = document
        if len(where) > 1 and where[0] in _CHOICES:
            del where[1]
        for part in where[:-1]:
            beside = beside.get(part) if isinstance(beside, Mapping) else None
        there = tuple(beside) if isinstance(beside, Mapping) else ()
        faults.extend(_translate(path(where), keys.get(parent, ()), found, keys, there))
    return faults


def _translate(
    field: str,
    known: tuple[str, ...],
    found: Any,
    keys: Mapping[str, tuple[str, ...]],
    beside: tuple[object, ...],
) -> list[Fault]:
    kind, value, context = found["type"], found["input"], found.get("ctx", {})
    if kind == "value_error" and isinstance(context.get("error"), StudyFaults):
        return [fault.under(field) for fault in context["error"].faults]
    if kind in ("extra_forbidden", "invalid_key"):
        return [_unknown(field, found["loc"][-1], known, keys, beside)]
    if kind == "missing":
        return [Fault(field, NOTHING, "a value", f"add `{found['loc'][-1]}`", "{field} is missing.")]
    if kind == "model_type":
        allowed = f"a mapping of {', '.join(keys.get(field, ()))}"
        return [Fault(field, describe(value), allowed, "write keys and values")]
    return [value_fault(field, found)]


def _unknown(
    field: str,
    key: object,
    known: tuple[str, ...],
    keys: Mapping[str, tuple[str, ...]],
    beside: tuple[object, ...],
) -> Fault:
    fault = unknown_key(field, key, known, beside)
    homes = [place for place, names in keys.items() if key in names and "." not in place]
    if not homes:
        return fault
    advice = f"write it inside `{homes[0]}`" if homes[0] else "write it at the top of the document, outside"
    return replace(fault, advice=advice, meant=str(key))
