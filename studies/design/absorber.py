"""The tuned mass damper of the same mass, on the same structure with the same tolerances, in closed form.

Under ground-motion records it is integrated in steps, which is exact for a linear structure, and not tuned: see
`tuned_beside`.
"""

import math
from collections.abc import Iterator
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
from damperlab.studies.specification.measure import LIMITS
from damperlab.studies.specification.specification import Specification
from damperlab.studies.tmd.absorber import Absorber
from damperlab.studies.tmd.minimax import minimax
from damperlab.studies.tmd.under_record import STROKE, measures_under

LIMITED = {
    "displacement_m": Judged(),
    "relative_displacement_m": Judged(against_base=True),
    "acceleration_m_per_s2": Judged(order=2),
    "rms_acceleration_m_per_s2": Judged(factor=math.sqrt(0.5), order=2),
}
"""Limits that can apply to a damper with neither friction nor impacts; it satisfies all others."""
MOVED = Judged(stroke=True)
"""The displacement of its mass against the structure."""
DETUNED = 0.02
"""Relative error of its natural frequency at which it is judged too, to show the sensitivity to its tuning."""


@dataclass(frozen=True)
class Beside:
    """A tuned mass damper under the same specification.

    Parameters
    ----------
    absorber : Absorber
        Tuned either for the smallest worst case of the measure, over the bands and within the tolerances, or for the
        smallest peak over all frequencies.
    for_bands : bool
        Whether it is tuned for the bands, and not for the smallest peak over all frequencies.
    value : float
        Its worst case over band, amplitudes and tolerances, in the unit of the measure.
    nominal : float
        The worst case without tolerances.
    detuned : float
        The worst case if its own natural frequency is also off by up to `DETUNED`, either way. Under records no
        smaller deviation is tried, and only two structures: the nominal one and the one with the worst case.
    stroke, detuned_stroke : float
        The largest displacement of its mass against the structure within the tolerances: tuned, and detuned by
        `DETUNED`.
    exceeded : tuple of str
        Limits on results that it exceeds within the tolerances.
    """

    absorber: Absorber
    for_bands: bool
    value: float
    nominal: float
    detuned: float
    stroke: float
    detuned_stroke: float
    exceeded: tuple[str, ...]


def tuned_beside(asked: Specification, mass_ratio: float) -> Beside | None:
    """Tune the absorber of a mass, and judge it like the dampers; None without mass, or without a record's samples.

    Mass, natural frequency and damping of the structure deviate within their tolerances, and the absorber keeps its
    tuning. It is tuned for the smallest worst case over the given bands, but not for records. Under records, the
    tuning with the smallest peak over all frequencies is judged too. The one with the smaller worst case under all
    excitations is used.
    """
    if mass_ratio <= 0.0 or any(
        source.id not in records.motions for records in asked.records for source in records.sources
    ):
        return None
    # records shake the base
    forced = not asked.records and all(each.motion.force for each in asked.excitations)
    usual = minimax(mass_ratio, asked.structure.damping_ratio, "force" if forced else "base")
    tuned = [tuned_for(asked, usual)] if asked.excitations else []
    absorbers = [*tuned, *([usual] if asked.records else [])]
    return min((_judged(asked, one, one in tuned) for one in absorbers), key=lambda each: each.value)


def _judged(asked: Specification, absorber: Absorber, for_bands: bool) -> Beside:
    """Judge an absorber: under the records on some structures, over the bands on the structure with the worst case."""
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
    exceeded = tuple(
        name for name, limit in asked.limits.items() if max(_limited(asked, absorber, every, name)) > limit
    )
    return Beside(
        absorber,
        for_bands,
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
    """The largest value of the measure under the records."""
    return max((results[name] for name, results in built.measured), default=0.0)


def _stroke_under(built: Built) -> float:
    """The largest stroke under the records."""
    return max((results[STROKE] for _, results in built.measured), default=0.0)


def curve(
    asked: Specification, amplitude: Amplitude, absorber: Absorber, r: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Give the measure over frequency on the nominal structure, under an amplitude."""
    judged, structure = judged_of(asked), asked.structure
    own = structure.angular_frequency if asked.in_units else 1.0
    moved = response(amplitude.excitation, judged, absorber, structure.damping_ratio, r)
    found: NDArray[np.float64] = judged.factor * amplitude.base_m(r) * rates(judged, own, r) * moved
    return found


def _shaken(asked: Specification, tuned: Absorber, shares: dict[str, float]) -> Built:
    """Give the structure with these deviations, and its results under the records."""
    on = built(asked, tuned, shares)
    omega = asked.structure.angular_frequency * (1.0 + on.shift)
    return replace(on, measured=tuple(_under_records(asked, on.absorber, on.damping, omega)))


def _under_records(
    asked: Specification, absorber: Absorber, damping: float, omega: float
) -> Iterator[tuple[str, dict[str, float]]]:
    for records in asked.records:
        for source, cases in groupby(records.cases, key=lambda case: case.source):
            # a linear structure: its response is proportional to the record
            once = measures_under(absorber, damping, omega, records.motions[source.id], 1.0, records.tail_s)
            for case in cases:
                results = {name: case.scale * value for name, value in once.items()}
                yield asked.measured(case).variable, results


def _limited(asked: Specification, absorber: Absorber, every: list[Built], name: str) -> Iterator[float]:
    """Give the largest limited result under all excitations, on every structure."""
    yield 0.0  # without impacts and friction
    if name not in LIMITED:
        return
    judged = LIMITED[name]
    # a limit in ratios is checked in the structure's own units
    unit = 1.0 if asked.in_units else asked.structure.angular_frequency**judged.order
    yield unit * hardest(asked, absorber, judged)[0]
    for each in every:
        yield from (results[LIMITS[name].under_record] for _, results in each.measured)
