"""How much a search takes."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Effort:
    """How much a search takes.

    Parameters
    ----------
    kept : int
        Candidates around which the lattice is halved.
    finalists : int
        Candidates that are judged with their tolerances.
    rounds : int
        Steps of the search around the best of them.
    reserve : float
        Share of its points that it explores without: for judging the best closely, and of the first search for what follows.
    finest : float
        Step at which it ends in any case; 0 where tolerances and noise decide.
    """

    kept: int = 6
    finalists: int = 8
    rounds: int = 2
    reserve: float = 0.5
    finest: float = 0.0
