"""A tuned mass damper with the mass of the designed particle, for comparison on the same structure.

The response to ground-motion records is exact. The tuned mass damper is not tuned for records; see `tuned_beside`.
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import groupby

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.design.absorber_band import Judged, rates, response
from damperlab.studies.design.absorber_structure import (
    Built,
    built,
    hardest,
    judged_of,
    over_bands,
    structures,
)
from damperlab.studies.design.absorber_tuning import tuned_for
from damperlab.studies.specification.excitation import Amplitude
from damperlab.studies.specification.measure import LIMITS, RECORD_MEASURES
from damperlab.studies.specification.specification import Specification
from damperlab.studies.tmd.absorber import Absorber
from damperlab.studies.tmd.minimax import minimax
from damperlab.studies.tmd.under_record import STROKE, response_under

LIMITED = {
    "displacement_m": Judged(),
    "relative_displacement_m": Judged(against_base=True),
    "acceleration_m_per_s2": Judged(order=2),
    "rms_acceleration_m_per_s2": Judged(factor=math.sqrt(0.5), order=2),
}
"""Limits that a tuned mass damper can exceed, and the quantity that each limit restricts. All other limits concern
friction or impacts, which a tuned mass damper does not have.
"""
MOVED = Judged(stroke=True)
"""The stroke: the displacement of the absorber's mass relative to the structure."""
DETUNED = 0.02
"""Relative error of the absorber's natural frequency, with which the sensitivity to the tuning is computed."""


@dataclass(frozen=True)
class Beside:
    """A tuned mass damper, judged under the specification of the designed damper.

    Parameters
    ----------
    absorber : Absorber
        The absorber, tuned either for the smallest worst case of the measure, over the bands and within the tolerances,
        or for the smallest peak over all frequencies.
    value : float
        Worst case over band, amplitudes and tolerances, in the unit of the measure.
    nominal : float
        Worst case without tolerances.
    detuned : float
        Worst case if the absorber's natural frequency is also off by up to `DETUNED` in either direction.
        The responses to records are computed for errors of exactly ±`DETUNED` alone, on the nominal structure
        and on the structure with the worst case.
    stroke, detuned_stroke : float
        Largest displacement of the absorber's mass relative to the structure, within the tolerances: as tuned, and with
        a natural frequency that is off by up to `DETUNED`.
    exceeded : mapping of float
        Limits on results that the absorber exceeds within the tolerances, with the largest value reached.
    """

    absorber: Absorber
    value: float
    nominal: float
    detuned: float
    stroke: float
    detuned_stroke: float
    exceeded: Mapping[str, float]


def tuned_beside(asked: Specification, mass_ratio: float) -> Beside | None:
    """Return the tuned absorber of a given mass, with the worst case under the specification.

    The result is None if the mass ratio is 0, or if the samples of a record are missing.

    Mass, natural frequency and damping of the structure deviate within their tolerances, while the absorber keeps its
    tuning. The absorber is tuned for the smallest worst case over the given bands, but not for records. If there are
    records, the absorber with the smallest peak over all frequencies is judged too. Of the two absorbers, the one with
    the smaller worst case under all excitations is returned.
    """
    judged = [_judged(asked, one) for one in _tuned(asked, mass_ratio)]
    return min(judged, key=lambda each: each.value, default=None)


def least_beside(asked: Specification, mass_ratio: float) -> float | None:
    """Return the worst case on the nominal structure with the absorber that is tuned for this structure alone.

    The result is None if `tuned_beside` returns None.
    """
    exact = replace(asked, tolerances={})
    values = [_worst(exact, _shaken(exact, one, {})) for one in _tuned(exact, mass_ratio)]
    return min(values, default=None)


def _tuned(asked: Specification, mass_ratio: float) -> list[Absorber]:
    """Return the absorber that is tuned for the bands and, if there are records, the one with the smallest peak.

    The list is empty if `mass_ratio` is 0, or if the samples of a record are missing.
    """
    if mass_ratio <= 0.0 or any(
        source.id not in records.motions for records in asked.records for source in records.sources
    ):
        return []
    # a ground-motion record moves the base
    forced = not asked.records and all(each.motion.force for each in asked.excitations)
    usual = minimax(mass_ratio, asked.structure.damping_ratio, "force" if forced else "base")
    tuned = [tuned_for(asked, usual)] if asked.excitations else []
    return tuned + ([usual] if asked.records else [])


def _judged(asked: Specification, absorber: Absorber) -> Beside:
    """Judge an absorber on the nominal structure, and on structures that deviate within the tolerances."""
    tried = list(structures(asked))
    every = [_shaken(asked, absorber, shares) for shares in tried]
    values = [_worst(asked, each) for each in every]
    value = max(hardest(asked, absorber, judged_of(asked))[0], *values)
    stroke = max((hardest(asked, absorber, MOVED)[0], *map(_stroke_under, every)))
    detuned = hardest(asked, absorber, judged_of(asked), DETUNED)[0]
    detuned_stroke = hardest(asked, absorber, MOVED, DETUNED)[0]
    if asked.records:
        most = tried[max(range(len(tried)), key=lambda i: values[i])]
        off = [absorber.detuned(share) for share in (-DETUNED, DETUNED)]
        shaken = [_shaken(asked, one, shares) for one in off for shares in (tried[0], most)]
        detuned = max(detuned, *map(_under, shaken))
        detuned_stroke = max(detuned_stroke, *map(_stroke_under, shaken))
    reached = {name: max(_limited(asked, absorber, every, name)) for name in asked.limits}
    exceeded = {name: most for name, most in reached.items() if most > asked.limits[name]}
    return Beside(
        absorber,
        value,
        values[0],
        max(value, detuned),
        stroke,
        max(stroke, detuned_stroke),
        exceeded,
    )


def _worst(asked: Specification, built: Built) -> float:
    return float(max((*over_bands(asked, built, judged_of(asked)), _under(built))))


def _under(built: Built) -> float:
    """Return the largest value of the measure under the records."""
    return max((results[name] for name, results in built.measured), default=0.0)


def _stroke_under(built: Built) -> float:
    """Return the largest stroke under the records."""
    return max((results[STROKE] for _, results in built.measured), default=0.0)


def curve(
    asked: Specification, amplitude: Amplitude, absorber: Absorber, r: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the measure at the frequency ratios `r`, for an absorber on the nominal structure under one amplitude."""
    judged, structure = judged_of(asked), asked.structure
    own = structure.angular_frequency if asked.in_units else 1.0
    moved = response(amplitude.excitation, judged, absorber, structure.damping_ratio, r)
    found: NDArray[np.float64] = judged.factor * amplitude.base_m(r) * rates(judged, own, r) * moved
    return found


def _shaken(asked: Specification, tuned: Absorber, shares: dict[str, float]) -> Built:
    """Return the structure with the deviations `shares`, the absorber, and the results under the records."""
    on = built(asked, tuned, shares)
    omega = asked.structure.angular_frequency * (1.0 + on.shift)
    return replace(on, measured=tuple(_under_records(asked, on.absorber, on.damping, omega)))


def _under_records(
    asked: Specification, absorber: Absorber, damping: float, omega: float
) -> Iterator[tuple[str, dict[str, float]]]:
    for records in asked.records:
        measured = RECORD_MEASURES[asked.measure.name].variable
        names = {measured, STROKE, *(LIMITS[name].under_record for name in asked.limits if name in LIMITED)}
        for source, cases in groupby(records.cases, key=lambda case: case.source):
            motion = records.motions[source.id]
            found = response_under(absorber, damping, omega, motion, 1.0, records.tail_s)
            once = {name: found.measure(name) for name in names}
            for case in cases:
                # the response of a linear structure is proportional to the record
                yield measured, {name: case.scale * value for name, value in once.items()}


def _limited(asked: Specification, absorber: Absorber, every: list[Built], name: str) -> Iterator[float]:
    """Yield values of the limited result: the largest value over the bands, and one value for each record and
    structure.
    """
    yield 0.0  # results of impacts and friction
    if name not in LIMITED:
        return
    judged = LIMITED[name]
    # limits are stored in the units of the structure, also for a specification in ratios
    unit = 1.0 if asked.in_units else asked.structure.angular_frequency**judged.order
    yield unit * hardest(asked, absorber, judged)[0]
    for each in every:
        yield from (results[LIMITS[name].under_record] for _, results in each.measured)
