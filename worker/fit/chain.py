"""Draws samples from a distribution whose density is known up to a factor."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.portable import log

Matrix = NDArray[np.float64]
STRETCH = 2.0
"""Largest factor by which a move stretches a distance, the value of Goodman and Weare (2010)."""


def draw(log_density: Callable[[Matrix], Matrix], walkers: Matrix, steps: int, seed: int) -> Matrix:
    """Draw samples by the affine-invariant stretch move of Goodman and Weare (2010).

    The number of moves that are needed does not grow with the correlation of the parameters.

    Parameters
    ----------
    log_density : callable
        Function from points, shape (n, parameters), to the logarithm of the density; -inf where the density is 0.
    walkers : ndarray, shape (even number, parameters)
        Initial points of the walkers, each with a positive density.
    steps : int
        Number of moves of each walker. The first half of the moves is discarded.
    seed : int
        Seed of the random numbers.

    Returns
    -------
    ndarray, shape (draws, parameters)
        Points of all walkers after each move of the second half.
    """
    generator = np.random.default_rng(seed)
    walkers = walkers.copy()
    count, dimensions = walkers.shape
    half = count // 2
    density = log_density(walkers)
    kept = []
    for step in range(steps):
        for moved, others in ((slice(0, half), slice(half, count)), (slice(half, count), slice(0, half))):
            here = walkers[moved]
            partner = walkers[others][generator.integers(0, half, len(here))]
            root = 1.0 / np.sqrt(STRETCH) + generator.random(len(here)) * (
                np.sqrt(STRETCH) - 1.0 / np.sqrt(STRETCH)
            )
            factor = root**2
            there = partner + factor[:, None] * (here - partner)
            new = log_density(there)
            chance = (dimensions - 1) * log(factor) + new - density[moved]
            taken = log(generator.random(len(here))) < chance
            walkers[moved] = np.where(taken[:, None], there, here)
            density[moved] = np.where(taken, new, density[moved])
        if step >= steps // 2:
            kept.append(walkers.copy())
    return np.concatenate(kept)
