"""The structure as it may be built, off by its tolerances, with an absorber on it."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np

from damperlab.studies.design.absorber_band import Absorbers, Floats, Judged, worst_of_each, worst_over
from damperlab.studies.specification.specification import Specification
from damperlab.studies.tmd.absorber import Absorber

AGAINST_BASE = "worst_relative_displacement"
"""The measure of a band that is against the base."""
FREQUENCY, DAMPING, TUNING = "natural_frequency_hz", "damping_ratio", "tuning"
OFF = {
    "mass_kg": (-1.0, 0.0, 1.0),
    FREQUENCY: (-1.0, -0.5, 0.0, 0.5, 1.0),
    DAMPING: (-1.0, 1.0),
    TUNING: (-1.0, 0.0, 1.0),
}
"""Shares of its tolerances by which a structure is tried first, and of its detuning an absorber; between them: `hardest`."""
PLACES, HIGHS, EXACT = 41, 16, 3
"""Shares that are looked at over a range, how many of the highest places are looked around, and told exactly."""
CLOSER, ROUNDS = 4, 6
"""How much closer about each of them every time, and how often."""


@dataclass(frozen=True)
class Built:
    """A structure that is off by its tolerances, with the absorber as it was tuned.

    Parameters
    ----------
    absorber : Absorber or Absorbers
        In its ratios to this structure; many, where they are looked among.
    damping, shift, stiffness : float or array
        ζ, the share by which ω_n is off, and the stiffness over the nominal one.
    measured : tuple
        The variable of the measure under each record, and all results.
    """

    absorber: Any
    damping: Any
    shift: Any
    stiffness: Any
    measured: tuple[tuple[str, dict[str, float]], ...] = ()


def judged_of(asked: Specification) -> Judged:
    """Give what the measure of a specification is of a response over a band."""
    measure = asked.measure
    return Judged(measure.factor, measure.order, measure.name == AGAINST_BASE, measure.mean)


def structures(asked: Specification) -> Iterator[dict[str, float]]:
    """Shares by which what is known of the structure is off: first none, then some over the whole range of the tolerances."""
    off = {name: OFF[name] for name in OFF if name in asked.tolerances}
    yield dict.fromkeys(off, 0.0)
    for sides in product(*off.values()):
        if any(sides):
            yield {name: side * asked.tolerances[name].size for name, side in zip(off, sides, strict=True)}


def built(asked: Specification, tuned: Absorber | Absorbers, shares: Mapping[str, float | Floats]) -> Built:
    """Give the structure that is off by these shares, or many, with the absorber; under no record yet."""
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
    """Give what is judged over each band that is asked for."""
    own = (asked.structure.angular_frequency if asked.in_units else 1.0) * (1.0 + built.shift)
    for each in asked.excitations:
        value = worst(each, judged, built.absorber, built.damping, built.shift)
        yield value * own**judged.order / (built.stiffness if each.motion.force else 1.0)


def hardest(
    asked: Specification, absorber: Absorber, judged: Judged, detuning: float = 0.0
) -> tuple[float, dict[str, float]]:
    """Give the largest of what is judged over the bands within the tolerances, and the structure that reaches it.

    Damping is at an end of its tolerance. Natural frequency, mass and, where it may be off, the tuning of the absorber are
    anywhere within theirs, for a light damper moves most where a narrow peak meets an end of a band. They are looked over one
    after the other through each structure of a coarse grid; about the highest places of all that is done ever closer.

    Parameters
    ----------
    asked, absorber, judged
        What shakes, what on it, and what counts.
    detuning : float
        The share by which the natural frequency of the absorber may be off.

    Returns
    -------
    float
        0 where there is no band.
    dict of float
        The shares by which the structure is off, and the absorber (`TUNING`).
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
    """Places (n, k) with each of these shares, (m,) or (n, m), at position i: (n, m, k)."""
    line = np.repeat(places[:, None], shares.shape[-1], axis=1)
    line[:, :, i] = shares
    return line
