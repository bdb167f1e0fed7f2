"""The limits of a design in words: how much of each is reached, and what is to be done about one that is not kept."""

from collections.abc import Iterator
from math import isinf

from damperlab.studies.design.found import Found
from damperlab.studies.design.spelling import allowing, frequency, limited, rounded_up
from damperlab.studies.specification.measure import DAMPER_LIMITS, LIMITS
from damperlab.studies.specification.records import Case
from damperlab.studies.specification.specification import Specification

IMPACTS = frozenset(("impact_speed_max", "impacts_per_cycle"))
"""Results that are 0 where the particle hits no wall."""


def limits_in_words(found: Found) -> Iterator[str]:
    """Put each limit into a sentence: what of it is reached, and what to do about one that is exceeded."""
    asked, stated = found.asked, found.stated
    none_keeps = False
    for name, limit in asked.limits.items():
        about, reached, at_most = LIMITS[name], stated.reached[name], stated.at_most[name]
        what = about.words
        if asked.cases and not about.under_record:
            what += " over the bands"
        where = _where(found, name)
        allowed = _limited(asked, name, limit)
        if reached <= limit:
            yield (
                f"The {what} reaches {_limited(asked, name, reached)} of the {allowed} allowed "
                f"({100 * reached / limit:.0f} %){where}{_doubt(asked, name, limit, at_most, stated.noise)}."
            )
            if (
                asked.judge == "rest"
                and reached == 0.0
                and IMPACTS & {*about.over_band}
                and found.starts is not None
                and found.starts.several
            ):
                yield "That is from rest, where the particle hits no wall; other starts lead to other responses, given below."
            continue
        drawn = found.nominal.reached[name]
        if drawn <= limit:
            where += f"; as drawn it reaches {_limited(asked, name, drawn)}, and tolerances take it beyond"
        best = ""
        if drawn > limit and not none_keeps and asked.free:
            none_keeps = True
            judged = " with its tolerances" if asked.tolerances else ""
            best = f"No damper that was looked at{judged} keeps every limit: of them this one exceeds its limits least. "
        if isinf(reached):
            yield f"{best}Nothing bounds the {what}, of which {allowed} are allowed."
            continue
        enough = limited(asked, name, rounded_up(asked.as_limited(name, at_most)))
        if stated.noise and at_most > reached:
            enough += f", which it keeps with a confidence of {asked.confidence:.3g}"
        wider = "widen what may be chosen" if asked.free else "let something be chosen"
        yield (
            f"{best}The {what} reaches {_limited(asked, name, reached)}, "
            f"{_excess(reached / limit)} the {allowed} allowed{where}. Relax `limits.{asked.limit_key(name)}` to "
            f"{enough}, or {wider if drawn > limit else 'narrow the tolerances'}."
        )
    yield from _damper_limits(found)


def _where(found: Found, name: str) -> str:
    """Say at which frequency a limited result is reached, and under which of several excitations; not of the measure itself."""
    asked, at = found.asked, found.stated.reached_at.get(name)
    if at is None or name == asked.measure.limit:
        return ""
    under, ratio = at
    if isinstance(under, Case):
        return f", under {under.name}"
    several = len(asked.excitations) + len(asked.records) > 1
    return f", near {frequency(asked, ratio)}{f' under `{under.excitation.name}`' if several else ''}"


def _damper_limits(found: Found) -> Iterator[str]:
    asked, build = found.asked, found.build
    for name, limit in asked.damper_limits.items():
        about = DAMPER_LIMITS[name]
        if build.particle_mass_kg == 0.0 and about.quantity != "friction_force_n":
            continue
        reached = build.as_built(asked, about)
        toleranced = about.quantity in asked.tolerances
        yield (
            f"{'Built at the upper end of its tolerance, the' if toleranced else 'The'} {about.words} is "
            f"{_limited(asked, name, reached)} of the {_limited(asked, name, limit)} allowed ({100 * reached / limit:.0f} %)."
            if limit
            else f"The {about.words} is {_limited(asked, name, reached)}, as its limit says."
        )


def _doubt(asked: Specification, name: str, limit: float, at_most: float, noise: float) -> str:
    """Say what a limited result may come to where that is beyond its limit."""
    if at_most <= limit:
        return ""
    most = limited(asked, name, rounded_up(asked.as_limited(name, at_most)))
    return f"; {allowing(asked, noise)} it is at most {most}, so that it may exceed the limit"


def _limited(asked: Specification, name: str, value: float) -> str:
    """Write a value of what a limit is about."""
    return limited(asked, name, asked.as_limited(name, value))


def _excess(ratio: float) -> str:
    """Say how far beyond its limit something is; a share of thousands of per cent is read as a multiple."""
    return f"{100 * (ratio - 1):.3g} % above" if ratio < 2.0 else f"{ratio:.3g} times"
