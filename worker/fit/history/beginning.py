"""The first part of a time history, called a beginning, and the parameters that were fitted to it."""

from dataclasses import dataclass

import numpy as np
from scipy.special import chdtri

from damperlab.worker.fit.history.spread import Spread
from damperlab.worker.fit.history.trials import Place, Trials

SURPRISE = 1e-3
"""Probability that the parameters fitted to a longer beginning are rejected although they are correct."""
DEVIATIONS = 3.0
"""Largest difference of two variances, in standard deviations, that is attributed to chance."""


@dataclass(frozen=True)
class Beginning:
    """The first samples of a time history, and the parameters fitted to them.

    Parameters
    ----------
    rows : int
        Number of samples in the beginning.
    places : list of Place
        Best parameter sets for the beginning, in order of increasing misfit.
    spread : Spread
        Uncertainty of the parameters.
    tried : tuple of Place
        Further parameter sets that were compared with the beginning.
    """

    rows: int
    places: list[Place]
    spread: Spread
    tried: tuple[Place, ...] = ()

    @property
    def best(self) -> Place:
        """The best parameter set."""
        return self.places[0]

    def above(self, place: Place, trials: Trials) -> float:
        """Return the chi-square of a parameter set minus that of the best set, over this beginning."""
        return (place.squares - self.best.squares) / trials.variance(self.best.squares, self.rows)

    def scatters_like(self, place: Place, rows: int, trials: Trials) -> bool:
        """Return whether the residuals are not significantly larger over a longer beginning than over this one."""
        count = place.shares.size
        here, there = (one.squares / (size - count) for one, size in ((self.best, self.rows), (place, rows)))
        allowed = 1.0 + DEVIATIONS * np.sqrt(2.0 / (self.rows - count) + 2.0 / (rows - count))
        return bool(there <= allowed * max(here, trials.variance(0.0, rows)))

    def agrees(self, place: Place, rows: int, trials: Trials) -> bool:
        """Return whether the best parameters of a longer beginning also fit this beginning.

        Because late impacts make chi-square rugged, a parameter set may fit a longer beginning by chance. A parameter
        set that fits only by chance does not fit this shorter beginning.
        """
        over_this = trials.place(place.shares, self.rows)
        limit = chdtri(place.shares.size, SURPRISE)
        # the misfit of the best parameters measures the error of the model
        unit = max(1.0, self.best.squares / (self.rows * trials.variance(self.best.squares, self.rows)))
        return self.above(over_this, trials) <= limit * unit and self.scatters_like(place, rows, trials)
