"""The largest multiplier of an orbit, as numpy finds it."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.typing import NDArray
from tests.worker.forms import both, in_form

from damperlab.worker.steady.stability.multipliers import spectral_radius


@both
@given(matrix=arrays(np.float64, (4, 4), elements=st.floats(-1e6, 1e6, allow_subnormal=False)))
def test_the_spectral_radius_is_the_largest_eigenvalue_of_the_leading_block(
    form: str, matrix: NDArray[np.float64]
) -> None:
    given_matrix = matrix.copy()
    found = in_form(spectral_radius, form)(matrix, 3)
    np.testing.assert_array_equal(matrix, given_matrix)
    # squaring goes wrong where eigenvalues are defective by the square root of rounding and more, as any method does
    scale = np.abs(matrix[:3, :3]).max()
    assert abs(found - np.abs(np.linalg.eigvals(matrix[:3, :3])).max()) <= 1e-4 * scale
