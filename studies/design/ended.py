"""Which criterion ended a search, and what it left open."""

from dataclasses import dataclass

from damperlab.studies.design.contenders import contenders_of
from damperlab.studies.design.lattice import FINEST
from damperlab.studies.design.search import Search


@dataclass(frozen=True)
class Ended:
    """How a search ended.

    Parameters
    ----------
    criterion : str
        "tolerances": steps of what is chosen are as fine as anybody can build; "finest": as fine as any are taken; "noise":
        halving them gained less than the error of a response that does not repeat; "lists": every combination of the values
        listed was looked at; "budget": the share of the budget that a search may take was spent; "nothing": there was
        nothing to choose.
    step : float
        The last step, as a share of the ranges.
    open : int
        Dampers that may be better by what is known of them and were not judged with their tolerances; 0 without tolerances.
    """

    criterion: str
    step: float
    open: int


def ended_of(search: Search) -> Ended:
    """Say how a search ended; without touching what it knows."""
    return Ended(_criterion(search), search.step, len(contenders_of(search)) if search.corners else 0)


def _criterion(search: Search) -> str:
    if search.stopped:
        return search.stopped
    if not search.lattice.names:
        return "nothing"
    if search.lattice.whole(search.pool):
        return "lists"
    if not search.lattice.fine(search.step):
        return "noise"
    return "finest" if search.step / 2 < FINEST else "tolerances"
