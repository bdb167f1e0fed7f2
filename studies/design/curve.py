"""What is known of a damper under an amplitude: a response over the frequency."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.specification.measure import Measure


@dataclass(frozen=True)
class Curve:
    """A response over the frequency, over the build's own natural frequency; infinite where it failed.

    Parameters
    ----------
    r : ndarray, (n,)
        Ascending.
    base_m : ndarray, (n,)
        Base amplitude Z; 1 under a record, whose results are in units.
    columns : dict of ndarray, (n,)
        `Book.variables`, or `RECORD_VARIABLES`, the first of them infinite where the response failed.
    measure : Measure
        What shall be small, as it is made of these.
    """

    r: NDArray[np.float64]
    base_m: NDArray[np.float64]
    columns: Mapping[str, NDArray[np.float64]]
    measure: Measure

    def __getitem__(self, name: str) -> NDArray[np.float64]:
        """Give one variable; a point that failed has no value in units, and counts as infinite."""
        failed = np.isinf(next(iter(self.columns.values())))
        if name == "amplitude_error":  # a transient ends where it ends: it is as exact as the solver
            column = self.columns.get(name, np.zeros(self.r.size))
            return np.where(failed, 0.0, column)
        return np.where(failed, np.inf, self.columns[name])

    @property
    def measured(self) -> NDArray[np.float64]:
        """The measure, shape (n,), in its unit."""
        return self.measure.factor * self.base_m * self[self.measure.variable]
