"""The error for a question that a study cannot answer."""

from typing import Any, Literal, get_args, get_origin

import numpy as np

from damperlab.studies.faults import Fault, counted, describe, listing
from damperlab.studies.field import admits, fields_of, words_of
from damperlab.studies.user_error import UserError


class QueryFault(UserError, ValueError):
    """A question that a study cannot answer. The message says what is wrong, and what to ask instead.

    Parameters
    ----------
    fault : Fault
        The argument, the value found, the allowed values and the advice.
    """

    def __init__(self, fault: Fault) -> None:
        super().__init__(str(fault))
        self.fault = fault

    def __reduce__(self) -> tuple[type["QueryFault"], tuple[Fault]]:
        """Pickle `fault` alone. Another process recreates the exception from it."""
        return type(self), (self.fault,)


def refused(field: str, found: str, allowed: str, advice: str, told: str = "") -> QueryFault:
    """Make the error for a question with an argument that is not allowed. `told` replaces the default sentence."""
    return QueryFault(Fault(field, found, allowed, advice, told))


def check_question(question: object) -> None:
    """Raise `QueryFault` for the first field of a question that has a number or word that is not allowed."""
    kind: Any = type(question)
    for each in fields_of(kind):
        value, limited = getattr(question, each.name), words_of(each)
        words = get_args(each.core) if get_origin(each.core) is Literal else ()
        if value is None or not (limited or words):
            continue
        if value not in words if words else not admits(each, value):
            usual = "leave it out" if each.default is None else f"the default is {each.default}"
            advice = "correct it" if each.needed else f"correct it; {usual}"
            allowed = f"one of {listing(words)}" if words else limited
            raise refused(each.name, describe(value), allowed, advice)


def empty_range(field: str, name: str, low: float, high: float, values: np.ndarray) -> Fault:
    """Make the fault for a range from `low` to `high` that contains no value of the dimension `name`."""
    least, most = f"{values.min():.10g}", f"{values.max():.10g}"
    held = f"{counted(values.size, 'value')} from {least} to {most}" if values.size > 1 else f"only {least}"
    near = values[np.abs(values - low).argmin()]
    return Fault(
        field,
        f"{low:.10g} to {high:.10g}",
        f"a range that contains a value of {name}",
        f"widen it; the nearest value is {near:.10g}",
        f"The range of {name} from {low:.10g} to {high:.10g} contains none of its values; the study has {held}.",
    )
