"""The drawing of a damper: each quantity with its value, tolerance and margin."""

from functools import partial

from damperlab.studies.brief import Damper
from damperlab.studies.design.absorber import DETUNED, Beside
from damperlab.studies.design.found import Found
from damperlab.studies.design.spelling import CALLED, frequency, length, quantity
from damperlab.studies.design.verdict import kind_of
from damperlab.studies.specification.specification import CHOSEN, OF_DAMPER, Specification

Line = tuple[str, str, str, str]
"""A quantity, its value, its tolerance, and the range in which the quantity may change while all others stay."""


def drawing_of(found: Found, damper: Damper) -> list[Line]:
    """Return the lines of the drawing of a damper; empty if there is no damper to draw.

    Parameters
    ----------
    found : Found
        The findings of the search.
    damper : str
        Kind of the damper to draw.
    """
    asked = found.asked
    if damper == "tuned_mass_damper":
        return [] if found.heaviest is None else _absorber(asked, found.heaviest)
    if damper == kind_of(found.build):
        build, margins = found.build, found.margins
    elif damper in found.alternatives:
        build, margins = found.alternatives[damper].build, {}
    else:
        return []
    lines: list[Line] = []
    for name in OF_DAMPER:
        if build.particle_mass_kg == 0.0 and name != "friction_force_n":
            continue
        if name not in CHOSEN and not asked.choices[name].stop:
            continue
        value = build.value(name)
        tolerance = asked.tolerances.get(name)
        margin = margins.get(name)
        lines.append(
            (
                CALLED[name],
                quantity(asked, name, value),
                "" if tolerance is None else f"± {quantity(asked, name, tolerance.of(value))}",
                "" if margin is None else margin.span(partial(quantity, asked, name)),
            )
        )
    return lines


def _absorber(asked: Specification, beside: Beside) -> list[Line]:
    absorber = beside.absorber
    mass = f"μ = {absorber.mass_ratio:.4g}"
    if asked.in_units:
        mass = quantity(asked, "particle_mass_kg", absorber.mass_ratio * asked.structure.mass_kg)
    stroke, detuned = length(asked, beside.stroke), length(asked, beside.detuned_stroke)
    return [
        ("mass", mass, "", ""),
        ("natural frequency", frequency(asked, absorber.tuning), "", ""),
        ("damping ratio", f"{absorber.damping_ratio:.4g}", "", ""),
        ("stroke of its mass", f"{stroke} ({detuned} if {100 * DETUNED:.0f} % out of tune)", "", ""),
    ]
