"""Steps of a search: each asks for points that it needs. What comes after the search shares the budget that is left."""

from collections.abc import Callable, Generator
from math import inf
from typing import TypeVar

from damperlab.studies.definition import Study
from damperlab.studies.design.book import Book, BudgetSpent, Wanted
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


Part = Callable[[int], Step[bool]]
"""Given how many points of the book there may be after it, takes what it needs, and says whether it had all of it."""


def share_out(book: Book, parts: dict[str, Part]) -> Step[list[str]]:
    """Take parts, each with an equal share of what is left, the one whose first look costs least first.

    What one does not take goes to those after it. Those that were cut short go on with all that is left then, in the same
    order: what they know already costs nothing.

    Parameters
    ----------
    book : Book
        Whose budget is divided.
    parts : dict of Part
        By name; an answer lists the names of those that the budget did not allow.

    Returns
    -------
    list of str
        Those that were cut short for good.
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
    """Give the points of the first look that a part takes."""
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
