"""What of a recommended damper is at an end: of its range, or of what friction can do."""

from damperlab.studies.design.build import Build
from damperlab.studies.design.found import Found
from damperlab.studies.specification.specification import CHOSEN
from damperlab.studies.variables import ResponseClass


def at_ends(found: Found) -> dict[str, str]:
    """Give the chosen quantities that are at the end of their range, and which end."""
    ends: dict[str, str] = {}
    asked = found.asked
    for name in (each for each in CHOSEN if each in asked.free or each in asked.bounds):
        choice, value = asked.choices[name], getattr(found.build, name)
        if not (name == "friction_force_n" or found.build.particle_mass_kg > 0.0):
            continue
        if value in (choice.start, choice.stop) and not (choice.values and choice.start == choice.stop):
            # of a range that a limit left one value of, the upper end is the limit's
            ends[name] = "upper" if value == choice.stop else "lower"
    return ends


def locked(found: Found, build: Build | None = None) -> bool:
    """Whether friction holds the structure at its base at every frequency computed, as drawn and under the largest amplitude.

    Asked of the recommended damper, or of another build that is given.
    """
    build = build or found.build
    curves = (found.book.curve(build, case) for case in found.asked.cases)
    if not all(bool((curve["stick_fraction"] >= 1.0).all()) for curve in curves):
        return False
    if not found.asked.excitations:
        return True
    curve = found.book.curve(build, found.binding.largest)
    return bool((curve["response_class"] == ResponseClass.LOCKED).all())
