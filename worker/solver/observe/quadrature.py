"""Nodes and weights of a meter's quadrature rules over a segment."""

import numpy as np
from numpy.typing import NDArray

# Gauss–Legendre rule on [0, 1] with 5 points, exact to degree 9.
# On the longest panel, the error is below 1e-13 of the integrand.
# NumPy would compute the nodes from eigenvalues, whose last bits depend on the processor.
GAUSS_NODES: NDArray[np.float64] = np.array(
    [0.046910077030668004, 0.23076534494715845, 0.5, 0.7692346550528415, 0.953089922969332]
)
GAUSS_WEIGHTS: NDArray[np.float64] = np.array(
    [0.11846344252809454, 0.23931433524968324, 0.28444444444444444, 0.23931433524968324, 0.11846344252809454]
)
GAUSS = 5
