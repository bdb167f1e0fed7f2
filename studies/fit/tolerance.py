"""Intervals of a fit as tolerances of a specification."""

from collections.abc import Iterable, Iterator
from decimal import ROUND_CEILING, Decimal
from math import isinf

from damperlab.studies.fit.prototype import EQUAL, NAME_OF, Prototype, short
from damperlab.studies.specification.tolerance_fields import SHARE

MEANINGS = {
    "mass_kg": "the mass",
    "natural_frequency_hz": "the natural frequency",
    "damping_ratio": "the damping ratio",
    "clearance_m": "the clearance",
    "friction_force_n": "the friction force",
    "particle_mass_kg": "the mass of the particle",
    "restitution": "the restitution",
}
DIGITS = 3


def tolerances_of(prototype: Prototype, names: Iterable[str]) -> dict[str, str | float]:
    """Write how far an interval reaches to either side, rounded up.

    Parameters
    ----------
    prototype : Prototype
        What was found.
    names : iterable of str
        Of which quantities.

    Returns
    -------
    dict
        A share of the value as in ``1.2%``, of a restitution the difference; at most the half that a specification takes.
        What was not estimated has none, nor has what is 0.
    """
    found: dict[str, str | float] = {}
    for name in names:
        off = prototype.off.get(name, 0.0)
        if off == 0.0 or isinf(off):
            continue
        off += _rounding(prototype.values[name], name == "restitution")
        if name == "restitution":
            found[name] = min(float(rounded_up(off)), SHARE.highest * max(map(short, prototype.values[name])))
        else:
            found[name] = f"{100 * rounded_up(min(off, SHARE.highest)):f}".rstrip("0").rstrip(".") + "%"
    return found


def spoken(names: Iterable[str]) -> str:
    """Name quantities in a sentence."""
    *others, last = (MEANINGS.get(NAME_OF.get(name, name), f"the {name}") for name in names)
    return f"{', '.join(others)} and {last}" if others else last


def rounded_up(size: float) -> Decimal:
    """Round up to `DIGITS` digits, so that nothing of an interval is lost but what floating-point numbers add to it."""
    exact = Decimal(size * (1.0 - EQUAL))
    return exact.quantize(Decimal(1).scaleb(exact.adjusted() - DIGITS + 1), ROUND_CEILING)


def _rounding(values: tuple[float, ...], absolute: bool) -> float:
    """Give how far rounding has moved values, as they are written, from the middle of their intervals."""
    return max(abs(short(value) - value) / (1.0 if absolute else value or 1.0) for value in values)


def _share(prototype: Prototype, name: str) -> float:
    """Give how far an interval reaches, as a share of the value."""
    off = prototype.off[name]
    return off / max(prototype.values[name]) if name == "restitution" else off


def say_tolerances(prototype: Prototype, names: Iterable[str]) -> Iterator[str]:
    """Say where tolerances come from, and what of the intervals they do not hold.

    Parameters
    ----------
    prototype : Prototype
        What was found.
    names : iterable of str
        The quantities that were given tolerances.
    """
    names = [name for name in names if name in prototype.off]
    written = [name for name in names if not isinf(prototype.off[name])]
    if written:
        yield (
            f"Tolerances of {spoken(written)} are what the intervals of "
            f"{100 * prototype.confidence:g} % reach to their farther side."
        )
    for name in names:
        off = prototype.off[name]
        if isinf(off):
            yield (
                f"The interval of {MEANINGS[name]} begins at 0, which is the best value too, so that no share of it is a "
                "tolerance: none is written. Measure it in another way."
            )
        elif (share := _share(prototype, name)) > SHARE.highest:
            yield (
                f"The interval of {MEANINGS[name]} reaches to {100 * share:.3g} % from its value, and a specification takes at "
                "most 50 %: that is written, and what lies beyond is not looked at. Measure it better before you build."
            )
    for name in names:
        if name in prototype.undetermined:
            yield f"The measurement says nothing about {MEANINGS[name]}; its value is one of many that agree as well."
