import pytest
from scipy.stats import chi2

from damperlab.studies.fit.chi_square import chi_square_limit, chi_square_probability


@pytest.mark.parametrize("freedom", [1.0, 2.0, 7.0, 23.0, 400.0])
@pytest.mark.parametrize("over_mean", [0.01, 0.3, 0.99, 1.01, 1.5, 3.0])
def test_the_probability_is_that_of_another_implementation(freedom: float, over_mean: float) -> None:
    value = over_mean * freedom
    # Both sum some 100 terms of rounding 1e-16, and the front factor's exponent of up to 400 loses three digits.
    assert chi_square_probability(value, freedom) == pytest.approx(chi2.sf(value, freedom), rel=1e-11)


def test_of_two_degrees_of_freedom_it_is_exponential_and_its_ends_are_exact() -> None:
    assert chi_square_probability(3.0, 2.0) == pytest.approx(2.718281828459045**-1.5, rel=1e-14)
    assert chi_square_probability(0.0, 5.0) == 1.0
    assert chi_square_probability(float("inf"), 5.0) == 0.0


@pytest.mark.parametrize("freedom", [1.0, 3.0, 60.0])
@pytest.mark.parametrize("probability", [0.5, 0.05, 1e-4, 1e-12])
def test_a_limit_is_exceeded_with_its_probability(probability: float, freedom: float) -> None:
    # Bisected 80 times, to rounding; the upper tail keeps eleven digits, and its slope is of the order of itself.
    assert chi_square_limit(probability, freedom) == pytest.approx(chi2.isf(probability, freedom), rel=1e-10)
