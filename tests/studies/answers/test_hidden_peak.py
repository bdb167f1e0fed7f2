"""What may lie between the frequencies of a sampled response."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from damperlab.studies.answers.hidden_peak import HIGHER, hidden, hidden_note, may_hide, whose
from damperlab.studies.answers.notes import sentences_of
from damperlab.studies.answers.phrases import RATIOS
from damperlab.studies.variables import ResponseClass


def test_close_frequencies_hide_nothing_and_distant_ones_do() -> None:
    values = np.full(21, 2.8)
    assert not may_hide(np.linspace(0.8, 1.2, 21), values, 4.46, 0.1)
    assert may_hide(np.array([0.8, 1.0, 1.25]), np.array([2.0, 3.9, 2.0]), 4.46, 0.1)


def _transmitted(r: np.ndarray, damping: float, mass_ratio: float) -> np.ndarray:
    """X/Z of the structure on a shaken base, a mass of β riding on it: a closed form."""
    forcing = 1.0 + (2.0 * damping * r) ** 2
    return np.asarray(np.sqrt(forcing / ((1.0 - (1.0 + mass_ratio) * r * r) ** 2 + (2.0 * damping * r) ** 2)))


@given(
    st.floats(0.002, 0.1),
    st.floats(0.0, 0.3),
    st.floats(0.75, 0.9),
    st.floats(1.1, 1.4),
    st.integers(2, 120),
)
def test_frequencies_that_miss_the_peak_of_a_linear_structure_are_told_from_those_that_see_it(
    damping: float, mass_ratio: float, low: float, high: float, count: int
) -> None:
    """What is missed beyond `HIGHER` is always said; where steps are at most ζ nothing is, and nothing much is missed."""
    r = np.linspace(low, high, count)
    values = _transmitted(r, damping, mass_ratio)
    kinds = np.full((1, count), ResponseClass.LINEAR)
    where = hidden(r, values[None], kinds, np.array([damping]), np.array([mass_ratio]))
    missed = _transmitted(np.linspace(low, high, 20_001), damping, mass_ratio).max() / values.max()
    if r[1] - r[0] <= damping:
        assert not where.any()
        # half a step of ζ/2 off a resonance of half width ζ/√(1 + β) in r: √(1 + (1 + β)/4) at most, to first order in ζ
        assert missed < 1.03 * np.sqrt(1.0 + (1.0 + mass_ratio) / 4.0)
    elif (
        missed > 1.02 * HIGHER
    ):  # what the force on a shaken base changes within a step is no part of the bound
        assert where.any()


def test_the_number_that_is_advised_ends_the_remark_and_holds_the_frequencies_that_are_there() -> None:
    damping = np.array([0.011])
    kinds = np.full((1, 21), ResponseClass.NO_IMPACT)
    r = np.linspace(9.0, 14.0, 21) / 11.3
    where = hidden(r, np.full((1, 21), 30.0), kinds, damping, np.zeros(1))
    words = sentences_of(hidden_note(r, where, damping), RATIOS)
    # ζ = 0.011 and steps of 0.0221: a quarter of the bandwidth is a fifth of a step, at most
    assert "up to 0.0221 apart" in words
    assert words.endswith("num: 101}`.")
    fine = np.linspace(r[0], r[-1], 101)
    assert np.isin(r.round(12), fine.round(12)).all()
    assert not hidden(fine, np.full((1, 101), 30.0), np.full((1, 101), 2), damping, np.zeros(1)).any()
    undamped = sentences_of(hidden_note(r, where, np.zeros(1)), RATIOS)
    assert undamped.endswith("num: 1001}`.")


def test_a_jump_hides_more_than_a_resonance_does_and_a_locked_mass_nothing() -> None:
    """Of the values 2.5 and 2.6 a resonance in between would be 2.64 high, one that is left for another motion 3.0."""
    r, damping, mass = np.array([0.95, 1.0]), np.array([0.01]), np.array([0.0])
    values = np.array([[2.5, 2.6]])
    still, strikes = ResponseClass.NO_IMPACT, ResponseClass.SYMMETRIC
    heavy = np.array([0.1])
    assert not hidden(r, values, np.array([[still, still]]), damping, heavy).any()
    assert hidden(r, values, np.array([[still, strikes]]), damping, heavy).all()
    assert not hidden(r, values, np.array([[still, strikes]]), damping, mass).any()  # a particle without mass
    assert not hidden(r, values, np.array([[-1, -1]]), damping, heavy).any()  # no class is stored
    wide = np.array([0.5, 1.5])
    assert hidden(wide, values, np.array([[still, still]]), damping, heavy).all()
    assert not hidden(wide, values, np.full((1, 2), ResponseClass.LOCKED), damping, heavy).any()
    # a flank rises towards the natural frequencies, from 1/√1.1 to 1
    below, above = np.array([0.9, 0.94]), np.array([1.1, 1.14])
    for r_there, falling in ((below, [2.5, 0.5]), (above, [0.5, 2.5])):
        towards = np.array([falling])
        assert hidden(r_there, towards, np.array([[still, strikes]]), damping, heavy).all()
        assert not hidden(r_there, towards[:, ::-1], np.array([[still, strikes]]), damping, heavy).any()
        assert not hidden(r_there, towards, np.array([[still, still]]), damping, heavy).any()
    assert not hidden(r, np.array([[np.nan, 2.6]]), np.array([[-1, still]]), damping, heavy).any()


def test_a_ranking_counts_whose_peak_may_be_higher() -> None:
    first = {"designs": 2, "listed": 2, "of": 3, "best": True, "with_impacts": False, "recommended": False}
    assert whose([True, False, True], 3, 1) == first
    beyond = {"designs": 1, "listed": 0, "of": 1, "best": False, "with_impacts": True, "recommended": True}
    assert whose([False, True], 1, 1) == beyond
