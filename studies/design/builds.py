"""Random builds within the tolerances, and the probability that a build keeps every limit."""

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from damperlab.studies.design.book import SEED, BudgetSpent, Wanted
from damperlab.studies.design.build import Build
from damperlab.studies.design.frequencies import between
from damperlab.studies.design.score import Score
from damperlab.studies.design.search import CLOSE, Search
from damperlab.studies.design.steps import Step, within
from damperlab.studies.specification.excitation import ONCE, Case
from damperlab.studies.specification.specification import Specification

FOR_BUILDS = 0.5
"""Largest share of the remaining budget for the builds."""
WORST = 5
"""Number of builds with the largest responses, whose peaks are bracketed."""

NEAR = 0.9
"""Share of a limit above which the peaks of a build are bracketed too."""


@dataclass(frozen=True)
class Builds:
    """Results of builds within the tolerances.

    Parameters
    ----------
    drawn, passed : int
        Number of builds drawn, and number of builds that keep every limit. If no result has a limit, these builds must
        also stay within `bound`.
    low, high : float
        Confidence interval of the probability that a build passes.
    bound : float or None
        The additional bound in the unit of the measure; None if the specification limits results.
    """

    drawn: int
    passed: int
    low: float
    high: float
    bound: float | None


def clopper_pearson(passed: int, drawn: int, confidence: float) -> tuple[float, float]:
    """Return the exact confidence interval of a probability from `passed` successes in `drawn` independent trials.

    C. J. Clopper, E. S. Pearson, Biometrika 26 (1934) 404: the tail beyond each end has half of the remaining
    probability, so the ends are quantiles of the beta distribution.
    """
    from scipy.special import betaincinv  # the light client imports this module, and has no scipy

    tail = (1.0 - confidence) / 2.0
    low = 0.0 if passed == 0 else float(betaincinv(passed, drawn - passed + 1, tail))
    high = 1.0 if passed == drawn else float(betaincinv(passed + 1, drawn - passed, 1.0 - tail))
    return low, high


def drawn(search: Search, build: Build) -> Step[list[Build]]:
    """Draw random builds within the tolerances, and compute each build at every frequency of the nominal damper."""
    asked, book = search.asked, search.book
    names = asked.toleranced
    shares = np.random.default_rng(SEED).uniform(-1.0, 1.0, (asked.builds, len(names)))
    every = [build.moved(asked, dict(zip(names, row, strict=True))) for row in shares.tolist()]
    wanted = [list(_beside(search, build, each)) for each in every]
    room = FOR_BUILDS * book.left
    count, cost = 0, 0
    for one in wanted:
        cost += book.lacking(one)
        if cost > room:
            break
        count += 1
    if count == 0:
        raise BudgetSpent
    yield [each for one in wanted[:count] for each in one]
    kept = every[:count]
    likely = sorted(kept, key=lambda each: search.score(each).most)[-WORST:]
    undecided = [each for each in kept if each not in likely and _hardly(asked, search.score(each))]
    yield from within(search.known([*likely, *undecided], CLOSE + 1), [], "")
    yield from within(_looked_at_closer(search, kept), [], "")
    return kept


def _looked_at_closer(search: Search, kept: Iterable[Build]) -> Step[None]:
    """Bracket the peaks of the builds that narrowly keep a limit."""
    wanted = []
    for build in kept:
        if not _hardly(search.asked, search.score(build)):
            continue
        for amplitude in search.amplitudes:
            if isinstance(amplitude, Case):
                continue
            curve = search.book.curve(build, amplitude)
            frequencies = between(curve.r, curve.measured)
            if frequencies:
                wanted.append(Wanted(build, amplitude, frequencies))
    if wanted:
        yield wanted


def _hardly(asked: Specification, score: Score) -> bool:
    """Whether a build satisfies every limit and comes close to at least one limit."""
    near = (score.reached[name] >= NEAR * limit for name, limit in asked.limits.items())
    return score.violation == 0.0 and any(near)


def _beside(search: Search, nominal: Build, build: Build) -> Iterable[Wanted]:
    for amplitude in search.amplitudes:
        if isinstance(amplitude, Case):
            yield Wanted(build, amplitude, ONCE)
            continue
        low, high = build.own(amplitude.excitation.low), build.own(amplitude.excitation.high)
        sampled = search.sample(build, amplitude, True)
        curve = search.book.curve(nominal, amplitude)
        near = [r for r in curve.r.tolist() if low <= r <= high]
        yield Wanted(build, amplitude, tuple(sorted({*sampled, *near})))


def counted_builds(asked: Specification, scores: list[Score], bound: float) -> Builds:
    """Count the builds that keep every limit. If no result has a limit, a build must also stay within `bound`."""
    within = math.inf if asked.limits else bound
    passed = sum(each.violation == 0.0 and each.value <= within for each in scores)
    low, high = clopper_pearson(passed, len(scores), asked.confidence)
    return Builds(len(scores), passed, low, high, None if asked.limits else bound)
