"""A structure with deviations within the tolerances, and an absorber on this structure."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np

from damperlab.studies.design.absorber_band import Absorbers, Floats, Judged, worst_of_each, worst_over
from damperlab.studies.specification.specification import Specification
from damperlab.studies.tmd.absorber import Absorber

AGAINST_BASE = "worst_relative_displacement"
"""Name of the measure that is a displacement relative to the base, over a band."""
FREQUENCY, DAMPING, TUNING = "natural_frequency_hz", "damping_ratio", "tuning"
OFF = {
    "mass_kg": (-1.0, 0.0, 1.0),
    FREQUENCY: (-1.0, -0.5, 0.0, 0.5, 1.0),
    DAMPING: (-1.0, 1.0),
    TUNING: (-1.0, 0.0, 1.0),
}
"""Fractions of the structure's tolerances, and of an absorber's detuning, that are tried first. `hardest` then
searches between these fractions.
"""
PLACES, HIGHS, EXACT = 41, 16, 3
"""Number of values over the range of a deviation, number of the highest points that are refined, and number of the
refined points that are computed exactly.
"""
CLOSER, ROUNDS = 4, 6
"""Factor by which each refinement reduces the step, and the number of refinements."""


@dataclass(frozen=True)
class Built:
    """A structure with deviations from the nominal values, and an absorber on this structure.

    Parameters
    ----------
    absorber : Absorber or Absorbers
        The absorber, with ratios relative to this structure; arrays for several absorbers or structures.
    damping, shift, stiffness : float or array
        ζ, the relative deviation of ω_n, and the stiffness divided by the nominal stiffness.
    measured : tuple
        One entry for each record and scale: the variable of the measure, and all results by variable.
    """

    absorber: Any
    damping: Any
    shift: Any
    stiffness: Any
    measured: tuple[tuple[str, dict[str, float]], ...] = ()


def judged_of(asked: Specification) -> Judged:
    """Convert the measure of a specification to the quantity that is judged over a band."""
    measure = asked.measure
    return Judged(measure.factor, measure.order, measure.name == AGAINST_BASE, measure.mean)


def structures(asked: Specification) -> Iterator[dict[str, float]]:
    """Yield deviations of the structure: first none, then a grid over the complete range of the tolerances."""
    off = {name: OFF[name] for name in OFF if name in asked.tolerances}
    yield dict.fromkeys(off, 0.0)
    for sides in product(*off.values()):
        if any(sides):
            yield {name: side * asked.tolerances[name].size for name, side in zip(off, sides, strict=True)}


def built(asked: Specification, tuned: Absorber | Absorbers, shares: Mapping[str, float | Floats]) -> Built:
    """Return one or several structures with the deviations `shares`, and the absorber. Results under records are left
    out.
    """
    mass = shares.get("mass_kg", 0.0)
    shift, off = asked.structure.built_off(mass, shares.get(FREQUENCY, 0.0), shares.get(DAMPING, 0.0))
    damping = np.minimum(asked.structure.damping_ratio * (1.0 + off), 0.999)
    tuning = tuned.tuning * (1.0 + shares.get(TUNING, 0.0)) / (1.0 + shift)
    ratio = tuned.mass_ratio / (1.0 + mass)
    if isinstance(tuned, Absorber) and not any(map(np.ndim, shares.values())):
        on: Absorber | Absorbers = Absorber(ratio, tuning, tuned.damping_ratio)  # type: ignore[arg-type]
    else:
        on = Absorbers(*np.broadcast_arrays(ratio, tuning, tuned.damping_ratio))
    return Built(on, damping, shift, (1.0 + mass) * (1.0 + shift) ** 2)


def over_bands(
    asked: Specification, built: Built, judged: Judged, worst: Callable[..., Any] = worst_over
) -> Iterator[Any]:
    """Yield the judged quantity over the band of each excitation."""
    own = (asked.structure.angular_frequency if asked.in_units else 1.0) * (1.0 + built.shift)
    for each in asked.excitations:
        value = worst(each, judged, built.absorber, built.damping, built.shift)
        yield value * own**judged.order / (built.stiffness if each.motion.force else 1.0)


def hardest(
    asked: Specification, absorber: Absorber, judged: Judged, detuning: float = 0.0
) -> tuple[float, dict[str, float]]:
    """Return the largest judged value over the bands and all tolerances, and the deviations that cause it.

    The worst damping is at an end of the tolerance. The worst values of natural frequency, mass and tuning may lie
    anywhere within the tolerances. For example, a lightly damped structure may move most if a narrow peak coincides
    with an end of a band. Natural frequency, mass and tuning are varied one after the other, starting from each
    structure of a coarse grid. Ever smaller steps are then tried around the structures with the highest values.

    Parameters
    ----------
    asked, absorber, judged
        Specification, absorber, and judged quantity.
    detuning : float
        The allowed relative deviation of the absorber's natural frequency.

    Returns
    -------
    float
        The largest value; 0 if there is no band.
    dict of float
        The deviations of the structure, and of the tuning of the absorber (`TUNING`).
    """
    sizes = {name: asked.tolerances[name].size for name in OFF if name in asked.tolerances}
    sizes |= {TUNING: detuning} if detuning else {}
    names = list(sizes)

    def exactly(place: Floats) -> tuple[float, dict[str, float]]:
        shares = dict(zip(names, place.tolist(), strict=True))
        on = built(asked, absorber, shares)
        return max(map(float, over_bands(asked, on, judged)), default=0.0), shares

    if not names or not asked.excitations:
        return exactly(np.zeros(len(names)))

    def reached(places: Floats) -> Floats:
        on = built(asked, absorber, dict(zip(names, places.reshape(-1, len(names)).T, strict=True)))
        values = np.max(list(over_bands(asked, on, judged, worst_of_each)), axis=0)
        return np.asarray(values.reshape(places.shape[:-1]))

    grid = np.array([[0.0] * len(names), *product(*(np.multiply(OFF[name], sizes[name]) for name in names))])
    places, heights = [grid], [reached(grid)]
    anywhere = [(i, sizes[name]) for i, name in enumerate(names) if name != DAMPING]
    for i, size in anywhere:
        line = _along(grid[grid[:, i] == 0.0], i, np.linspace(-size, size, PLACES))
        height = reached(line)
        padded = np.pad(height, ((0, 0), (1, 1)), constant_values=-np.inf)
        top = height >= np.maximum(padded[:, :-2], padded[:, 2:])
        places.append(line[top])
        heights.append(height[top])
    best = np.concatenate(places)[np.argsort(-np.concatenate(heights), kind="stable")[:HIGHS]]
    width = 2.0 / (PLACES - 1)
    for _ in range(ROUNDS):
        for i, size in anywhere:
            near = best[:, i, None] + width * size * np.linspace(-1.0, 1.0, 2 * CLOSER + 1)
            line = _along(best, i, np.clip(near, -size, size))
            best = line[np.arange(len(best)), reached(line).argmax(axis=1)]
        width /= CLOSER
    highest = best[np.argsort(-reached(best), kind="stable")[:EXACT]]
    return max(map(exactly, highest), key=lambda each: each[0])


def _along(places: Floats, i: int, shares: Floats) -> Floats:
    """Return the points `places`, (n, k), with coordinate i replaced by each of the m fractions `shares`: (n, m, k)."""
    line = np.repeat(places[:, None], shares.shape[-1], axis=1)
    line[:, :, i] = shares
    return line
