"""The score of a build: the worst case over bands, amplitudes and records, and the results for the limits."""

import math
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from statistics import NormalDist
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.design.book import Book
from damperlab.studies.design.build import Build
from damperlab.studies.design.curve import Curve, band_mean
from damperlab.studies.design.frequencies import rise
from damperlab.studies.specification.excitation import Amplitude, Case, Excitation, Under
from damperlab.studies.specification.measure import DAMPER_LIMITS, LIMITS, Limit
from damperlab.studies.specification.specification import Specification


@dataclass(frozen=True)
class Score:
    """The worst case of a build, and its results for the limits.

    Parameters
    ----------
    value, error, noise : float
        The largest value of the measure in its unit, and by how much the true value may be larger and smaller at the
        required confidence.
    violation : float
        The largest share by which a limit is exceeded; 0 if all limits are kept.
    reached : dict of float
        The largest value of each result or quantity of the damper that has a limit, in the unit of the limit.
    frequency_ratio : float
        Frequency of the worst case, relative to the nominal natural frequency; for an rms over the band,
        frequency of the largest response; NaN under a ground-motion record.
    amplitude_m : float
        Base amplitude Z at the frequency of the worst case; NaN under a ground-motion record.
    build : Build
        The build with the worst case.
    under : Amplitude, Case or None
        Excitation of the worst case; None if no result is known.
    at_most : dict of float
        Upper bounds of the values in `reached`, at the required confidence.
    reached_at : dict of tuple
        Excitation and frequency ratio of each result in `reached`; a result of 0 has no entry.
    """

    value: float
    error: float
    noise: float
    violation: float
    reached: dict[str, float]
    frequency_ratio: float
    amplitude_m: float
    build: Build
    under: Under | None
    at_most: dict[str, float] = field(default_factory=dict)
    reached_at: dict[str, tuple[Under, float]] = field(default_factory=dict)

    @property
    def rank(self) -> tuple[float, float]:
        """Sort key: builds that keep the limits come first, the other builds follow in the order of `violation`."""
        return self.violation, self.value

    @property
    def most(self) -> float:
        """Upper bound of the measure at the required confidence."""
        return self.value + self.error


def score(book: Book, build: Build, amplitudes: Iterable[Under]) -> Score:
    """Return the score of a build from its known results.

    The error includes the possible rise of the peak between two sampled frequencies.
    """
    asked = book.asked
    quantile = NormalDist().inv_cdf(asked.confidence)
    own_speed = asked.structure.angular_frequency * (1.0 + build.frequency_off)
    best: Score | None = None
    reached = dict.fromkeys(asked.limits, 0.0)
    at_most = dict.fromkeys(asked.limits, 0.0)
    reached_at: dict[str, tuple[Under, float]] = {}
    most = 0.0
    for amplitude in amplitudes:
        curve = book.curve(build, amplitude)
        if not curve.r.size:
            continue
        record = isinstance(amplitude, Case)
        for limit in asked.limits:
            variables = asked.limited(limit, amplitude)
            if variables:
                size = 1.0 if record else _size(curve, LIMITS[limit], own_speed)
                product = np.prod([np.nan_to_num(curve[each], posinf=np.inf) for each in variables], axis=0)
                results = size * product
                highest = int(results.argmax())
                if results[highest] > reached[limit]:
                    reached[limit] = float(results[highest])
                    reached_at[limit] = amplitude, _nominal(build, curve, amplitude, highest)
                errors = None
                if LIMITS[limit].has_error(record):
                    errors = quantile * size * curve.errors_of(variables[0])
                at_most[limit] = max(at_most[limit], _at_most(curve, results, errors))
        judged = _judged(curve, quantile)
        most = max(most, judged.most)
        if best is None or judged.value > best.value:
            at = _nominal(build, curve, amplitude, judged.place)
            best = Score(
                judged.value,
                0.0,
                judged.noise,
                0.0,
                reached,
                at,
                math.nan if record else float(curve.base_m[judged.place]),
                build,
                amplitude,
            )
    own = {name: build.limited(DAMPER_LIMITS[name]) for name in asked.damper_limits}
    if best is None:
        reached |= own
        return Score(math.inf, 0.0, 0.0, math.inf, reached, math.nan, math.nan, build, None, reached)
    return replace(
        best,
        error=most - best.value if math.isfinite(best.value) else 0.0,
        violation=_violation(asked, build, reached),
        reached=reached | own,
        at_most=at_most | own,
        reached_at=reached_at,
    )


def _nominal(build: Build, curve: Curve, under: Under, place: int) -> float:
    """Return a frequency of a response, relative to the nominal natural frequency; NaN under a record."""
    return math.nan if isinstance(under, Case) else build.nominal(float(curve.r[place]))


class _Judged(NamedTuple):
    """The judgement of one response.

    `most` is an upper bound of `value`, and `value - noise` is a lower bound. `place` is the index of the largest
    response.
    """

    value: float
    most: float
    noise: float
    place: int


def _judged(curve: Curve, quantile: float) -> _Judged:
    values = curve.measured
    place = int(values.argmax())
    if curve.measure.mean:
        mean = band_mean(curve.r, values, curve.errors)
        doubt = mean.between + quantile * mean.error
        return _Judged(mean.value, mean.value + doubt, doubt, place)
    doubts = quantile * curve.errors
    return _Judged(float(values[place]), _at_most(curve, values, doubts), float(doubts[place]), place)


def _at_most(curve: Curve, values: NDArray[np.float64], errors: NDArray[np.float64] | None) -> float:
    """Return an upper bound of the values over the band, including errors and a possible rise between frequencies.

    If `errors` is None, the largest value is returned.
    """
    place = int(values.argmax())
    if errors is None or not np.isfinite(values).all():
        return float(values[place])
    beside = float(values[place] + errors[place] + rise(curve.r, values))
    return max(float((values + errors).max()), beside)


def _violation(asked: Specification, build: Build, reached: dict[str, float]) -> float:
    """Return the largest share by which a limit is exceeded; 0 if all limits are kept."""
    shares = (reached[name] / limit - 1.0 for name, limit in asked.limits.items())
    return max((build.excess(asked), *shares))


def _size(curve: Curve, about: Limit, own_speed: float) -> NDArray[np.float64] | float:
    """Return the factor that converts results in ratios into the unit of a limit.

    Parameters
    ----------
    curve : Curve
        Response over a band.
    about : Limit
        Limit on a result.
    own_speed : float
        ω_n of the build [rad/s].
    """
    if about.unit == "1":
        return 1.0
    speed = curve.base_m * own_speed
    if about.per_second:
        return speed * curve.r * own_speed / math.tau
    return about.factor * {"m": curve.base_m, "m/s": speed, "m/s²": speed * own_speed}[about.unit]


def worst(scores: Iterable[Score]) -> Score:
    """Combine the scores of several builds into one, with the worst value of each quantity."""
    every = list(scores)
    top = max(every, key=lambda one: one.value)
    most = max(one.most for one in every)
    # for each limit, the score in which the limited quantity is largest
    highest = {name: max(every, key=lambda one: one.reached[name]) for name in top.reached}
    return replace(
        top,
        reached={name: one.reached[name] for name, one in highest.items()},
        reached_at={name: one.reached_at[name] for name, one in highest.items() if name in one.reached_at},
        violation=max(one.violation for one in every),
        error=most - top.value if math.isfinite(top.value) else 0.0,
        at_most={name: max(one.at_most[name] for one in every) for name in top.at_most},
    )


def binding(asked: Specification, *judged: Score) -> Excitation:
    """Return the excitation of the first score whose worst case is over a band; by default the first excitation."""
    unders = (each.under for each in judged)
    return next((each.excitation for each in unders if isinstance(each, Amplitude)), asked.excitations[0])


def over_bands(amplitudes: Iterable[Under]) -> list[Amplitude]:
    """Keep the amplitudes of excitations over a band, and leave out the cases under records."""
    return [each for each in amplitudes if isinstance(each, Amplitude)]
