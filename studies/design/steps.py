"""Steps of a search, which request points. The parts after the search advance side by side and share the budget."""

from collections.abc import Callable, Generator
from typing import TypeVar

from damperlab.studies.definition import Study
from damperlab.studies.design.book import Book, BudgetSpent, Wanted
from damperlab.studies.faults import counted
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


def in_studies(book: Book, step: Step[T]) -> Generator[Studies, None, T]:
    """Yield the studies that a step needs next, and return the result of the step.

    The step receives `BudgetSpent` if its studies would have more points than the book has left, or if the caller
    refuses the studies by throwing `BudgetSpent`.
    """
    try:
        wanted = next(step)
        while True:
            studies = wanted if isinstance(wanted, tuple) else book.studies(wanted)
            points = points_of(studies)
            try:
                if points > book.left:
                    raise BudgetSpent
                if studies:
                    yield studies
            except BudgetSpent as spent:
                wanted = step.throw(spent)
            else:
                wanted = step.send(points)
    except StopIteration as end:
        result: T = end.value
        return result


def points_of(studies: Studies) -> int:
    """Return the number of points of studies."""
    return sum(study.points for study in studies)


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
    left_out = yield from _side_by_side(book, parts)
    for name in list(left_out):
        if not (yield from _side_by_side(book, {name: parts[name]})):
            left_out.remove(name)
    return left_out


def _side_by_side(book: Book, parts: dict[str, Part]) -> Step[list[str]]:
    """Carry out parts together: in each round, the next studies of all parts are requested.

    A part that would exceed its share waits. When all parts wait, the one that needs the fewest points continues with
    the points that other parts have left.
    """
    share = book.left // max(len(parts), 1)
    left = dict.fromkeys(parts, share)
    going = {name: in_studies(book, part(share)) for name, part in parts.items()}
    waiting: dict[str, Studies] = {}
    whole: dict[str, bool] = {}

    def resume(name: str, error: BudgetSpent | None = None) -> None:
        try:
            waiting[name] = going[name].throw(error) if error else next(going[name])
        except StopIteration as end:
            whole[name] = end.value
        except BudgetSpent:
            whole[name] = False

    while True:
        for name in [name for name in going if name not in waiting and name not in whole]:
            resume(name)
        if not waiting:
            return [name for name in parts if not whole[name]]
        points = {name: points_of(waiting[name]) for name in parts if name in waiting}
        chosen = [name for name in points if points[name] <= left[name]]
        if not chosen or sum(points[name] for name in chosen) > book.left:
            chosen = [min(points, key=lambda name: points[name])]
        if points[chosen[0]] > book.left:
            del waiting[chosen[0]]
            resume(chosen[0], BudgetSpent())
            continue
        others = counted(len(chosen) - 1, "other comparison")
        book.stage = chosen[0] if len(chosen) == 1 else f"{chosen[0]} and {others}"
        for name in chosen:
            left[name] -= points[name]
        yield tuple({study.digest: study for name in chosen for study in waiting.pop(name)}.values())
