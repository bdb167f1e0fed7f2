"""The limits of a question's numbers, checked as its fields say."""

from typing import Any

from damperlab.studies.answers.query_fault import QueryFault
from damperlab.studies.faults import Fault, describe
from damperlab.studies.field import admits, fields_of, words_of


def check(question: object) -> None:
    """Raise `QueryFault` for the first number of a question that is not within the limits of its field."""
    kind: Any = type(question)
    for each in fields_of(kind):
        value = getattr(question, each.name)
        limited = words_of(each)
        if limited and value is not None and not admits(each, value):
            advice = (
                "leave it out"
                if each.default is None
                else f"choose one within these limits; the default is {each.default:,}"
            )
            raise QueryFault(Fault(each.name, describe(value), limited, advice))
