"""What else was designed for the same specification, in words: a part of the damper alone, and a tuned mass damper."""

from collections.abc import Iterator
from math import isfinite, isinf

from damperlab.studies.design.absorber import DETUNED, Beside
from damperlab.studies.design.alternatives import CALLED as ALTERNATIVES
from damperlab.studies.design.alternatives import OF_DAMPER, Alternative, without
from damperlab.studies.design.found import Found
from damperlab.studies.design.score import Score
from damperlab.studies.design.spelling import allowing, comes_to, length, response, rounded_up, transients
from damperlab.studies.specification.specification import OF_STRUCTURE, Specification

SAME = 0.02
"""Share within which two worst cases are called equal."""


def words_of_better(found: Found) -> Iterator[str]:
    """Say at once what does as well or better; what each of them reaches is said further below."""
    asked, ours = found.asked, found.compared
    if found.build.particle_mass_kg > 0.0:
        as_good = [
            ALTERNATIVES[name] for name, other in found.others.items() if _is_as_good(other.score, ours)
        ]
        if as_good:
            alone = " and ".join(as_good)
            yield f"{_capital(alone)} {'is' if len(as_good) == 1 else 'are'} as good here, as is said below."
    if found.absorber is not None and _does_better(found.absorber, ours):
        yield (
            "This damper does not beat a tuned mass damper of the same mass, which "
            f"{comes_to(asked)} {response(asked, found.absorber.value)}{_times(found.absorber.value, ours.value)}."
        )


def _is_as_good(theirs: Score, ours: Score) -> bool:
    limit = 1.0 + SAME
    keeps = theirs.violation <= ours.violation and theirs.most <= ours.most * limit
    return keeps and theirs.value <= ours.value * limit


def _does_better(beside: Beside, ours: Score) -> bool:
    return beside.value < ours.value / (1.0 + SAME) and (ours.violation > 0.0 or not beside.exceeded)


def words_of_others(found: Found) -> Iterator[str]:
    """Say what each of them reaches beside this damper."""
    asked, ours = found.asked, found.compared
    shaker = "band" if asked.excitations else transients(asked)
    judged = "with the corners of the same tolerances" if asked.tolerances else f"under the same {shaker}"
    for name, other in found.others.items():
        yield from _alternative(found, name, other, judged)
    if found.absorber is not None:
        yield from _absorber(asked, found.absorber, ours)


def _alternative(found: Found, name: str, other: Alternative, judged: str) -> Iterator[str]:
    asked, ours, theirs = found.asked, found.compared, other.score
    called = ALTERNATIVES[name]
    if isinf(theirs.value):
        yield f"With {called}, {judged}, nothing bounds the response."
        return
    best = f"The best of {called}" if without(asked, OF_DAMPER[name]).free else _capital(called)
    error = ""
    if theirs.error > SAME * theirs.value:
        most = response(asked, rounded_up(theirs.most))
        error = f" ({allowing(asked)} at most {most})"
    keeps = "" if theirs.violation == 0.0 else ", and exceeds a limit"
    value = f"{response(asked, theirs.value)}{error}{_times(theirs.value, ours.value)}"
    yield f"{best}, {judged}, {comes_to(asked)} {value}{keeps}."
    if _is_as_good(theirs, ours) and found.build.particle_mass_kg > 0.0:
        yield f"So {called} is as good here: the hybrid damper brings nothing that it does not."


def _capital(words: str) -> str:
    return f"{words[:1].upper()}{words[1:]}"


def _absorber(asked: Specification, beside: Beside, ours: Score) -> Iterator[str]:
    absorber = beside.absorber
    off = (
        " on a structure that is off by its tolerances" if set(OF_STRUCTURE) & asked.tolerances.keys() else ""
    )
    bands = len(asked.excitations)
    for_what = "a harmonic base" if not beside.for_bands else "this band" if bands == 1 else "these bands"
    exceeds = ""
    if beside.exceeded:
        exceeds = (
            f", and exceeds {'a limit' if len(beside.exceeded) == 1 else f'{len(beside.exceeded)} limits'}"
        )
    yield (
        f"A tuned mass damper of the same mass, tuned for {for_what}, to {absorber.tuning:.4g} of the natural "
        f"frequency with ζ = {absorber.damping_ratio:.4g} of its own, {comes_to(asked)} {response(asked, beside.value)}{off}"
        f"{_times(beside.value, ours.value)}{exceeds}."
    )
    out = f"Out of tune by up to {100 * DETUNED:.0f} %, either way, it {comes_to(asked)}"
    yield f"{out} {response(asked, beside.detuned)}{_times(beside.detuned, ours.value)}."
    if isfinite(beside.detuned_stroke):
        yield (
            f"Its mass moves against the structure by up to {length(asked, beside.stroke)} to either side{off}, and by up to "
            f"{length(asked, beside.detuned_stroke)} out of tune."
        )
    if ours.violation > 0.0 and not beside.exceeded:
        yield "It keeps every limit on results, which this damper does not."
    if _does_better(beside, ours):
        closely = "" if beside.detuned < ours.value else ", but only where it is tuned more closely than that"
        yield f"So a tuned mass damper of the same mass does better here{closely}."


def _times(other: float, ours: float) -> str:
    if isinf(ours):
        return ""
    if ours == 0.0:
        return ", as much" if other == 0.0 else ""
    ratio = other / ours
    return f", {ratio:.3g} times as much" if abs(ratio - 1.0) > SAME else ", as much"
