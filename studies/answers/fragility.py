"""How likely a damper under a ground-motion suite exceeds a limit, as the records are scaled up: a fragility curve."""

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from damperlab.studies.answers.faults import QueryFault
from damperlab.studies.answers.phrases import Phrases
from damperlab.studies.answers.selection import (
    as_float,
    check_metric,
    choose,
    coded,
    completeness,
    count,
    main_metric,
    read,
    say,
    scalars,
)
from damperlab.studies.faults import Fault, counted, describe
from damperlab.studies.ground.variables import RECORD
from damperlab.studies.kinds import SUITE, kind_of
from damperlab.studies.questions import Fragile
from damperlab.studies.variables import Status

Floats = NDArray[np.float64]

SCALE = "scale"
DROP = 1.9207
"""How far a log-likelihood may fall from its maximum within an interval of 95 %: half the quantile of χ² with 1 degree."""
WIDEST = 4.0
"""Largest dispersion that is looked at; buildings and dampers have 0.1 to 1."""
NARROWEST = 1e-3
CELLS, ZOOMS = 24, 14


class Fitted(NamedTuple):
    """A lognormal distribution of the scale at which a limit is first exceeded.

    Attributes
    ----------
    median, dispersion : float
        θ, and the standard deviation β of ln scale.
    median_interval, dispersion_interval : tuple of float
        Of 95 % each, by the profile of the likelihood; an end that nothing bounds is 0 or infinite.
    """

    median: float
    dispersion: float
    median_interval: tuple[float, float]
    dispersion_interval: tuple[float, float]


def fragility(cube: xr.Dataset, asked: Fragile) -> xr.Dataset:
    """Fit the probability that a result exceeds a limit, over the factor on the records.

    Of each record it is known between which two scales the limit is first exceeded, or that it never is: one observation a
    record, since the runs of one record are no independent ones. A lognormal distribution of that scale is fitted to them
    by maximum likelihood with censored observations [1]_ [2]_.

    Parameters
    ----------
    cube : Dataset
        Of a ground-motion suite with several scales; one damper and structure of it is read.
    asked : Fragile
        The limit, the result, and the damper.

    Returns
    -------
    Dataset
        Dimension scale. Variables: `exceeded`, the share of the records whose result exceeds the limit there or at a lower
        scale; `probability`, the fitted curve; `lowest`, `median` and `highest` of the result over the records. Attributes:
        `threshold`, `metric`, `records`, `never` (records under which the limit is never exceeded), `median_scale` and
        `dispersion` with their intervals, where they could be fitted, `complete`, `points`, `points_failed`, `note`.

    Raises
    ------
    QueryFault
        If the study is no suite, the metric is not in the cube or has codes, or a dimension is not one of the suite's.

    References
    ----------
    .. [1] J. W. Baker, Efficient analytical fragility function fitting using dynamic structural analysis, Earthquake Spectra
       31 (2015) 579-599.
    .. [2] D. Vamvatsikos, C. A. Cornell, Incremental dynamic analysis, Earthquake Eng. Struct. Dyn. 31 (2002) 491-514.
    """
    kind = kind_of(cube.sizes)
    if kind is not SUITE:
        told = f"This study is {kind.words}, and a fragility curve needs {SUITE.words}."
        raise QueryFault(Fault("study", kind.words, SUITE.words, "ask a suite whose scales vary", told))
    metric = asked.metric or main_metric(cube)
    check_metric(cube, metric)
    if coded(cube, metric):
        advice = "choose a metric that is a quantity"
        raise QueryFault(
            Fault("metric", metric, "a quantity", advice, f"{metric} holds codes, which exceed nothing.")
        )
    if not asked.threshold > 0:
        raise QueryFault(
            Fault("threshold", describe(asked.threshold), "a number above 0", "name the limit in SI units")
        )
    index = choose(cube, asked.at, (RECORD, SCALE))
    dims = (RECORD, SCALE)
    values, status = as_float(read(cube, metric, index, dims)), read(cube, "status", index, dims)
    known = ((status >= Status.CONVERGED) & (status <= Status.MAX_CYCLES) & np.isfinite(values)).all(axis=1)
    scales = cube[SCALE].values
    exceeded = np.maximum.accumulate(values[known] > asked.threshold, axis=1)
    low, high = bounds(exceeded, scales)
    fitted = fit_lognormal(low, high)
    attributes: dict[str, Any] = {
        **completeness(*count(status), status.size),
        "threshold": asked.threshold,
        "metric": metric,
        "records": int(known.sum()),
        "never": int(np.isinf(high).sum()),
    }
    if fitted is not None:
        attributes |= {
            "median_scale": fitted.median,
            "dispersion": fitted.dispersion,
            "median_scale_interval": list(fitted.median_interval),
            "dispersion_interval": list(fitted.dispersion_interval),
        }
    attributes["note"] = _note(cube, metric, attributes, say(cube, index, asked.at, Phrases.of(cube)))
    nothing = np.full(scales.size, np.nan)
    some = bool(known.any())
    variables: Mapping[str, tuple[Floats, str]] = {
        "exceeded": (
            exceeded.mean(axis=0) if some else nothing,
            "share of the records that exceed the limit",
        ),
        "probability": (
            nothing if fitted is None else cumulative(np.log(scales / fitted.median) / fitted.dispersion),
            "probability of exceeding the limit",
        ),
        "lowest": (values[known].min(axis=0) if some else nothing, "smallest over the records"),
        "median": (np.median(values[known], axis=0) if some else nothing, "median over the records"),
        "highest": (values[known].max(axis=0) if some else nothing, "largest over the records"),
    }
    units = {name: cube[metric].attrs.get("units", "1") for name in ("lowest", "median", "highest")}
    described = {
        name: (SCALE, array, {"units": units.get(name, "1"), "long_name": words})
        for name, (array, words) in variables.items()
    }
    return xr.Dataset(described, {SCALE: cube[SCALE], **scalars(cube, index)}, attributes)


def bounds(exceeded: NDArray[np.bool_], scales: Floats) -> tuple[Floats, Floats]:
    """Give for each record the scales between which it first exceeds, (n,) each: 0 below the first, infinity where never."""
    first = np.where(exceeded.any(axis=1), exceeded.argmax(axis=1), scales.size)
    edges = np.concatenate(([0.0], scales, [np.inf]))
    return edges[first], edges[first + 1]


def fit_lognormal(low: Floats, high: Floats) -> Fitted | None:
    """Fit a lognormal distribution to positive numbers that are known to lie in intervals, by maximum likelihood.

    Parameters
    ----------
    low, high : ndarray, (n,)
        Ends of the intervals; 0 and infinity where one is open.

    Returns
    -------
    Fitted or None
        None where the data give no dispersion: fewer than two numbers, or all may be one.
    """
    finite = np.concatenate((low[low > 0], high[np.isfinite(high)]))
    # if one number lies in all intervals, the likelihood grows without end as the distribution narrows to it
    if low.size < 2 or not finite.size or float(low.max()) < float(high.min()):
        return None
    centre, span = np.log(finite).mean(), np.ptp(np.log(finite)) + WIDEST
    corner = (centre - span, math.log(NARROWEST), centre + span, math.log(WIDEST))
    box = corner
    for _ in range(ZOOMS):
        medians, widths, likely = _grid(box, low, high)
        i, j = np.unravel_index(int(likely.argmax()), likely.shape)
        reach = [2.0 * (axis[1] - axis[0]) for axis in (medians, widths)]
        box = (medians[i] - reach[0], widths[j] - reach[1], medians[i] + reach[0], widths[j] + reach[1])
    best, median, width = float(likely.max()), float(medians[i]), float(widths[j])

    def interval(axis: int) -> tuple[float, float]:
        place = (median, width)[axis]
        ends = []
        for edge in (corner[axis], corner[axis + 2]):
            inside, outside = place, edge
            if _profile(axis, outside, corner, low, high) > best - DROP:
                ends.append(0.0 if edge < place else math.inf)
                continue
            for _ in range(40):
                middle = 0.5 * (inside + outside)
                within = _profile(axis, middle, corner, low, high) > best - DROP
                inside, outside = (middle, outside) if within else (inside, middle)
            ends.append(math.exp(inside))
        return ends[0], ends[1]

    return Fitted(math.exp(median), math.exp(width), interval(0), interval(1))


def cumulative(z: Floats) -> Floats:
    """The normal distribution function."""
    return np.asarray(0.5 * np.vectorize(math.erfc, otypes=[float])(-z / math.sqrt(2)))


def _grid(box: tuple[float, ...], low: Floats, high: Floats) -> tuple[Floats, Floats, Floats]:
    medians, widths = np.linspace(box[0], box[2], CELLS), np.linspace(box[1], box[3], CELLS)
    return medians, widths, _log_likelihood(medians[:, None], widths[None, :], low, high)


def _profile(axis: int, at: float, corner: tuple[float, ...], low: Floats, high: Floats) -> float:
    """The largest log-likelihood where one of the two parameters is held."""
    other = 1 - axis
    start, stop = corner[other], corner[other + 2]
    best = -math.inf
    for _ in range(6):
        line = np.linspace(start, stop, CELLS)
        held = np.full(CELLS, at)
        median, width = (held, line) if axis == 0 else (line, held)
        likely = _log_likelihood(median, width, low, high)
        place = int(likely.argmax())
        best = max(best, float(likely[place]))
        start, stop = line[max(0, place - 2)], line[min(CELLS - 1, place + 2)]
    return best


def _log_likelihood(median: Floats, width: Floats, low: Floats, high: Floats) -> Floats:
    """Log-likelihood at ln median and ln dispersion, arrays that broadcast."""
    median, width = np.broadcast_arrays(median, width)
    total = np.zeros(median.shape)
    pairs, number = np.unique(np.column_stack((low, high)), axis=0, return_counts=True)
    with np.errstate(divide="ignore"):
        for (below, above), times in zip(pairs, number, strict=True):
            a, b = ((np.log(end) - median) / np.exp(width) for end in (below, above))
            # in the nearer tail, so that no digit is lost
            flip = a > 0
            share = cumulative(np.where(flip, -a, b)) - cumulative(np.where(flip, -b, a))
            total = total + times * np.log(np.maximum(share, 1e-300))
    return total


def _note(cube: xr.Dataset, metric: str, found: Mapping[str, Any], where: str) -> str:
    units = cube[metric].attrs.get("units", "1")
    limit = f"{found['threshold']:g}" + ("" if units == "1" else f" {units}")
    if units == "m":
        limit = f"{1e3 * found['threshold']:g} mm"
    long_name = cube[metric].attrs.get("long_name", metric)
    sentences = [where, f"The {long_name} exceeds {limit} under"]
    sentences[-1] += (
        f" {found['records'] - found['never']} of {counted(found['records'], 'record')} at some scale."
    )
    if "median_scale" in found:
        low, high = found["median_scale_interval"]
        sentences.append(
            f"Half of such records exceed it from a scale of {found['median_scale']:.4g} ({_interval(low, high)}) "
            f"on; dispersion {found['dispersion']:.3g} of ln scale (lognormal, maximum likelihood, one observation a record)."
        )
    else:
        sentences.append(
            "No curve can be fitted: the records do not differ in the scale at which they first exceed it."
        )
    return " ".join(filter(None, sentences))


def _interval(low: float, high: float) -> str:
    """Say between which scales the median lies; so few records may settle nothing."""
    if low > 0 and high < np.inf:
        return f"95 % from {low:.3g} to {high:.3g}"
    return "these records do not settle it: its 95 % interval has no end"
