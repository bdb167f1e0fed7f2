"""What is known of a design and what is not, in words: what was looked at, and what ended the search."""

from collections.abc import Iterator

from damperlab.studies.design.found import Found
from damperlab.studies.faults import counted
from damperlab.studies.specification.specification import JUDGES


def words_of_known(found: Found) -> Iterator[str]:
    """Say what was computed, what ended it, and what it left out."""
    spent, budget = found.book.spent, found.book.budget
    computed = f"{counted(spent, 'point')} {'was' if spent == 1 else 'were'} computed"
    dampers = counted(found.looked_at, "damper")
    told = {
        "budget": f"{computed}: the budget of {budget:,} ended the search after {dampers}.",
        "converged": f"{computed}. The search looked at {dampers} and ended where none beside the best was better.",
        "lists": f"{computed}. The search looked at every combination of the values listed.",
        "nothing": f"{computed}. There was nothing to search: the limits leave one damper.",
    }[found.ended]
    if not found.asked.free:
        ended = f", where the budget of {budget:,} ended it" if found.stopped == "budget" else ""
        told = f"Nothing was to be chosen: this is an assessment of the damper that was given. {computed}{ended}."
    yield told
    if found.left_out:
        yield f"The budget did not allow: {'; '.join(found.left_out)}."
    better = (
        " A better damper elsewhere in the ranges cannot be excluded."
        if found.ended in ("budget", "converged")
        else ""
    )
    counts = f"Where there are several responses, {JUDGES[found.asked.judge]} counts."
    yield f"{'Every response is the one reached from rest.' if found.asked.judge == 'rest' else counts}{better}"
