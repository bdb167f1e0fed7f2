"""What may lie between the frequencies of a sampled response."""

from itertools import pairwise

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from damperlab.studies.answers.hidden_peak import may_hide


@given(
    st.floats(0.005, 0.5),
    st.floats(0.0, 0.3),
    st.lists(st.integers(50, 200), min_size=2, max_size=12, unique=True).map(sorted),
)
def test_no_resonance_of_a_linear_structure_is_hidden(
    damping: float, mass_ratio: float, hundredths: list[int]
) -> None:
    """Under a force, with a mass of β that rides on it: X = ((1 − (1 + β) r²)² + 4ζ²r²)^(−1/2), which has a closed form.

    Written as in the bound, its 1/P² is 4ζ²r², which at the ends of an interval is not that of the peak: the bound is asked for
    a peak lower by what r changes in the interval.
    """
    r = np.array(hundredths) / 100.0

    def response(at: np.ndarray) -> np.ndarray:
        return ((1.0 - (1.0 + mass_ratio) * at * at) ** 2 + (2.0 * damping * at) ** 2) ** -0.5

    for low, high in pairwise(r):
        ends = np.array([low, high])
        between = response(np.linspace(low, high, 4001)).max() * low / high
        if between > response(ends).max():
            assert may_hide(ends, response(ends), between, mass_ratio)


def test_close_frequencies_hide_nothing_and_distant_ones_do() -> None:
    values = np.full(21, 2.8)
    assert not may_hide(np.linspace(0.8, 1.2, 21), values, 4.46, 0.1)
    assert may_hide(np.array([0.8, 1.0, 1.25]), np.array([2.0, 3.9, 2.0]), 4.46, 0.1)
