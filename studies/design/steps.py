"""Steps of a search; each requests points. The steps after the search share the remaining budget."""

from collections.abc import Callable, Generator
from math import inf
from typing import TypeVar

from damperlab.studies.definition import Study
from damperlab.studies.design.book import Book, BudgetSpent, Wanted
from damperlab.studies.ground.suite import Suite

T = TypeVar("T")
Step = Generator[list[Wanted] | tuple[Study | Suite, ...], None, T]
"""A part of a search: yields its next requests."""


def within(step: Step[T], left_out: list[str], what: str) -> Step[T | None]:
    """Take a step after the search; if the budget does not cover it, note that and give None."""
    try:
        return (yield from step)
    except BudgetSpent:
        left_out.append(what)
        return None


Part = Callable[[int], Step[bool]]
"""Receives the number of points that the book may reach, computes what it needs, and returns whether that number was
sufficient.
"""


def share_out(book: Book, parts: dict[str, Part]) -> Step[list[str]]:
    """Carry out parts, each with an equal share of the remaining budget; the part with the cheapest first look comes
    first.

    A part passes on the points that it does not need. Interrupted parts then continue with all of the rest, in the same
    order; their known points cost nothing.

    Parameters
    ----------
    book : Book
        The search whose budget is divided.
    parts : dict of Part
        By name; an answer lists the names of those that the budget did not cover.

    Returns
    -------
    list of str
        The parts that stayed incomplete.
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
    """Give the number of points that the first look of a part needs."""
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
