"""Steps of a search, which request points. The parts after the search advance side by side and share the budget."""

from collections.abc import Callable, Generator
from math import inf
from typing import TypeVar

from damperlab.studies.definition import Study
from damperlab.studies.design.book import Book, BudgetSpent, Wanted
from damperlab.studies.ground.suite import Suite

T = TypeVar("T")
Studies = tuple[Study | Suite, ...]
Step = Generator[list[Wanted] | Studies, int, T]
"""A step of a search: a generator that yields the points or the studies that it needs next, and receives the number of
points of these studies.
"""


def within(step: Step[T], left_out: list[str], what: str) -> Step[T | None]:
    """Carry out a step after the search; if the budget does not cover it, add `what` to `left_out`."""
    try:
        return (yield from step)
    except BudgetSpent:
        left_out.append(what)
        return None


def in_studies(book: Book, step: Step[T], most: float = inf) -> Generator[Studies, None, T]:
    """Yield the studies that a step needs next, and return the result of the step.

    The step receives `BudgetSpent` if its studies would have more than `most` points altogether, or more points than
    the book has left.
    """
    left = most
    try:
        wanted = next(step)
        while True:
            studies = wanted if isinstance(wanted, tuple) else book.studies(wanted)
            points = sum(study.points for study in studies)
            if points > min(left, book.left):
                wanted = step.throw(BudgetSpent())
                continue
            if studies:
                yield studies
            left -= points
            wanted = step.send(points)
    except StopIteration as end:
        result: T = end.value
        return result


Part = Callable[[int], Step[bool]]
"""A part of a search: a function that receives its largest number of points, and returns whether this number was
sufficient.
"""


def share_out(book: Book, parts: dict[str, Part]) -> Step[list[str]]:
    """Carry out parts of a search side by side, each with an equal share of the remaining budget.

    The parts that ran out of points are then repeated one after the other, each with all points that are left. Points
    that are already computed cost nothing.

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
    left_out = yield from _side_by_side(book, parts, book.left // max(len(parts), 1))
    for name in list(left_out):
        if not (yield from _side_by_side(book, {name: parts[name]}, book.left)):
            left_out.remove(name)
    return left_out


def _side_by_side(book: Book, parts: dict[str, Part], most: int) -> Step[list[str]]:
    """Carry out parts with at most `most` points each. In each round, every part requests its next studies."""
    going = {name: in_studies(book, part(most), most) for name, part in parts.items()}
    whole: dict[str, bool] = {}
    while going:
        asked: dict[str, Study | Suite] = {}
        for name, part in list(going.items()):
            try:
                asked |= {study.digest: study for study in next(part)}
                continue
            except StopIteration as end:
                whole[name] = end.value
            except BudgetSpent:
                whole[name] = False
            del going[name]
        if asked:
            book.stage = ", ".join(going)
            yield tuple(asked.values())
    return [name for name in parts if not whole[name]]
