"""What a count of builds says about a probability."""

import math
from collections.abc import Callable


def clopper_pearson(passed: int, drawn: int, confidence: float) -> tuple[float, float]:
    """Give the exact interval of a probability of which `passed` of `drawn` independent trials are known.

    C. J. Clopper, E. S. Pearson, Biometrika 26 (1934) 404: each end is where the tail beyond the count has half of what
    the confidence leaves.

    Parameters
    ----------
    passed, drawn : int
        0 ≤ passed ≤ drawn, drawn > 0.
    confidence : float
        Of the two-sided interval, in (0, 1).
    """
    tail = (1.0 - confidence) / 2.0
    low = 0.0 if passed == 0 else _solve(lambda p: at_least(passed, drawn, p) - tail)
    high = 1.0 if passed == drawn else _solve(lambda p: tail - (1.0 - at_least(passed + 1, drawn, p)))
    return low, high


def at_least(passed: int, drawn: int, probability: float) -> float:
    """Give the probability of at least so many passes: the upper tail of the binomial distribution."""
    if passed <= 0:
        return 1.0
    if probability in (0.0, 1.0):
        return probability
    yes, no = math.log(probability), math.log1p(-probability)
    terms = (
        math.lgamma(drawn + 1) - math.lgamma(k + 1) - math.lgamma(drawn - k + 1) + k * yes + (drawn - k) * no
        for k in range(passed, drawn + 1)
    )
    return min(math.fsum(math.exp(term) for term in terms), 1.0)


def _solve(rising: Callable[[float], float]) -> float:
    """Find where a function that rises over [0, 1] is 0, to rounding."""
    low, high = 0.0, 1.0
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (low, middle) if rising(middle) > 0 else (middle, high)
    return (low + high) / 2
