"""A step of a search: what it must know next, and what becomes of one that the budget does not allow."""

from collections.abc import Generator
from typing import TypeVar

from damperlab.studies.definition import Study
from damperlab.studies.design.book import BudgetSpent, Wanted
from damperlab.studies.ground.suite import Suite

T = TypeVar("T")
Step = Generator[list[Wanted] | tuple[Study | Suite, ...], None, T]
"""A part of a search: yields what must be known next."""


def within(step: Step[T], left_out: list[str], what: str) -> Step[T | None]:
    """Take a step that is no part of the search; where the budget does not allow it, note that and give None."""
    try:
        return (yield from step)
    except BudgetSpent:
        left_out.append(what)
        return None
