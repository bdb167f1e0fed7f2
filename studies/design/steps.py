"""Steps of a search, which request points. The steps after the search share the remaining budget."""

from collections.abc import Callable, Generator
from math import inf
from typing import TypeVar

from damperlab.studies.definition import Study
from damperlab.studies.design.book import Book, BudgetSpent, Wanted
from damperlab.studies.ground.suite import Suite

T = TypeVar("T")
Step = Generator[list[Wanted] | tuple[Study | Suite, ...], None, T]
"""A step of a search: a generator that yields the points or the studies that it needs next."""


def within(step: Step[T], left_out: list[str], what: str) -> Step[T | None]:
    """Carry out a step after the search; if the budget does not cover it, add `what` to `left_out`."""
    try:
        return (yield from step)
    except BudgetSpent:
        left_out.append(what)
        return None


Part = Callable[[int], Step[bool]]
"""A part of a search: a function that receives the largest number of points in the book, and returns whether this
number was sufficient.
"""


def share_out(book: Book, parts: dict[str, Part]) -> Step[list[str]]:
    """Carry out parts of a search, each with an equal share of the remaining budget.

    The part whose first step needs the fewest points comes first. Points that a part does not need are shared
    by the later parts. The parts that ran out of points are then repeated in the same order, each with all
    points that are left. Points that are already computed cost nothing.

    Parameters
    ----------
    book : Book
        The book of the search, whose budget is divided.
    parts : dict of Part
        The parts by name; an answer lists the names of the parts that the budget did not cover.

    Returns
    -------
    list of str
        Names of the incomplete parts.
    """
    names = sorted(parts, key=lambda name: _first_cost(book, parts[name]))
    cut = []
    for place, name in enumerate(names):
        share = book.left // (len(names) - place)
        if not (yield from _whole(book, name, parts[name], book.spent + share)):
            cut.append(name)
    left_out = list(cut)
    for name in cut:
        if (yield from _whole(book, name, parts[name], book.budget)):
            left_out.remove(name)
    return left_out


def _whole(book: Book, name: str, part: Part, most: int) -> Step[bool]:
    book.stage = name
    try:
        return (yield from part(most))
    except BudgetSpent:
        return False


def _first_cost(book: Book, part: Part) -> float:
    """Return the number of points that a part computes in its first step."""
    steps = part(book.budget)
    try:
        wanted = next(steps)
    except StopIteration:
        return 0
    except BudgetSpent:
        return inf
    finally:
        steps.close()
    return sum(each.points for each in wanted) if isinstance(wanted, tuple) else book.lacking(wanted)
