"""A beginning of a time history that some parameters describe and predict."""

from dataclasses import dataclass

import numpy as np
from scipy.special import chdtri

from damperlab.worker.fit.history.spread import Spread
from damperlab.worker.fit.history.trials import Place, Trials

SURPRISE = 1e-3
"""Probability that a longer beginning is rejected although its parameters are right."""
DEVIATIONS = 3.0
"""Two variances count as equal if they differ by at most this number of standard deviations."""


@dataclass(frozen=True)
class Beginning:
    """A beginning, and its result.

    Parameters
    ----------
    rows : int
        Number of its samples.
    places : list of Place
        The best parameters over it, the best first.
    spread : Spread
        Their uncertainty.
    tried : tuple of Place
        Parameter sets drawn around the best, over the same samples.
    """

    rows: int
    places: list[Place]
    spread: Spread
    tried: tuple[Place, ...] = ()

    @property
    def best(self) -> Place:
        """The best parameters."""
        return self.places[0]

    def above(self, place: Place, trials: Trials) -> float:
        """Chi-square of a parameter set over this beginning, minus that of the best."""
        return (place.squares - self.best.squares) / trials.variance(self.best.squares, self.rows)

    def scatters_like(self, place: Place, rows: int, trials: Trials) -> bool:
        """Whether residuals over a longer beginning are no larger than over this one, apart from chance."""
        count = place.shares.size
        here, there = (one.squares / (size - count) for one, size in ((self.best, self.rows), (place, rows)))
        allowed = 1.0 + DEVIATIONS * np.sqrt(2.0 / (self.rows - count) + 2.0 / (rows - count))
        return bool(there <= allowed * max(here, trials.variance(0.0, rows)))

    def agrees(self, place: Place, rows: int, trials: Trials) -> bool:
        """Whether parameters of a longer beginning describe this one about as well as its own do.

        Late impacts make chi-square rugged, so that some parameter sets fit a longer beginning by chance; they fit its
        first part worse.
        """
        over_this = trials.place(place.shares, self.rows)
        limit = chdtri(place.shares.size, SURPRISE)
        # if the model is not quite right, its own misfit measures the uncertainty
        unit = max(1.0, self.best.squares / (self.rows * trials.variance(self.best.squares, self.rows)))
        return self.above(over_this, trials) <= limit * unit and self.scatters_like(place, rows, trials)
