"""The value of a build: its worst case over the band and the base amplitudes, and the limits it keeps."""

import math
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from statistics import NormalDist
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.design.band_mean import band_mean
from damperlab.studies.design.book import Book
from damperlab.studies.design.build import Build
from damperlab.studies.design.curve import Curve
from damperlab.studies.design.frequencies import rise
from damperlab.studies.specification.excitation import Amplitude, Excitation
from damperlab.studies.specification.measure import DAMPER_LIMITS, LIMITS, Limit
from damperlab.studies.specification.records import Case, Under
from damperlab.studies.specification.specification import Specification


@dataclass(frozen=True)
class Score:
    """A worst case.

    Parameters
    ----------
    value, error, noise : float
        The largest value of the measure in its unit, and by how much it may be larger and smaller at the required
        confidence. A response that does not repeat has a standard error.
    violation : float
        The largest share by which a limit is exceeded; 0 if all are kept.
    reached : dict of float
        The largest value of each limited quantity, a result or a quantity of the damper, in the unit of its limit.
    frequency_ratio : float
        Frequency of the worst case, over the nominal natural frequency; if the rms over the band is judged, that of its
        largest response. NaN under a ground-motion record, as is `amplitude_m`.
    amplitude_m : float
        Base amplitude Z of the worst case, at its frequency.
    build : Build
        The build that reaches it.
    under : Amplitude, Case or None
        Its excitation; None if nothing is known.
    at_most : dict of float
        As `reached`, upper bounds at the required confidence.
    violation_at_most : float
        As `violation`, from these bounds.
    reached_at : dict of tuple
        For each result in `reached`, its excitation and frequency ratio; a result of 0 has no entry.
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
    violation_at_most: float = 0.0
    reached_at: dict[str, tuple[Under, float]] = field(default_factory=dict)

    @property
    def rank(self) -> tuple[float, float]:
        """Sort key, smaller is better: builds that keep the limits come first, the others by their excess."""
        return self.violation, self.value

    @property
    def sure(self) -> tuple[float, float]:
        """As `rank`, but from upper bounds, because the smallest of many noisy values is small by chance."""
        return self.violation, self.most

    @property
    def most(self) -> float:
        """Upper bound of the measure at the required confidence."""
        return self.value + self.error


def score(book: Book, build: Build, amplitudes: Iterable[Under]) -> Score:
    """Judge a build by its known results.

    Value and error come from the sampled frequencies; the error includes the possible rise of the peak between them.
    Results without their own error get that of the amplitude.
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
        for limit in asked.limits:
            variables = asked.limited(limit, amplitude)
            if variables:
                results = np.prod([np.nan_to_num(curve[each], posinf=np.inf) for each in variables], axis=0)
                size = 1.0 if isinstance(amplitude, Case) else _size(curve, LIMITS[limit], own_speed)
                highest = int((size * results).argmax())
                if (size * results)[highest] > reached[limit]:
                    reached[limit] = float((size * results)[highest])
                    reached_at[limit] = amplitude, _nominal(build, curve, amplitude, highest)
                errors = (
                    curve.errors_of(variables[0])
                    if LIMITS[limit].has_error(isinstance(amplitude, Case))
                    else None
                )
                beyond = None if errors is None else quantile * size * errors
                at_most[limit] = max(at_most[limit], _at_most(curve, size * results, beyond))
        judged = _judged(curve, quantile)
        most = max(most, judged.most)
        if best is None or judged.value > best.value:
            record = isinstance(amplitude, Case)
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
    if best is None:
        reached |= {name: build.limited(DAMPER_LIMITS[name]) for name in asked.damper_limits}
        return Score(
            math.inf, 0.0, 0.0, math.inf, reached, math.nan, math.nan, build, None, reached, math.inf
        )
    own = {name: build.limited(DAMPER_LIMITS[name]) for name in asked.damper_limits}
    return replace(
        best,
        error=most - best.value if math.isfinite(best.value) else 0.0,
        violation=_violation(asked, build, reached),
        reached=reached | own,
        at_most=at_most | own,
        violation_at_most=_violation(asked, build, at_most),
        reached_at=reached_at,
    )


def _nominal(build: Build, curve: Curve, under: Under, place: int) -> float:
    """Give a frequency over the nominal natural frequency; NaN under a record."""
    return math.nan if isinstance(under, Case) else build.nominal(float(curve.r[place]))


class _Judged(NamedTuple):
    """The value of one response: the measure, its upper bound, its lower deviation, and the place of the largest
    value.
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
    """Give upper bounds of values over the band, including errors and the rise between frequencies; without errors, the
    largest value.
    """
    place = int(values.argmax())
    if errors is None or not np.isfinite(values).all():
        return float(values[place])
    beside = float(values[place] + errors[place] + rise(curve.r, values))
    return max(float((values + errors).max()), beside)


def _violation(asked: Specification, build: Build, reached: dict[str, float]) -> float:
    """Give the largest share by which a limit is exceeded; 0 if all are kept."""
    shares = (reached[name] / limit - 1.0 for name, limit in asked.limits.items())
    return max((build.excess(asked), *shares))


def _size(curve: Curve, about: Limit, own_speed: float) -> NDArray[np.float64] | float:
    """Give the factor that converts results in ratios into the unit of a limit.

    Parameters
    ----------
    curve : Curve
        Over a band.
    about : Limit
        On results.
    own_speed : float
        ω_n of the build [rad/s].
    """
    if about.unit == "1":
        return 1.0
    speed = curve.base_m * own_speed
    if about.per_second:
        return speed * curve.r * own_speed / math.tau
    return about.factor * {"m": curve.base_m, "m/s": speed, "m/s²": speed * own_speed}[about.unit]


def _highest(scores: list[Score], limit: str) -> Score:
    """Give the score with the largest value of a limited quantity."""
    return max(scores, key=lambda one: one.reached[limit])


def worst(scores: Iterable[Score]) -> Score:
    """Combine the scores of several builds: the worst value of each quantity."""
    every = list(scores)
    top = max(every, key=lambda one: one.value)
    reached = {name: max(one.reached[name] for one in every) for name in top.reached}
    most = max(one.most for one in every)
    highest = {name: _highest(every, name) for name in reached}
    return replace(
        top,
        reached=reached,
        reached_at={name: one.reached_at[name] for name, one in highest.items() if name in one.reached_at},
        violation=max(one.violation for one in every),
        error=most - top.value if math.isfinite(top.value) else 0.0,
        at_most={name: max(one.at_most[name] for one in every) for name in top.at_most},
        violation_at_most=max(one.violation_at_most for one in every),
    )


def binding(asked: Specification, *judged: Score) -> Excitation:
    """Give the excitation of the first worst case that is over a band and not under a record."""
    unders = (each.under for each in judged)
    return next((each.excitation for each in unders if isinstance(each, Amplitude)), asked.excitations[0])


def over_bands(amplitudes: Iterable[Under]) -> list[Amplitude]:
    """Choose the conditions that are over a band."""
    return [each for each in amplitudes if isinstance(each, Amplitude)]
