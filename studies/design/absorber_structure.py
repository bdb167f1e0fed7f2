"""The structure as it may be built, off by its tolerances, with an absorber on it."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from itertools import product
from typing import Any

import numpy as np

from damperlab.studies.design.absorber_band import Absorbers, Judged, worst_over
from damperlab.studies.specification.specification import Specification
from damperlab.studies.tmd.absorber import Absorber

AGAINST_BASE = "worst_relative_displacement"
"""The measure of a band that is against the base."""
OFF = {
    "mass_kg": (-1.0, 0.0, 1.0),
    "natural_frequency_hz": (-1.0, -0.5, 0.0, 0.5, 1.0),
    "damping_ratio": (-1.0, 1.0),
}
"""Shares of its tolerances by which a structure is tried first. Between them its response may be much larger: see `hardest`."""
FREQUENCY = "natural_frequency_hz"
PLACES, HIGHS = 41, 2
"""Shares that are looked at over a range, and how many of its highest places are looked around."""
CLOSER, ROUNDS = 4, 6
"""How much closer about each of them every time, and how often."""


@dataclass(frozen=True)
class Built:
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


def judged_of(asked: Specification) -> Judged:
    """Give what the measure of a specification is of a response over a band."""
    measure = asked.measure
    return Judged(measure.factor, measure.order, measure.name == AGAINST_BASE, measure.mean)


def structures(asked: Specification) -> Iterator[dict[str, float]]:
    """Shares by which what is known of the structure is off: first none, then some over the whole range of the tolerances."""
    off = {name: sides for name, sides in OFF.items() if name in asked.tolerances}
    yield dict.fromkeys(off, 0.0)
    for sides in product(*off.values()):
        if any(sides):
            yield {name: side * asked.tolerances[name].size for name, side in zip(off, sides, strict=True)}


def built(asked: Specification, tuned: Absorber | Absorbers, shares: dict[str, float]) -> Built:
    """Give the structure that is off by these shares; under no record yet."""
    mass, shift = shares.get("mass_kg", 0.0), shares.get(FREQUENCY, 0.0)
    damping = min(asked.structure.damping_ratio * (1.0 + shares.get("damping_ratio", 0.0)), 0.999)
    absorber = type(tuned)(
        tuned.mass_ratio / (1.0 + mass),
        tuned.tuning / (1.0 + shift),  # type: ignore[arg-type]
        tuned.damping_ratio,  # type: ignore[arg-type]
    )
    return Built(absorber, damping, shift, (1.0 + mass) * (1.0 + shift) ** 2)


def over_bands(
    asked: Specification, built: Built, judged: Judged, worst: Callable[..., Any] = worst_over
) -> Iterator[Any]:
    """Give what is judged over each band that is asked for."""
    own = (asked.structure.angular_frequency if asked.in_units else 1.0) * (1.0 + built.shift)
    for each in asked.excitations:
        value = worst(each, judged, built.absorber, built.damping, built.shift)
        yield value * own**judged.order / (built.stiffness if each.motion.force else 1.0)


def hardest(asked: Specification, absorber: Absorber, judged: Judged) -> tuple[float, dict[str, float]]:
    """Give the largest of what is judged over the bands within the tolerances, and the structure that reaches it.

    Mass and damping are at the ends of their tolerances; the natural frequency is anywhere within its own, for a light damper
    moves most where a narrow peak meets an end of the band.
    """

    def reached(shares: dict[str, float]) -> float:
        return max(map(float, over_bands(asked, built(asked, absorber, shares), judged)), default=0.0)

    found = [(reached(shares), shares) for shares in structures(asked)]
    if FREQUENCY in asked.tolerances:
        size = asked.tolerances[FREQUENCY].size
        for corner in [shares for _, shares in found if shares[FREQUENCY] == 0.0]:
            value, share = largest(partial(_at, reached, corner), size)
            found.append((value, {**corner, FREQUENCY: share}))
    return max(found, key=lambda each: each[0])


def _at(reached: Callable[[dict[str, float]], float], corner: dict[str, float], share: float) -> float:
    return reached({**corner, FREQUENCY: share})


def largest(reached: Callable[[float], float], size: float) -> tuple[float, float]:
    """Give the largest that is reached where something is off by a share between −size and size, and that share."""
    step = 2.0 * size / (PLACES - 1)
    sides = np.linspace(-size, size, PLACES).tolist()
    values = [reached(side) for side in sides]
    padded = [-np.inf, *values, -np.inf]
    tops = [i for i in range(PLACES) if values[i] >= max(padded[i], padded[i + 2])]
    found = []
    for i in sorted(tops, key=lambda i: -values[i])[:HIGHS]:
        best, width = (values[i], sides[i]), step
        for _ in range(ROUNDS):
            near = np.clip(best[1] + width * np.linspace(-1.0, 1.0, 2 * CLOSER + 1), -size, size).tolist()
            best = max([best, *((reached(side), side) for side in near)])
            width /= CLOSER
        found.append(best)
    return max(found)
