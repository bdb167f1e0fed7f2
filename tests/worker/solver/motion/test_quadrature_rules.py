"""Nodes and weights of Gauss and Legendre, against exact arithmetic."""

import mpmath
import numpy as np
import pytest

from damperlab.worker.solver.motion.quadratic_forms import NODES, WEIGHTS
from damperlab.worker.solver.observe.energies import GAUSS_NODES, GAUSS_WEIGHTS


@pytest.mark.parametrize(("nodes", "weights"), [(GAUSS_NODES, GAUSS_WEIGHTS), (NODES, WEIGHTS)])
def test_a_rule_is_that_of_exact_arithmetic_rounded_once(nodes: np.ndarray, weights: np.ndarray) -> None:
    with mpmath.workdps(50):

        def polynomial(x: mpmath.mpf) -> mpmath.mpf:
            return mpmath.legendre(nodes.size, x)

        roots = [mpmath.findroot(polynomial, 2 * mpmath.mpf(float(x)) - 1) for x in nodes]
        slopes = [mpmath.diff(polynomial, x) for x in roots]
        assert nodes.tolist() == [float((x + 1) / 2) for x in roots]
        expected = [float(1 / ((1 - x**2) * slope**2)) for x, slope in zip(roots, slopes, strict=True)]
    assert weights.tolist() == expected
