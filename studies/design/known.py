"""What is known of a design and what is not, in words: what ended the search, and by how much another damper may be better."""

from collections.abc import Iterator

from damperlab.studies.design.ended import Ended
from damperlab.studies.design.found import Found
from damperlab.studies.design.shortfall import Shortfall
from damperlab.studies.faults import counted

HARDLY = 0.05
"""Per cent below which a damper is not called better."""
TELLS = 50.0
"""Per cent from which on an estimate says nothing."""


def words_of_known(found: Found) -> Iterator[str]:
    """Say what was computed, what ended it, and how far the recommended damper is known to be the best."""
    if found.as_good:
        alone = found.as_good == 1
        dampers = "damper that was" if alone else "dampers that were"
        its = "its" if alone else "their"
        how = f"judged with {its} tolerances" if found.asked.tolerances else "looked at closely"
        yield f"{found.as_good} further {dampers} {how} may be as good within the errors."
    if found.asked.free:
        yield from words_of_ended(found.ended, found.book.spent, found.book.budget)
    else:
        budget = found.book.budget
        ended = f", where the budget of {budget:,} ended it" if found.stopped == "budget" else ""
        yield (
            "Nothing was to be chosen: this is an assessment of the damper that was given. "
            f"{_computed(found.book.spent)}{ended}."
        )
    if found.shortfall is not None and found.compared.most > 0.0:
        yield words_of_shortfall(found.shortfall, found.compared.most)
    if found.left_out:
        yield f"The budget did not allow: {'; '.join(found.left_out)}."
    better = (
        " A better damper that none of its neighbours shows cannot be excluded." if found.asked.free else ""
    )
    yield f"Every response is the one reached from rest.{better}"


def words_of_ended(ended: Ended, spent: int, budget: int) -> list[str]:
    """Say what ended a search of so many points, and what that leaves open."""
    points = _computed(spent)
    steps = f"steps of 1/{round(1 / ended.step)} of the ranges"
    told = {
        "budget": f"{points}: the budget of {budget:,} ended the search, with {steps}.",
        "tolerances": f"{points}. The search ended with {steps}, which are as fine as the tolerances.",
        "finest": f"{points}. The search ended with {steps}, the finest it takes.",
        "noise": f"{points}. The search ended with {steps}: halving them gained less than the error of a response that "
        "does not repeat.",
        "lists": f"{points}. The search ended with every combination of the values listed.",
        "nothing": f"{points}. There was nothing to search: the limits leave one damper.",
    }[ended.criterion]
    if not ended.open:
        return [told]
    which = "damper that may be better was" if ended.open == 1 else "dampers that may be better were"
    return [
        told,
        f"The budget ended before {ended.open} further {which} judged with all corners of their tolerances.",
    ]


def _computed(points: int) -> str:
    return f"{counted(points, 'point')} {'was' if points == 1 else 'were'} computed"


def _digits(per_cent: float) -> str:
    """Write two digits, or a whole number."""
    return f"{per_cent:.2g}" if per_cent < 10.0 else f"{per_cent:.0f}"


def words_of_shortfall(shortfall: Shortfall, most: float) -> str:
    """Say by how much another damper may be better; an estimate of the steepest fall between what was computed says nothing."""
    computed, between = (100.0 * each / most for each in (shortfall.computed, shortfall.between))
    told = "No damper that was looked at is better"
    if computed >= HARDLY:
        told += f" by more than {_digits(computed)} %"
    if HARDLY <= between < TELLS:
        told += f"; one between them may be, by up to {_digits(between)} % (an estimate)"
    return f"{told}."
