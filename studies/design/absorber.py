"""The tuned mass damper of the same mass, on the same structure with the same tolerances, in closed form.

Under ground-motion records it is stepped, which is exact for a linear structure; where there are records alone, it is tuned for
a harmonic base.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.design.absorber_band import (
    Absorbers,
    Floats,
    Judged,
    rates,
    response,
    worst_of_each,
    worst_over,
)
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
OFF = {
    "mass_kg": (-1.0, 0.0, 1.0),
    "natural_frequency_hz": (-1.0, -0.5, 0.0, 0.5, 1.0),
    "damping_ratio": (-1.0, 1.0),
}
"""Tolerances by which the structure is tried. One tuned for the corners alone has its worst response between them."""
DETUNED = 0.02
"""By which the natural frequency of a tuned mass damper is off, to show how much hangs on its tuning."""
TUNINGS, DAMPINGS = np.exp(np.linspace(-0.4, 0.5, 37)), np.exp(np.linspace(-5.0, 1.0, 13))
"""Where tuning and damping are looked for, over those of the least peak at any frequency."""
LOWS = 3
"""So many of the lowest places of that grid are looked around."""
WIDE = (0.05, 0.8)
"""How far around them tuning and damping are looked for, by their logarithms."""
SIDE = np.linspace(-1.0, 1.0, 5)
CLOSER, ROUNDS = 0.7, 20
"""A grid of `SIDE` × `SIDE` is laid about the best so often, each time so much closer."""


@dataclass(frozen=True)
class Beside:
    """A tuned mass damper under the same specification.

    Parameters
    ----------
    absorber : Absorber
        Tuned for the least worst case of what is judged over the bands, within the tolerances; where there are records alone,
        for the least peak under a harmonic base.
    value : float
        Its worst case over band, amplitudes and tolerances, in the unit of the measure.
    nominal : float
        The same without tolerances.
    detuned : float
        The worst case where its own natural frequency is off by `DETUNED` too, either way.
    exceeded : tuple of str
        Limits on results that it does not keep within the tolerances.
    """

    absorber: Absorber
    value: float
    nominal: float
    detuned: float
    exceeded: tuple[str, ...]


def tuned_beside(asked: Specification, mass_ratio: float) -> Beside | None:
    """Tune the absorber of a mass, and judge it as the dampers are judged; None without mass, or without a record's samples.

    Mass, natural frequency and damping of the structure are off within their tolerances (`OFF`); the absorber stays as it was
    tuned: for the least worst case of just that, over the bands that are asked for.
    """
    if mass_ratio <= 0.0 or any(
        source.id not in records.motions for records in asked.records for source in records.sources
    ):
        return None
    forced = bool(asked.excitations) and all(each.motion.force for each in asked.excitations)
    absorber = minimax(mass_ratio, asked.structure.damping_ratio, "force" if forced else "base")
    if asked.excitations:
        absorber = _tuned_for(asked, absorber)
    every = [_shaken(asked, absorber, shares) for shares in _structures(asked)]
    values = [_worst(asked, each) for each in every]
    off = [absorber.detuned(share) for share in (-DETUNED, DETUNED)]
    detuned = [_worst(asked, _shaken(asked, one, shares)) for one in off for shares in _structures(asked)]
    exceeded = tuple(
        name for name, limit in asked.limits.items() if max(_limited(asked, every, name)) > limit
    )
    return Beside(absorber, max(values), values[0], max(values + detuned), exceeded)


def _worst(asked: Specification, built: "_Built") -> float:
    under_records = (results[name] for name, results in built.measured)
    return float(max((*_over_bands(asked, built, judged_of(asked)), *under_records)))


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
    absorber : Absorber or Absorbers
        In its ratios to this structure; many, where they are looked among.
    damping, shift, stiffness : float
        ζ, the share by which ω_n is off, and the stiffness over the nominal one.
    measured : tuple
        The variable of the measure under each record, and all results.
    """

    absorber: Any
    damping: float
    shift: float
    stiffness: float
    measured: tuple[tuple[str, dict[str, float]], ...] = ()


def _structures(asked: Specification) -> Iterator[dict[str, float]]:
    """Shares by which what is known of the structure is off: first none, then some over the whole range of the tolerances."""
    off = {name: sides for name, sides in OFF.items() if name in asked.tolerances}
    yield dict.fromkeys(off, 0.0)
    for sides in product(*off.values()):
        if any(sides):
            yield {name: side * asked.tolerances[name].size for name, side in zip(off, sides, strict=True)}


def _built(asked: Specification, tuned: Absorber | Absorbers, shares: dict[str, float]) -> _Built:
    """Give the structure that is off by these shares; under no record yet."""
    mass, shift = shares.get("mass_kg", 0.0), shares.get("natural_frequency_hz", 0.0)
    damping = min(asked.structure.damping_ratio * (1.0 + shares.get("damping_ratio", 0.0)), 0.999)
    absorber = type(tuned)(
        tuned.mass_ratio / (1.0 + mass),
        tuned.tuning / (1.0 + shift),  # type: ignore[arg-type]
        tuned.damping_ratio,  # type: ignore[arg-type]
    )
    return _Built(absorber, damping, shift, (1.0 + mass) * (1.0 + shift) ** 2)


def _shaken(asked: Specification, tuned: Absorber, shares: dict[str, float]) -> _Built:
    """Give the same under the records."""
    built = _built(asked, tuned, shares)
    omega = asked.structure.angular_frequency * (1.0 + built.shift)
    return replace(built, measured=tuple(_under_records(asked, built.absorber, built.damping, omega)))


def _over_bands(
    asked: Specification, built: _Built, judged: Judged, worst: Callable[..., Any] = worst_over
) -> Iterator[Any]:
    own = (asked.structure.angular_frequency if asked.in_units else 1.0) * (1.0 + built.shift)
    for each in asked.excitations:
        value = worst(each, judged, built.absorber, built.damping, built.shift)
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


def _tuned_for(asked: Specification, start: Absorber) -> Absorber:
    """Tune an absorber for the least worst case over the bands."""
    judged = judged_of(asked)
    # more damping of the structure hardly ever lets it move more
    structures = [shares for shares in _structures(asked) if shares.get("damping_ratio", 0.0) <= 0.0]

    def worst(tunings: Floats, dampings: Floats) -> Floats:
        many = Absorbers(start.mass_ratio, tunings, dampings)
        every = [_built(asked, many, shares) for shares in structures]
        return np.asarray(
            np.max(
                [value for each in every for value in _over_bands(asked, each, judged, worst_of_each)], axis=0
            )
        )

    tunings, dampings = start.tuning * TUNINGS, start.damping_ratio * DAMPINGS
    heights = worst(*(side.ravel() for side in np.meshgrid(tunings, dampings, indexing="ij")))
    begin = _lows(heights.reshape(tunings.size, dampings.size))
    starts = [start, *(Absorber(start.mass_ratio, float(tunings[i]), float(dampings[j])) for i, j in begin)]
    return min((_least(worst, one) for one in starts), key=lambda found: found[0])[1]


def _lows(heights: Floats) -> list[tuple[int, int]]:
    """Give the places that are no higher than those about them, the `LOWS` lowest."""
    padded = np.pad(heights, 1, constant_values=math.inf)
    rows, columns = heights.shape
    about = [padded[i : i + rows, j : j + columns] for i, j in product(range(3), repeat=2)]
    places = np.argwhere(heights <= np.minimum.reduce(about))
    lowest = sorted(places.tolist(), key=lambda at: float(heights[at[0], at[1]]))
    return [(i, j) for i, j in lowest[:LOWS]]


def _least(worst: Callable[[Floats, Floats], Floats], best: Absorber) -> tuple[float, Absorber]:
    """Lay grids of `SIDE` × `SIDE` ever closer about the best so far."""
    width = np.array(WIDE)
    p, q = (side.ravel() for side in np.meshgrid(SIDE, SIDE, indexing="ij"))
    value = math.inf
    for _ in range(ROUNDS):
        tunings, dampings = best.tuning * np.exp(width[0] * p), best.damping_ratio * np.exp(width[1] * q)
        values = worst(tunings, dampings)
        least = int(values.argmin())
        value = float(values[least])
        best = Absorber(best.mass_ratio, float(tunings[least]), float(dampings[least]))
        width = width * CLOSER
    return value, best
