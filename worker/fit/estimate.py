"""Estimates the parameters of a prototype from its measured response by weighted least squares.

The weights include the errors of the model. First, responses are computed at points that coarsely fill the ranges. Then
the search continues around each of the best points, in ever smaller regions. Finally, polynomials of the
parameters approximate the responses within about three standard deviations of the best point (see
`surface.py`). The intervals come from the posterior density over this region (see `chain.py`).
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtrc, chdtri

from damperlab.studies.fit.fitted import DOUBTED, Estimate, Fitted
from damperlab.studies.fit.question import FitQuestion
from damperlab.studies.portable import log
from damperlab.worker.fit.archive import Archive, Progress
from damperlab.worker.fit.chain import draw
from damperlab.worker.fit.model import scenes_of
from damperlab.worker.fit.region import EDGE, RADIUS, Region
from damperlab.worker.fit.singular_values import covariance_of, length_of
from damperlab.worker.fit.surface import Surface, fit_surface, terms
from damperlab.worker.warm import warm

Matrix = NDArray[np.float64]
START = {1: 64, 2: 160, 3: 320, 4: 480, 5: 640}
"""Number of points that coarsely fill the ranges, for each number of parameters."""
FOLLOWED = 3
"""Number of points around which the search continues."""
CLOSER_ROUNDS, CLOSER = 3, 0.6
"""Number of rounds in which a region narrows, and factor on the size of the region per round."""
LEAST_ROUNDS, MOST_ROUNDS, SETTLED = 3, 12, 0.5
"""Smallest and largest number of rounds for the final region, and limit on changes of the region per round.

The rounds end when the motion of the region, in standard deviations, and |log size ratio| are below the limit.
"""
LINEAR = 3.0
"""Residual in standard deviations above which the misfit grows linearly, to limit outliers (Huber 1964)."""
LEAST_SHARE = 1e-6
"""Lower bound of the relative standard deviation, which would be almost 0 for data that the model itself computed."""
AS_GOOD = 6.0
"""Difference of −2 ln L up to which two parameter sets are equally good."""
WALKERS, STEPS, LAST_STEPS = 48, 240, 1200
TRIED = 8
"""Number of likely draws whose responses are computed. The best of these draws is the estimate."""


def fit_response(question: FitQuestion, progress: Progress | None = None) -> Fitted:
    """Estimate the parameters of a prototype from its measured frequency response.

    Parameters
    ----------
    question : FitQuestion
        Result of `damperlab.studies.fit.asking.make_question`.
    progress : callable, optional
        Function called with the number of computed parameter sets.

    Returns
    -------
    Fitted
        Estimates, which are bitwise equal for equal questions and seeds.
    """
    for scene in scenes_of(question):
        warm(scene)
    archive = Archive(question, progress)
    regions = [_closer(archive, region) for region in _begin(archive)]
    ends = [_settled(archive, region) for region in _best_regions(archive, regions)]
    ends.sort(key=lambda end: end.misfit)
    return _fitted(archive, ends)


@dataclass(frozen=True)
class _End:
    """A final region: its polynomials, samples of the posterior density, and the best computed parameter set."""

    surface: Surface
    draws: Matrix
    best: Matrix
    row: int  # index of the best set in the archive
    variance: Matrix
    share: float  # relative standard deviation of the measurement, if it is estimated
    misfit: float  # -2 ln L


def _begin(archive: Archive) -> list[Region]:
    """Compute points that fill the ranges. Return regions around the best of those points that lie far apart."""
    # imported here, because the import is slow
    from scipy.stats.qmc import Halton

    number = START[archive.count]
    # the first point of the sequence, a corner of the ranges, is left out
    archive.add(Halton(archive.count, scramble=False).random(number + 1)[1:])
    spacing = float(number ** (-1.0 / archive.count))
    chosen: list[Matrix] = []
    for row in np.argsort(archive.coarse_misfit(), kind="stable"):
        place = archive.places[row]
        if all(np.abs(place - other).max() > 1.5 * spacing for other in chosen):
            chosen.append(place)
        if len(chosen) == FOLLOWED:
            break
    return [Region(place, 0.6 * spacing * np.eye(archive.count)) for place in chosen]


def _closer(archive: Archive, region: Region) -> Region:
    """Move a region to the best computed point inside, and narrow the region, `CLOSER_ROUNDS` times."""
    for _ in range(CLOSER_ROUNDS):
        before = len(archive.places)
        archive.add(region.draw(8 * (archive.count + 1), archive.generator))
        near = region.holds(archive.places)
        near[before:] = True
        misfit = np.where(near, archive.coarse_misfit(), np.inf)
        region = Region(archive.places[int(np.argmin(misfit))], CLOSER * region.frame)
    return region


def _best_regions(archive: Archive, regions: list[Region]) -> list[Region]:
    """Return the best region. Also return the second-best region if it fits about as well and lies far enough away."""
    misfit = archive.coarse_misfit()
    at = [misfit[int(np.argmin(np.abs(archive.places - one.centre).max(axis=1)))] for one in regions]
    order = np.argsort(at, kind="stable")
    kept = [regions[order[0]]]
    for place in order[1:2]:
        apart = np.abs(regions[place].centre - kept[0].centre).max()
        if at[place] < at[order[0]] + AS_GOOD and apart > 2.0 * np.abs(regions[place].frame).max():
            kept.append(regions[place])
    return kept


def _settled(archive: Archive, region: Region) -> _End:
    """Move and resize a region until it matches the uncertainty of the parameters, and fit polynomials in it."""
    batch = max(20, 3 * terms(archive.count))
    for round_ in range(MOST_ROUNDS):
        archive.add(region.draw(batch, archive.generator))
        surface, variance, share = _laid(archive, region, batch)
        draws = _drawn(archive, region, surface, variance, STEPS)
        moved = float(length_of(region.local(draws.mean(axis=0))))
        sizes, region = region.resized(draws, archive.generator)
        if round_ + 1 >= LEAST_ROUNDS and moved < SETTLED and np.abs(log(sizes)).max() < SETTLED:
            break
    archive.add(region.draw(2 * batch, archive.generator))
    surface, variance, share = _laid(archive, region, 2 * batch)
    draws = _drawn(archive, region, surface, variance, LAST_STEPS)
    density = _log_density(archive, region, surface, variance)
    order = np.argsort(-density(draws), kind="stable")
    tried = draws[order[:: max(1, len(order) // (4 * TRIED))][:TRIED]]
    first = len(archive.places)
    archive.add(tried)
    misfit = _weighed(archive.measured - archive.amplitude[first:], variance)
    row = first + int(np.argmin(misfit))
    total = float(misfit.min() + log(variance[np.isfinite(variance)]).sum())
    return _End(surface, draws, archive.places[row], row, variance, share, total)


def _laid(archive: Archive, region: Region, newest: int) -> tuple[Surface, Matrix, float]:
    """Fit polynomials to all responses in a region. Also return the total variance of data and model."""
    near = region.holds(archive.places)
    near[-newest:] = True
    surface = fit_surface(region, archive.places[near], archive.amplitude[near])
    error = np.sqrt(np.nan_to_num(np.nanmean(np.where(near[:, None], archive.error, 0.0) ** 2, axis=0)))
    scatter = np.maximum(surface.scatter, error)
    question = archive.question
    given, share = question.measured.deviation, question.share or 0.0
    if given is None and question.share is None:
        share = min(_share(archive, row, scatter) for row in surface.at(archive.places[near]))
    least = LEAST_SHARE * (1.0 if archive.logarithmic else archive.measured)
    return surface, (share if given is None else given) ** 2 + scatter**2 + least**2, share


def _share(archive: Archive, amplitude: Matrix, scatter: Matrix) -> float:
    """Return the relative deviation of the measurement at which chi-square equals the degrees of freedom."""
    off = (archive.measured - amplitude)[np.isfinite(scatter)]
    scatter = scatter[np.isfinite(scatter)]
    freedom = max(1, off.size - archive.count)
    low, high = 1e-9, 1e3
    for _ in range(60):
        middle = float(np.sqrt(low * high))
        if float((off**2 / (middle**2 + scatter**2)).sum()) > freedom:
            low = middle
        else:
            high = middle
    return high


def _weighed(off: Matrix, variance: Matrix) -> Matrix:
    """Return the sum of squared residuals. Residuals above `LINEAR` count linearly; the residual of a failure is 10."""
    z = np.abs(off) / np.sqrt(variance)
    z = np.where(np.isfinite(z), z, 10.0)
    z[..., ~np.isfinite(variance)] = 0.0
    return np.asarray(np.where(z < LINEAR, z**2, LINEAR * (2.0 * z - LINEAR)).sum(axis=-1))


def _log_density(
    archive: Archive, region: Region, surface: Surface, variance: Matrix
) -> Callable[[Matrix], Matrix]:
    """Return a function for the logarithm of the posterior density in a region, with a uniform prior."""

    def density(places: Matrix) -> Matrix:
        inside = ((places >= 0.0) & (places <= 1.0)).all(axis=1)
        inside &= region.holds(places, EDGE * RADIUS)
        off = archive.measured - surface.at(places)
        return np.where(inside, -0.5 * _weighed(off, variance), -np.inf)

    return density


def _drawn(archive: Archive, region: Region, surface: Surface, variance: Matrix, steps: int) -> Matrix:
    density = _log_density(archive, region, surface, variance)
    tried = region.draw(20 * WALKERS, archive.generator)
    found = density(tried)
    walkers = tried[np.argsort(-found, kind="stable")[:WALKERS]]
    return draw(density, walkers, steps, archive.question.seed)


def _fitted(archive: Archive, ends: list[_End]) -> Fitted:
    """Convert the best final region into the result of the fit, in the names and units of `archive.question`."""
    question, end = archive.question, ends[0]
    tail = 0.5 * (1.0 - question.confidence)
    widening = _widening(archive, end)
    middle = end.draws.mean(axis=0)
    draws = np.clip(middle + widening * (end.draws - middle), 0.0, 1.0)
    low, high = np.quantile(draws, [tail, 1.0 - tail], axis=0)
    # the best set may lie outside the quantiles; as the response jumps, good sets may lie outside all draws
    good = archive.places[_as_good(archive, end, widening)]
    low, high = np.minimum(low, good.min(axis=0)), np.maximum(high, good.max(axis=0))
    estimates = tuple(
        Estimate.of(each, end.best[i], (low[i], high[i]), float(each.values(draws[:, i]).std()))
        for i, each in enumerate(question.free)
    )
    measured = question.measured
    given = end.share if measured.deviation is None else measured.deviation
    error = np.sqrt(np.maximum(end.variance - given**2, 0.0))
    deviation = given * measured.amplitude if archive.logarithmic else given
    best = archive.responses[end.row]
    return Fitted(
        question=question,
        estimates=estimates,
        correlation=_correlation(draws),
        model=best.amplitude,
        model_error=error * best.amplitude if archive.logarithmic else error,
        deviation=np.asarray(deviation),
        impacts_per_cycle=best.impacts_per_cycle,
        stick_fraction=best.stick_fraction,
        response_class=best.response_class.astype(int),
        evaluations=len(archive.places),
        widening=widening,
        others=tuple(question.values(one.best) for one in ends[1:] if _is_other(one, end)),
    )


def _correlation(draws: Matrix) -> Matrix:
    covariance = covariance_of(draws)
    deviation = np.sqrt(np.diag(covariance))
    with np.errstate(invalid="ignore"):  # NaN for a parameter whose draws are all at one end of the range
        return np.clip(covariance / deviation[:, None] / deviation, -1.0, 1.0)


def _is_other(one: _End, best: _End) -> bool:
    """Return whether `one` fits the measurement about as well as `best`, but lies outside the region of `best`."""
    return one.misfit < best.misfit + AS_GOOD and not best.surface.region.holds(one.best)


def _as_good(archive: Archive, end: _End, widening: float) -> NDArray[np.bool_]:
    """Return a mask of the computed parameter sets that a likelihood ratio test does not reject."""
    misfit = _weighed(archive.measured - archive.amplitude, widening**2 * end.variance)
    return np.asarray(misfit <= misfit[end.row] + chdtri(1.0, 1.0 - archive.question.confidence))


def _widening(archive: Archive, end: _End) -> float:
    """Return the factor that widens the intervals if residuals exceed the stated deviations (Birge 1932)."""
    off = archive.measured - archive.amplitude[end.row]
    squares = (off**2 / end.variance)[np.isfinite(off) & np.isfinite(end.variance)]
    freedom = squares.size - archive.count
    if archive.question.deviation is None or freedom < 1:
        return 1.0
    if chdtrc(freedom, float(squares.sum())) > DOUBTED:
        return 1.0
    # an outlier is reported, but does not widen the intervals
    return max(1.0, float(np.sqrt(np.minimum(squares, LINEAR**2).sum() / freedom)))
