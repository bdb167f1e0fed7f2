"""The chi-square distribution, as far as a goodness of fit needs it."""

from math import exp, inf, lgamma, log, sqrt

_PRECISION = 1e-15
_TINY = 1e-300
_MOST_TERMS = 100_000


def chi_square_probability(value: float, freedom: float) -> float:
    """Probability that chi-square exceeds a value by chance.

    Parameters
    ----------
    value : float
        Of chi-square, at least 0.
    freedom : float
        Degrees of freedom, above 0.

    Returns
    -------
    float
        The upper regularised incomplete gamma function Q(freedom/2, value/2): by its series below the mean and its
        continued fraction (Lentz) above it.
    """
    a, x = 0.5 * freedom, 0.5 * value
    if x <= 0.0:
        return 1.0
    if x == inf:
        return 0.0
    front = exp(a * log(x) - x - lgamma(a))
    if x < a + 1.0:
        term = total = 1.0 / a
        for n in range(1, _MOST_TERMS):
            term *= x / (a + n)
            total += term
            if term < _PRECISION * total:
                break
        return max(0.0, 1.0 - front * total)
    b = x + 1.0 - a
    c, d = 1.0 / _TINY, 1.0 / b
    fraction = d
    for n in range(1, _MOST_TERMS):
        numerator = -n * (n - a)
        b += 2.0
        d = 1.0 / (numerator * d + b or _TINY)
        c = b + numerator / c or _TINY
        factor = c * d
        fraction *= factor
        if abs(factor - 1.0) < _PRECISION:
            break
    return front * fraction


def chi_square_limit(probability: float, freedom: float) -> float:
    """Value that chi-square exceeds with a probability: found by bisection, to rounding."""
    low, high = 0.0, freedom + 40.0 + 40.0 * sqrt(freedom)
    while chi_square_probability(high, freedom) > probability:
        high *= 2.0
    for _ in range(80):
        middle = 0.5 * (low + high)
        if chi_square_probability(middle, freedom) > probability:
            low = middle
        else:
            high = middle
    return high
