"""What a fit says of its parameters: bounds, pairs that cannot be told apart, and the digits of an interval."""

import numpy as np
import pytest
from scipy.stats import norm

from damperlab.studies.fit.fitted import OUTLIER, Estimate, Outcome, outlier_limit
from damperlab.studies.fit.verdict import told


def within(name: str, value: float, low: float, high: float, lowest: float, highest: float) -> Estimate:
    """Give an estimate whose range is searched on a linear scale."""
    shares = ((end - lowest) / (highest - lowest) for end in (low, high))
    return Estimate(name, value, low, high, 0.25 * (high - low), lowest, highest, *shares)


DAMPING = within("damping_ratio", 0.004973, 0.004914, 0.005033, 0.0, 0.1)
FRICTION = within("friction_force_n", 30.02, 29.96, 30.08, 0.0, 55.74)


@pytest.mark.parametrize(
    ("estimate", "below", "above"),
    [
        # 80 widths of the interval lie between the interval and 0, though only a twentieth of the range does
        (DAMPING, True, True),
        (within("restitution", 0.985, 0.98, 0.99, 0.0, 1.0), True, True),
        # every value from 0 on agrees as well: a quantile of 2.5 % lies just above the end
        (within("damping_ratio", 0.0003, 0.00001, 0.0009, 0.0, 0.1), False, True),
        (within("restitution", 0.99, 0.9, 0.999, 0.0, 1.0), True, False),
    ],
)
def test_an_interval_reaches_an_end_only_within_a_quarter_of_its_width(
    estimate: Estimate, below: bool, above: bool
) -> None:
    assert (estimate.bounded_below, estimate.bounded_above) == (below, above)


def pairs(first: Estimate, second: Estimate, correlation: float) -> list[tuple[str, str, float]]:
    """Give the pairs that a fit of two parameters calls inseparable."""
    both = np.array([[1.0, correlation], [correlation, 1.0]])
    return Outcome(estimates=(first, second), correlation=both, evaluations=1).alike


def test_parameters_with_narrow_intervals_are_told_apart_whatever_their_correlation() -> None:
    assert pairs(FRICTION, DAMPING, -0.957) == []
    vague = within("damping_ratio", 0.005, 0.004, 0.006, 0.0, 0.1)
    assert pairs(FRICTION, vague, -0.957) == [("friction_force_n", "damping_ratio", -0.957)]
    assert pairs(FRICTION, vague, -0.9) == []


@pytest.mark.parametrize(
    ("value", "half", "said"),
    [
        (12.00004, 0.00026, "natural_frequency_hz = 12.00004 Hz (95 % interval 11.99978 to 12.0003 Hz)."),
        (12.0, 0.3, "natural_frequency_hz = 12 Hz (95 % interval 11.7 to 12.3 Hz)."),
        (12.0, 0.0, "natural_frequency_hz = 12 Hz (95 % interval 12 to 12 Hz)."),
    ],
)
def test_a_narrow_interval_has_the_digits_that_tell_its_ends_apart(
    value: float, half: float, said: str
) -> None:
    estimate = within("natural_frequency_hz", value, value - half, value + half, 10.7, 14.9)
    assert told(0.95, estimate).replace("11.7 Hz", "11.7").replace(" Hz to", " to") == said


@pytest.mark.parametrize("rows", [1, 24, 1000])
def test_of_all_rows_together_one_is_an_outlier_by_chance_once_in_a_hundred(rows: int) -> None:
    assert rows * 2 * norm.sf(outlier_limit(rows)) == pytest.approx(OUTLIER)
