"""Fragility curve: the probability that a result of a damper exceeds a limit, over the scale of the records."""

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.optimize import brentq, minimize, minimize_scalar
from scipy.special import log_ndtr, ndtr

from damperlab.studies.answers.leading import leading_place
from damperlab.studies.answers.over_records import OverRecords, enough_records, over_records
from damperlab.studies.answers.phrases import Phrases
from damperlab.studies.answers.query_fault import check_question, refused
from damperlab.studies.answers.selection import (
    as_float,
    check_quantity,
    completeness,
    count,
    main_metric,
    read,
    say,
    scalars,
)
from damperlab.studies.brief import Brief
from damperlab.studies.faults import counted
from damperlab.studies.ground.variables import RECORD
from damperlab.studies.kinds import SUITE, kind_of
from damperlab.studies.questions import Fragile
from damperlab.studies.spelling import spelled
from damperlab.studies.variables import Status

Floats = NDArray[np.float64]

SCALE = "scale"
DROP = 1.9207
"""Fall of the log-likelihood from the maximum to the ends of a 95 % interval: half the 95 % quantile of χ²(1)."""
WIDEST = 4.0
"""Largest dispersion considered. Buildings and dampers have dispersions of 0.1 to 1."""
NARROWEST = 1e-3
SETTLED, MANY = 3.0, 10
"""Largest ratio of interval ends at which a median counts as settled, and number of records that is usually enough."""
FAILED_RUNS = (Status.TOO_MANY_EVENTS, Status.UNBOUNDED, Status.NO_PROGRESS)
"""Statuses of a failed run that can count as exceeding the limit, as in incremental dynamic analysis.

A failed run counts as exceeding the limit, unless a larger scale of the same record has a result or is still
to be computed. If failed runs did not count, records whose runs fail at large scales would make the damper
look too good.
"""


class Fitted(NamedTuple):
    """A lognormal distribution of the scale at which a limit is first exceeded.

    Attributes
    ----------
    median, dispersion : float
        The median θ of the scale, and the standard deviation β of ln scale.
    median_interval, dispersion_interval : tuple of float
        95 % intervals from the profile likelihood. An unbounded end is 0 or infinity.
    """

    median: float
    dispersion: float
    median_interval: tuple[float, float]
    dispersion_interval: tuple[float, float]


def fragility(cube: xr.Dataset, asked: Fragile) -> xr.Dataset:
    """Fit the probability that a result exceeds a limit, as a function of the scale of the records.

    Each record gives one observation, since runs under the same record are not independent. The observation is the
    scale at which the result reaches the limit, interpolated as in incremental dynamic analysis [2]_. If a run is
    missing or the limit is never exceeded, only an interval that contains this scale is known. If any failed run
    counts as exceeding the limit, intervals replace the interpolated scales of all records. Runs fail where results
    are large, so interpolation between the other runs would shift the median. A lognormal distribution is fitted by
    maximum likelihood [1]_.

    Parameters
    ----------
    cube : Dataset
        A ground-motion suite with several scales. The results of one damper and one structure are read.
    asked : Fragile
        The limit, the result, and the damper.

    Returns
    -------
    Dataset
        Dimension scale. `exceeded` is the share of the records whose result exceeds the limit at this or a smaller
        scale, and `probability` is the fitted curve. `lowest`, `median` and `highest` are the smallest, the median and
        the largest result over the records. The fields of `OverRecords` are variables too. Attributes: `threshold`,
        `metric`, `records`, `never` (records under which the limit is never exceeded), `median_scale` and `dispersion`
        with their intervals, if they could be fitted, `complete`, `points`, `points_failed`, `note`.

    Raises
    ------
    QueryFault
        If the study is not a suite, if the metric is not in the cube or has codes, or if a dimension is not in the
        suite.

    References
    ----------
    .. [1] J. W. Baker, Efficient analytical fragility function fitting using dynamic structural analysis, Earthquake Spectra
       31 (2015) 579-599.
    .. [2] D. Vamvatsikos, C. A. Cornell, Incremental dynamic analysis, Earthquake Eng. Struct. Dyn. 31 (2002) 491-514.
    """
    kind = kind_of(cube.sizes)
    if kind is not SUITE:
        told = f"This study is {kind.words}, and a fragility curve needs {SUITE.words}."
        raise refused("study", kind.words, SUITE.words, "name a suite with several scales", told)
    check_question(asked)
    metric = asked.metric or main_metric(cube)
    check_quantity(cube, metric, "which cannot exceed a limit")
    index, lead = leading_place(cube, asked.at, (RECORD, SCALE), metric)
    dims = (RECORD, SCALE)
    values, status = as_float(read(cube, metric, index, dims)), read(cube, "status", index, dims)
    known = (status >= Status.CONVERGED) & (status <= Status.MAX_CYCLES) & np.isfinite(values)
    may_be_known = known | (status == Status.NOT_COMPUTED)
    may_be_known_above = np.maximum.accumulate(may_be_known[:, ::-1], axis=1)[:, ::-1]
    beyond = np.isin(status, FAILED_RUNS) & ~may_be_known_above
    # a record under which every run fails gives no information on the limit
    beyond &= known.any(axis=1, keepdims=True)
    exceeds, keeps = (known & (values > asked.threshold)) | beyond, known & ~(values > asked.threshold)
    some = (exceeds | keeps).any(axis=1)
    scales = cube[SCALE].values
    values = np.where(known, values, np.nan)
    low, high = bounds(exceeds[some], scales, keeps[some])
    observed = (low, high)
    if not beyond.any():
        # runs fail where results are large, so an interpolation between the other runs would shift the median
        observed = reached(values[some], asked.threshold, scales, low, high)
    fitted = fit_lognormal(*observed)
    attributes: dict[str, Any] = {
        **completeness(count(status)),
        "threshold": asked.threshold,
        "metric": metric,
        "records": int(some.sum()),
        "never": int(np.isinf(high).sum()),
    }
    if fitted is not None:
        attributes |= {
            "median_scale": fitted.median,
            "dispersion": fitted.dispersion,
            "median_scale_interval": list(fitted.median_interval),
            "dispersion_interval": list(fitted.dispersion_interval),
        }
    scattered = [over_records(each, asked.quantile) for each in values.T]
    attributes["quantile_share"] = asked.quantile
    where = say(cube, index, asked.at, Phrases.of(cube), lead)
    scatter = _scatter(cube, metric, scattered[-1], int(known[:, -1].sum()), asked.quantile)
    brief = _brief(cube, index, attributes, may_be_one(*observed), scatter)
    note = [where, *brief.sentences, *_details(attributes, int(beyond.sum()))]
    attributes |= {"note": " ".join(filter(None, note)), "brief": brief.document()}
    nothing = np.full(scales.size, np.nan)
    by, not_by = (high[:, None] <= scales).sum(axis=0), (low[:, None] >= scales).sum(axis=0)
    variables: Mapping[str, tuple[Floats, str]] = {
        "exceeded": (
            np.divide(by, by + not_by, out=nothing.copy(), where=by + not_by > 0),
            "share of the records that exceed the limit",
        ),
        "probability": (
            nothing if fitted is None else ndtr(np.log(scales / fitted.median) / fitted.dispersion),
            "probability of exceeding the limit",
        ),
        **{
            name: (
                np.array([getattr(each, name) for each in scattered]),
                f"{name.replace('_', ' ')} over the records",
            )
            for name in OverRecords._fields
        },
        "lowest": (np.fmin.reduce(values, axis=0), "smallest over the records"),
        "median": (_median(values), "median over the records"),
        "highest": (np.fmax.reduce(values, axis=0), "largest over the records"),
    }
    counts = ("exceeded", "probability")
    units = {name: cube[metric].attrs.get("units", "1") for name in variables if name not in counts}
    described = {
        name: (SCALE, array, {"units": units.get(name, "1"), "long_name": words})
        for name, (array, words) in variables.items()
    }
    return xr.Dataset(described, {SCALE: cube[SCALE], **scalars(cube, index)}, attributes)


def bounds(exceeds: NDArray[np.bool_], scales: Floats, keeps: NDArray[np.bool_]) -> tuple[Floats, Floats]:
    """Return for each record the two scales between which the limit is first exceeded.

    Parameters
    ----------
    exceeds, keeps : ndarray of bool, (n, m)
        Whether the result under a record is known to exceed the limit at a scale, and whether it is known not to
        exceed the limit.
    scales : ndarray, (m,)
        Scales in ascending order.

    Returns
    -------
    low, high : ndarray, (n,)
        `high` is the smallest scale at which the limit is known to be exceeded, or infinity if there is none. `low` is
        the largest scale below `high` at which the limit is known not to be exceeded, or 0 if there is none.
    """
    first = np.where(exceeds.any(axis=1), exceeds.argmax(axis=1), scales.size)
    before = keeps & (np.arange(scales.size) < first[:, None])
    last = np.where(before.any(axis=1), scales.size - before[:, ::-1].argmax(axis=1), 0)
    edges = np.concatenate(([0.0], scales, [np.inf]))
    return edges[last], edges[first + 1]


def reached(
    values: Floats, threshold: float, scales: Floats, low: Floats, high: Floats
) -> tuple[Floats, Floats]:
    """Return the scales at which results reach a limit.

    The interpolation between neighbouring scales is linear in the logarithms of scale and result.

    Parameters
    ----------
    values : ndarray, (n, m)
        Results of n records; NaN if unknown.
    threshold : float
        The limit.
    scales : ndarray, (m,)
        Scales in ascending order.
    low, high : ndarray, (n,)
        The scales from `bounds`.

    Returns
    -------
    low, high : ndarray, (n,)
        Both are the interpolated scale, if interpolation is possible. Otherwise both are unchanged.
    """
    after = np.searchsorted(scales, high)
    between = (low > 0) & np.isfinite(high) & (np.searchsorted(scales, low) == after - 1)
    rows, after = np.flatnonzero(between), after[between]
    below, above = values[rows, after - 1], values[rows, after]
    with np.errstate(divide="ignore", invalid="ignore"):
        share = np.log(threshold / below) / np.log(above / below)
        scale = scales[after - 1] * (scales[after] / scales[after - 1]) ** share
    usable = np.isfinite(scale)
    low, high = low.copy(), high.copy()
    low[rows[usable]] = high[rows[usable]] = scale[usable]
    return low, high


def may_be_one(low: Floats, high: Floats) -> bool:
    """Whether one number lies in all intervals. The likelihood then grows as the dispersion falls to 0."""
    return low.size < 2 or float(low.max()) <= float(high.min())


def fit_lognormal(low: Floats, high: Floats) -> Fitted | None:
    """Fit a lognormal distribution to positive numbers by maximum likelihood.

    The likelihood has one maximum: it is log-concave in μ/σ and 1/σ (J. Burridge, J. R. Stat. Soc. B 43 (1981) 41).

    Parameters
    ----------
    low, high : ndarray, (n,)
        Lower and upper bound of each number. An unknown bound is 0 or infinity. For a known number, both
        bounds are equal.

    Returns
    -------
    Fitted or None
        None if the data do not determine the dispersion (see `may_be_one`), or if the dispersion is `WIDEST` or more.
    """
    finite = np.log(np.concatenate((low[low > 0], high[np.isfinite(high)])))
    if not finite.size or may_be_one(low, high):
        return None
    span = np.ptp(finite) + WIDEST
    box = [(finite.mean() - span, finite.mean() + span), (math.log(NARROWEST), math.log(WIDEST))]

    def unlikely(place: Sequence[float]) -> float:
        return -_log_likelihood(place[0], math.exp(place[1]), low, high)

    start = (finite.mean(), math.log(max(NARROWEST, min(1.0, float(finite.std())))))
    found = minimize(
        unlikely, start, method="Nelder-Mead", bounds=box, options={"xatol": 1e-9, "fatol": 1e-12}
    )
    if found.x[1] > box[1][1] - 1e-6:
        return None

    def too_unlikely(at: float, axis: int) -> float:
        """Return the drop of the profile log-likelihood from its maximum to a value, minus `DROP`."""

        def held(other: float) -> float:
            return unlikely((at, other) if axis == 0 else (other, at))

        best = minimize_scalar(held, bounds=box[1 - axis], method="bounded", options={"xatol": 1e-9})
        return float(best.fun - found.fun - DROP)

    def interval(axis: int) -> tuple[float, float]:
        ends = [
            math.exp(brentq(too_unlikely, found.x[axis], edge, args=(axis,), xtol=1e-9))
            if too_unlikely(edge, axis) > 0
            else open_end
            for edge, open_end in zip(box[axis], (0.0, math.inf), strict=True)
        ]
        return ends[0], ends[1]

    return Fitted(math.exp(found.x[0]), math.exp(found.x[1]), interval(0), interval(1))


def _log_likelihood(median: float, width: float, low: Floats, high: Floats) -> float:
    """Return the log-likelihood of intervals and numbers, up to a constant, for ln θ = `median` and β = `width`."""
    known = low == high
    with np.errstate(divide="ignore"):
        a, b = (np.log(low) - median) / width, (np.log(high) - median) / width
    density = -0.5 * a[known] ** 2 - math.log(width)
    a, b = a[~known], b[~known]
    # evaluate the nearer tail of the distribution, which preserves accuracy
    flip = a > 0
    a, b = np.where(flip, -b, a), np.where(flip, -a, b)
    return float(density.sum() + (log_ndtr(b) + np.log1p(-np.exp(log_ndtr(a) - log_ndtr(b)))).sum())


def _median(values: Floats) -> Floats:
    """Return the median of the known values of each column."""
    known = np.ma.masked_invalid(values)
    return np.asarray(np.ma.median(known, axis=0).filled(np.nan))  # type: ignore[no-untyped-call]


def _details(found: Mapping[str, Any], failed: int) -> Iterator[str]:
    """Say how a curve was fitted, and how many failed runs count as exceeding the limit."""
    if "median_scale" in found:
        yield (
            f"The dispersion of ln scale is {found['dispersion']:.3g} (lognormal, fitted by maximum "
            "likelihood to one scale per record)."
        )
    if failed:
        count = "count as exceeding the limit" if failed > 1 else "counts as exceeding the limit"
        yield f"{counted(failed, 'failed run')} {count}: no larger scale of the same record has a result."


def _scatter(cube: xr.Dataset, metric: str, found: OverRecords, records: int, share: float) -> str:
    """Describe the scatter of the result over the records at the largest scale."""
    if records < 2:
        return ""
    units = cube[metric].attrs.get("units", "1")
    low, high = (
        spelled(end, units, 3) if np.isfinite(end) else "no bound"
        for end in (found.quantile_low, found.quantile_high)
    )
    return (
        f"At a scale of {cube[SCALE].values[-1]:g} the rms over {counted(records, 'record')} is "
        f"{spelled(found.rms, units, 3)} ± {spelled(found.rms_error, units, 2)} (standard error). The mean is "
        f"{spelled(found.mean, units, 3)} ± {spelled(found.mean_error, units, 2)}. {100 * share:g} % of the "
        f"records stay below {spelled(found.quantile, units, 3)} (95 % interval from {low} to {high}; "
        f"a bound at each end needs {enough_records(share)} records)."
    )


def _brief(
    cube: xr.Dataset, index: Mapping[str, int], found: Mapping[str, Any], alike: bool, scatter: str
) -> Brief:
    """Say under how many records the limit is exceeded, give the median scale, and say what to compute next."""
    limit = spelled(found["threshold"], cube[found["metric"]].attrs.get("units", "1"), 6)
    phrases, scales = Phrases.of(cube), cube[SCALE].values
    damper, structure = (
        ", ".join(
            phrases.equal(name, float(cube[name].values[index[name]]), ".3g")
            for name in names
            if cube.sizes[name] > 1
        )
        for names in (
            SUITE.designs,
            [name for name in SUITE.dimensions if name in index and name not in SUITE.designs],
        )
    )
    over, top = found["records"] - found["never"], f"{scales.max():g}"
    of = f"of the structure with {structure} " if structure else ""
    exceeds = f"exceeds {limit} under {over} of {counted(found['records'], 'record')}, at scales up to {top}."
    sentences = [f"The damper {f'({damper}) ' if damper else ''}{of}{exceeds}"]
    settled = False
    if "median_scale" in found:
        low, high = found["median_scale_interval"]
        settled = low > 0 and math.isfinite(high) and high <= SETTLED * low
        sentences.append(
            f"Median scale {found['median_scale']:.3g} ({_interval(low, high)}){'' if settled else ': not settled'}."
        )
    elif scales.size > 1:
        why = "all records may reach the limit at one scale" if alike else "these records do not determine it"
        sentences.append(f"No curve can be fitted, as {why if over else 'the limit is never exceeded'}.")
    if scatter:
        sentences.append(scatter)
    following = "rank the dampers with `damperlab optimum`."
    if found["complete"] < 1:
        following = "compute the rest with `damperlab run`."
    elif scales.size == 1:
        enough = enough_records(found["quantile_share"])
        if found["records"] < enough:
            following = f"{enough} records or seeds to bound the quantile, and several scales for a curve."
    elif not settled:
        wider = f", and scales up to {2 * scales.max():g}" if found["never"] else ""
        following = (
            f"{'ten records or more' if found['records'] < MANY else 'scales closer together'}{wider}."
        )
    return Brief(None, tuple(sentences), (), following)


def _interval(low: float, high: float) -> str:
    if low > 0 and high < np.inf:
        return f"95 % from {low:.3g} to {high:.3g}"
    return "its 95 % interval is unbounded"
