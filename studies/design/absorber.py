"""The tuned mass damper of the same mass, on the same structure with the same tolerances, in closed form.

Under ground-motion records it is stepped, which is exact for a linear structure; it stays tuned for a harmonic base, or for a
force where nothing else shakes the structure.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.design.absorber_band import FEWER, Judged, rates, response, worst_over
from damperlab.studies.specification.excitation import Amplitude
from damperlab.studies.specification.measure import LIMITS
from damperlab.studies.specification.specification import Specification
from damperlab.studies.tmd.absorber import Absorber
from damperlab.studies.tmd.minimax import minimax
from damperlab.studies.tmd.under_record import measures_under

AGAINST_BASE = "worst_relative_displacement"
"""The measure of a band that is against the base."""
LIMITED = {
    "displacement_m": Judged(),
    "relative_displacement_m": Judged(against_base=True),
    "acceleration_m_per_s2": Judged(order=2),
    "rms_acceleration_m_per_s2": Judged(factor=math.sqrt(0.5), order=2),
}
"""What limits on results are about of a damper that neither rubs nor rattles; the others it keeps."""
WIDE = (0.3, 2.0)
"""How far tuning and damping are looked for about those of the least peak, by their logarithms."""
SIDE = np.linspace(-1.0, 1.0, 9)
CLOSER = 0.5
ROUNDS = 16
"""A grid of `SIDE` × `SIDE` is laid about the best so often, each time so much closer."""


@dataclass(frozen=True)
class Beside:
    """A tuned mass damper under the same specification.

    Parameters
    ----------
    absorber : Absorber
        Tuned for the least peak on the nominal structure; where the rms over the band is judged for the least of that.
    value : float
        Its worst case over band, amplitudes and tolerances, in the unit of the measure.
    nominal : float
        The same without tolerances.
    exceeded : tuple of str
        Limits on results that it does not keep within the tolerances.
    """

    absorber: Absorber
    value: float
    nominal: float
    exceeded: tuple[str, ...]


def tuned_beside(asked: Specification, mass_ratio: float) -> Beside | None:
    """Tune the absorber of a mass, and judge it as the dampers are judged; None without mass, or without a record's samples.

    Mass, natural frequency and damping of the structure are off by their tolerances, every corner; the absorber stays as it
    was tuned.
    """
    if mass_ratio <= 0.0 or any(
        source.id not in records.motions for records in asked.records for source in records.sources
    ):
        return None
    forced = bool(asked.excitations) and all(each.motion.force for each in asked.excitations)
    absorber = minimax(mass_ratio, asked.structure.damping_ratio, "force" if forced else "base")
    if asked.measure.mean:
        absorber = _tuned_for_mean(asked, absorber)
    every = [_built(asked, absorber, shares) for shares in _corners(asked)]
    values = [
        max(
            (*_over_bands(asked, each, judged_of(asked)), *(results[name] for name, results in each.measured))
        )
        for each in every
    ]
    exceeded = tuple(
        name for name, limit in asked.limits.items() if max(_limited(asked, every, name)) > limit
    )
    return Beside(absorber, max(values), values[0], exceeded)


def judged_of(asked: Specification) -> Judged:
    """Give what the measure of a specification is of a response over a band."""
    measure = asked.measure
    return Judged(measure.factor, measure.order, measure.name == AGAINST_BASE, measure.mean)


def curve(
    asked: Specification, amplitude: Amplitude, absorber: Absorber, r: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Give the measure over frequency on the nominal structure, under an amplitude."""
    judged, structure = judged_of(asked), asked.structure
    own = structure.angular_frequency if asked.in_units else 1.0
    moved = response(amplitude.excitation, judged, absorber, structure.damping_ratio, r)
    found: NDArray[np.float64] = judged.factor * amplitude.base_m(r) * rates(judged, own, r) * moved
    return found


@dataclass(frozen=True)
class _Built:
    """A structure that is off by its tolerances, with the absorber as it was tuned.

    Parameters
    ----------
    absorber : Absorber
        In its ratios to this structure.
    damping, shift, stiffness : float
        ζ, the share by which ω_n is off, and the stiffness over the nominal one.
    measured : tuple
        The variable of the measure under each record, and all results.
    """

    absorber: Absorber
    damping: float
    shift: float
    stiffness: float
    measured: tuple[tuple[str, dict[str, float]], ...]


def _corners(asked: Specification) -> Iterator[dict[str, float]]:
    names = [
        name for name in ("mass_kg", "natural_frequency_hz", "damping_ratio") if name in asked.tolerances
    ]
    yield dict.fromkeys(names, 0.0)
    for signs in product((-1.0, 1.0), repeat=len(names)):
        yield {name: sign * asked.tolerances[name].size for name, sign in zip(names, signs, strict=True)}


def _built(asked: Specification, tuned: Absorber, shares: dict[str, float]) -> _Built:
    mass, shift = shares.get("mass_kg", 0.0), shares.get("natural_frequency_hz", 0.0)
    damping = min(asked.structure.damping_ratio * (1.0 + shares.get("damping_ratio", 0.0)), 0.999)
    absorber = Absorber(tuned.mass_ratio / (1.0 + mass), tuned.tuning / (1.0 + shift), tuned.damping_ratio)
    omega = asked.structure.angular_frequency * (1.0 + shift)
    measured = tuple(_under_records(asked, absorber, damping, omega))
    return _Built(absorber, damping, shift, (1.0 + mass) * (1.0 + shift) ** 2, measured)


def _over_bands(asked: Specification, built: _Built, judged: Judged) -> Iterator[float]:
    own = (asked.structure.angular_frequency if asked.in_units else 1.0) * (1.0 + built.shift)
    for each in asked.excitations:
        value = worst_over(each, judged, built.absorber, built.damping, built.shift)
        yield value * own**judged.order / (built.stiffness if each.motion.force else 1.0)


def _under_records(
    asked: Specification, absorber: Absorber, damping: float, omega: float
) -> Iterator[tuple[str, dict[str, float]]]:
    for records in asked.records:
        for case in records.cases:
            motion = records.motions[case.source.id]
            results = measures_under(absorber, damping, omega, motion, case.scale, records.tail_s)
            yield asked.measured(case).variable, results


def _limited(asked: Specification, every: list[_Built], name: str) -> Iterator[float]:
    """Give what of a limited result is reached under everything, on every structure."""
    yield 0.0  # without impacts and friction
    if name not in LIMITED:
        return
    judged = LIMITED[name]
    # a limit in ratios is kept in those of the structure's own units
    unit = 1.0 if asked.in_units else asked.structure.angular_frequency**judged.order
    for built in every:
        yield from (unit * value for value in _over_bands(asked, built, judged))
        yield from (results[LIMITS[name].under_record] for _, results in built.measured)


def _tuned_for_mean(asked: Specification, start: Absorber) -> Absorber:
    """Tune an absorber for the least rms over the bands, by a grid that is laid ever closer about the best."""
    judged = judged_of(asked)
    zeta = asked.structure.damping_ratio

    def mean(absorber: Absorber) -> float:
        return max(worst_over(each, judged, absorber, zeta, 0.0, FEWER) for each in asked.excitations)

    return _least(mean, start)


def _least(judge: Callable[[Absorber], float], best: Absorber) -> Absorber:
    width = np.array(WIDE)
    for _ in range(ROUNDS):
        about = [
            Absorber(best.mass_ratio, best.tuning * math.exp(p), best.damping_ratio * math.exp(q))
            for p in width[0] * SIDE
            for q in width[1] * SIDE
        ]
        best = min(about, key=judge)
        width = width * CLOSER
    return best
