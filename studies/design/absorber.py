"""The tuned mass damper of the same mass, on the same structure with the same tolerances, in closed form.

Under ground-motion records it is stepped, which is exact for a linear structure; it stays tuned for a harmonic base, or for a
force where nothing else shakes the structure.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.design.band_mean import band_mean
from damperlab.studies.specification.excitation import Amplitude, Excitation
from damperlab.studies.specification.specification import Specification
from damperlab.studies.tmd.absorber import Absorber
from damperlab.studies.tmd.minimax import minimax
from damperlab.studies.tmd.transfer import amplitude_ratio, highest
from damperlab.studies.tmd.under_record import measures_under

AGAINST_BASE = "worst_relative_displacement"
"""The measure of a band whose peak has no closed form here."""
SAMPLES = 4001
"""Frequencies at which a response is looked at whose peak has no closed form here, or does not count: against the base; times a
power of the frequency, by which an acceleration grows and the amplitude of a base may fall; by its rms over the band."""


@dataclass(frozen=True)
class Beside:
    """A tuned mass damper under the same specification.

    Parameters
    ----------
    absorber : Absorber
        Tuned for the least peak on the nominal structure.
    value : float
        Its worst case over band, amplitudes and tolerances, in the unit of the measure.
    nominal : float
        The same without tolerances.
    """

    absorber: Absorber
    value: float
    nominal: float


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
    every = [_worst(asked, absorber, shares) for shares in _corners(asked)]
    return Beside(absorber, max(every), every[0])


def curve(
    asked: Specification, amplitude: Amplitude, absorber: Absorber, r: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Give the measure over frequency on the nominal structure, under an amplitude."""
    return (
        asked.measure.factor
        * amplitude.base_m(r)
        * _rates(asked, 0.0, r)
        * _response(asked, amplitude.excitation, absorber, asked.structure.damping_ratio, r)
    )


def _rates(asked: Specification, shift: float, r: NDArray[np.float64]) -> NDArray[np.float64]:
    """Give what makes the measure of a displacement: (ω_n r)² of an acceleration; ω_n is 1 where only ratios mean anything."""
    nominal = asked.structure.angular_frequency if asked.in_units else 1.0
    rates: NDArray[np.float64] = (nominal * (1.0 + shift) * r) ** asked.measure.order
    return rates


def _corners(asked: Specification) -> Iterator[dict[str, float]]:
    names = [
        name for name in ("mass_kg", "natural_frequency_hz", "damping_ratio") if name in asked.tolerances
    ]
    yield dict.fromkeys(names, 0.0)
    for signs in product((-1.0, 1.0), repeat=len(names)):
        yield {name: sign * asked.tolerances[name].size for name, sign in zip(names, signs, strict=True)}


def _worst(asked: Specification, tuned: Absorber, shares: dict[str, float]) -> float:
    shift = shares.get("natural_frequency_hz", 0.0)
    damping = min(asked.structure.damping_ratio * (1.0 + shares.get("damping_ratio", 0.0)), 0.999)
    absorber = Absorber(
        tuned.mass_ratio / (1.0 + shares.get("mass_kg", 0.0)),
        tuned.tuning / (1.0 + shift),
        tuned.damping_ratio,
    )
    omega = asked.structure.angular_frequency * (1.0 + shift)
    stiffness = (1.0 + shares.get("mass_kg", 0.0)) * (1.0 + shift) ** 2
    over = (
        _peak(asked, each, absorber, damping, shift) / (stiffness if each.motion.force else 1.0)
        for each in asked.excitations
    )
    return max((*over, *_under_records(asked, absorber, damping, omega)))


def _under_records(asked: Specification, absorber: Absorber, damping: float, omega: float) -> Iterator[float]:
    for records in asked.records:
        for case in records.cases:
            motion = records.motions[case.source.id]
            measures = measures_under(absorber, damping, omega, motion, case.scale, records.tail_s)
            yield measures[asked.measured(case).variable]


def _peak(
    asked: Specification, excitation: Excitation, absorber: Absorber, damping: float, shift: float
) -> float:
    low, high = excitation.low / (1.0 + shift), excitation.high / (1.0 + shift)
    factor, level = asked.measure.factor, excitation.highest_m
    force, order = excitation.motion.force, asked.measure.order
    if (
        not asked.measure.mean
        and order == excitation.motion.order
        and (force or asked.measure.name != AGAINST_BASE)
    ):
        top = highest(absorber, damping, "force" if force else "base", (low, high))
        # an acceleration under a base of one acceleration: the powers of the frequency cancel
        own = float(_rates(asked, 0.0, np.ones(1))[0])
        return factor * level * own * top.value
    r = np.linspace(low, high, SAMPLES) if high > low else np.array([low])
    base_m = excitation.base_m(level, r * (1.0 + shift))
    rates = _rates(asked, shift, r)
    values = factor * base_m * rates * _response(asked, excitation, absorber, damping, r)
    if asked.measure.mean:
        return band_mean(r, values, np.zeros_like(r)).value
    return float(values.max())


def _response(
    asked: Specification,
    excitation: Excitation,
    absorber: Absorber,
    damping: float,
    r: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Amplitude ratio, absolute or against the base; see `damperlab.studies.tmd.transfer.amplitude_ratio`."""
    if excitation.motion.force:
        return amplitude_ratio(r, absorber, damping, "force")
    square = r * r
    link = absorber.tuning**2 + 2j * absorber.damping_ratio * absorber.tuning * r
    structure = 1 + 2j * damping * r
    bottom = (structure - square) * (link - square) - absorber.mass_ratio * square * link
    top = structure * (link - square)
    if asked.measure.name == AGAINST_BASE:
        top = top - bottom
    with np.errstate(divide="ignore", invalid="ignore"):
        found = np.abs(top / bottom)
    return np.where(np.isfinite(found), found, math.inf)
