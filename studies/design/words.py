"""The details of a design in sentences: the limits and the values reached, the margins, and the method."""

from collections.abc import Iterator, Mapping
from functools import partial
from math import isinf

from damperlab.studies.answers.particle_friction import WITHIN
from damperlab.studies.brief import Damper
from damperlab.studies.design.book import SEED
from damperlab.studies.design.drawing import drawing_of
from damperlab.studies.design.found import Found
from damperlab.studies.design.margins import Margin
from damperlab.studies.design.spelling import (
    CALLED,
    allowing,
    comes_to,
    damper_words,
    frequency,
    length,
    limited,
    quantity,
    response,
    rounded_up,
    spelled_out,
    under_records,
)
from damperlab.studies.design.starts import FROM
from damperlab.studies.design.verdict import CALLED as CALLED_DAMPERS
from damperlab.studies.design.verdict import called_of, kind_of
from damperlab.studies.faults import counted
from damperlab.studies.specification.excitation import Case
from damperlab.studies.specification.measure import DAMPER_LIMITS, LIMITS
from damperlab.studies.specification.specification import JUDGES, Specification
from damperlab.studies.spelling import spelled

ENDED: Mapping[str, str] = {
    "budget": "The search ended because its share of the budget of {points} was spent.",
    "converged": "The search ended because no neighbour of the best was better.",
    "lists": "Every combination of the listed values was examined.",
    "nothing": "The limits leave one damper.",
}
"""Reasons for the end of a search."""


def details_of(found: Found, damper: Damper) -> list[str]:
    """Write all findings as sentences. `damper` is the kind of damper that the verdict names."""
    return [
        *_recommended(found, damper),
        *_damper(found, called_of(found, damper)),
        *_worst(found),
        *_limits(found),
        *_damper_limits(found),
        *_builds(found),
        *_starts(found),
        *_margins(found),
        *_known(found),
    ]


def _recommended(found: Found, damper: Damper) -> Iterator[str]:
    """Write the drawing of the damper to build, if its kind differs from the kind of the damper found."""
    lines = drawing_of(found, damper)
    if damper != kind_of(found.build) and lines:
        yield f"Drawing: {CALLED_DAMPERS[damper]}, {', '.join(f'{name} {value}' for name, value, *_ in lines)}."


def _damper(found: Found, called: str) -> Iterator[str]:
    asked, build = found.asked, found.build
    parts = [damper_words(asked, build, 4)]
    if build.particle_mass_kg == 0.0:
        parts.append("no particle")
    elif asked.in_units:
        parts.append(f"{spelled(2 * build.clearance_m, 'm')} free cavity length")
    if build.contact_time_s:
        parts.append(f"in contact for {1e3 * build.contact_time_s:.4g} ms")
    begins = {"recommended": "Drawing", "as given": "Given"}.get(called, called.capitalize())
    yield f"{begins}: {', '.join(filter(None, parts))}."


def _worst(found: Found) -> Iterator[str]:
    asked, stated = found.asked, found.stated
    count = len(asked.excitations) + len(asked.records)
    if isinstance(stated.under, Case):
        records = asked.records_of(stated.under)
        shaken, name = under_records(records), records.name
        # the sentence already begins with the description of a single generated record at a single scale
        one = len(records.cases) == 1 and records.alone is not None
        near = "" if one else f", under {stated.under.name}"
    elif not asked.excitations:  # no record causes any motion
        shaken, name, near = under_records(asked.records[0]), asked.records[0].name, ""
    else:
        shaken, name = spelled_out(asked, found.binding), found.binding.name
        near = "" if asked.measure.mean else f", near {frequency(asked, stated.frequency_ratio)}"
    over = (
        f"Of {count} excitations `{name}` gives the worst case: {shaken}"
        if count > 1
        else shaken[:1].upper() + shaken[1:]
    )
    within = " and within the tolerances" if asked.tolerances else ""
    if isinf(stated.value):
        yield f"{over}{within}, nothing bounds the {asked.measure.judged}{near}."
    else:
        # a result under a record is as exact as the solver: there is no error to state
        most = f"{allowing(asked, stated.noise)} it is at most {response(asked, rounded_up(stated.most))}"
        rest = FROM[asked.judge] if asked.excitations and not asked.measure.mean else ""
        reaches = f"{comes_to(asked)} {response(asked, stated.value)}{rest}{near}"
        yield f"{over}{within}, the {asked.measure.judged} {reaches}{f'; {most}' if asked.excitations else ''}."
    if asked.tolerances:
        yield f"As drawn, without tolerances, it is {response(asked, found.nominal.value)}."
    yield from words_of_structure(asked)
    if count > 1:
        under = [
            *(
                (each.name, spelled_out(asked, each), of)
                for each, of in zip(asked.excitations, found.under, strict=True)
            ),
            *(
                (each.name, under_records(each), of)
                for each, of in zip(asked.records, found.under_records, strict=True)
            ),
        ]
        parts = [f"{response(asked, of.value)} under `{called}` ({words})" for called, words, of in under]
        yield f"As drawn it {comes_to(asked)} {'; '.join(parts)}."


def words_of_structure(asked: Specification) -> Iterator[str]:
    """State which given quantities stay the same if the mass deviates within its tolerance."""
    if "mass_kg" in asked.tolerances:
        damping = "dashpot" if asked.structure.dashpot_given else "damping ratio"
        spring = "stiffness" if asked.structure.stiffness_given else "natural frequency"
        yield f"The tolerance of the mass leaves {spring} and {damping} as given."


def _limits(found: Found) -> Iterator[str]:
    """Write a sentence for each limit on a result: the value reached, and the remedy if it is exceeded."""
    asked, stated = found.asked, found.stated
    for name, limit in asked.limits.items():
        about, reached, at_most = LIMITS[name], stated.reached[name], stated.at_most[name]
        what = f"{about.words}{' over the bands' if asked.cases and not about.under_record else ''}"
        allowed, most = _limited(asked, name, limit), _limited(asked, name, rounded_up(at_most))
        if isinf(reached):
            yield f"Nothing bounds the {what}; {allowed} is allowed."
            continue
        begins = f"The {what} reaches {_limited(asked, name, reached)} of the {allowed} allowed ({_share(reached / limit)})"
        begins += _where(found, name)
        if reached <= limit:
            doubt = f"; {allowing(asked, stated.noise)} it is at most {most}, so that it may exceed the limit"
            yield f"{begins}{doubt if at_most > limit else ''}."
            continue
        drawn = found.nominal.reached[name]
        if drawn <= limit:
            begins += f"; as drawn it reaches {_limited(asked, name, drawn)}"
        yield f"{begins}. Relax `limits.{asked.limit_key(name)}` to {most}, or {found.otherwise(name)}."


def _where(found: Found, name: str) -> str:
    """Name the frequency at which a limited result is largest, and the excitation if there are
    several.

    The text is empty for the limit on the measure.
    """
    asked, at = found.asked, found.stated.reached_at.get(name)
    if at is None or name == asked.measure.limit:
        return ""
    under, ratio = at
    if isinstance(under, Case):
        return f", under {under.name}"
    several = len(asked.excitations) + len(asked.records) > 1
    return f", near {frequency(asked, ratio)}{f' under `{under.excitation.name}`' if several else ''}"


def _damper_limits(found: Found) -> Iterator[str]:
    """Write a sentence for each limit on the damper itself."""
    asked, build = found.asked, found.build
    for name, limit in asked.damper_limits.items():
        about = DAMPER_LIMITS[name]
        if build.particle_mass_kg == 0.0 and about.quantity != "friction_force_n":
            continue
        reached = build.as_built(asked, about)
        the = "Built at the upper end of its tolerance, the" if about.quantity in asked.tolerances else "The"
        share = f" ({_share(reached / limit)})" if limit else ""
        yield f"{the} {about.words} is {_limited(asked, name, reached)} of the {_limited(asked, name, limit)} allowed{share}."


def _limited(asked: Specification, name: str, value: float) -> str:
    """Write a value that a limit restricts."""
    return limited(asked, name, asked.as_limited(name, value))


def _share(ratio: float) -> str:
    """Write a share of a limit in per cent; a share of 200 % or more is written as a multiple."""
    return f"{100 * ratio:.0f} %" if ratio < 2.0 else f"{ratio:.3g} times"


def _builds(found: Found) -> Iterator[str]:
    builds, asked = found.builds, found.asked
    if builds is None:
        return
    kept = ["keep every limit"] if asked.limited_at_all else []
    if builds.bound is not None:
        kept.append(
            f"stay within {response(asked, builds.bound)}, the largest value as drawn and at the corners "
            "of the tolerances"
        )
    fewer = f" (of {asked.builds} asked for)" if builds.drawn < asked.builds else ""
    yield (
        f"Of {counted(builds.drawn, 'build')}{fewer} drawn uniformly within the tolerances (seed {SEED}), {builds.passed} "
        f"{' and '.join(kept)}. A build does so with a probability of {builds.low:.3f} to {builds.high:.3f} "
        f"(confidence {asked.confidence:.3g})."
    )


def _starts(found: Found) -> Iterator[str]:
    """Describe the responses after starts from other states than rest."""
    asked, starts = found.asked, found.starts
    if starts is None:
        return
    near = f"near {frequency(asked, starts.frequency_ratio)}"
    at = "1 frequency ratio" if starts.frequencies == 1 else f"each of {starts.frequencies} frequency ratios"
    reached = "does not exceed the value stated"
    if starts.beyond is None:
        reached = f"reaches a displacement of the structure up to {length(asked, starts.worst)}, {near}"
    elif starts.beyond:
        reached = (
            f"reaches up to {response(asked, starts.worst)}, {near}. "
            f"At {starts.beyond} of these ratios it exceeds the value stated"
        )
    yield f"Started in {counted(starts.count, 'way')} at {at}, the damper as drawn {reached}."
    if starts.several:
        yield f"At {starts.several} of these ratios it has more than one response."


def _margins(found: Found) -> Iterator[str]:
    asked = found.asked
    # an unbounded response has no margins
    if not found.margins or isinf(found.stated.most):
        return
    holds = ["every limit holds"] if asked.limited_at_all else []
    if found.stated.violation > 0.0:
        holds = ["the largest excess over a limit does not grow"]
    if not asked.limits_measure:
        holds.append(f"the response stays within {response(asked, WITHIN * found.stated.most)}")
    parts = [_margin(asked, name, margin) for name, margin in found.margins.items()]
    yield f"With one quantity changed and the others as drawn, {' and '.join(holds)} for {'; for '.join(parts)}."


def _margin(asked: Specification, name: str, margin: Margin) -> str:
    fails = [quantity(asked, name, at) for at in (margin.fails_below, margin.fails_above) if at is not None]
    beyond = f" (not at {' or '.join(fails)})" if fails else ""
    return f"a {CALLED[name]} of {margin.span(partial(quantity, asked, name))}{beyond}"


def _known(found: Found) -> Iterator[str]:
    """State the number of computed points, the reason for the end of the search, and omitted steps."""
    points, dampers = counted(found.book.spent, "point"), counted(found.looked_at, "damper")
    ended = ENDED[found.ended].format(points=counted(found.book.budget, "point"))
    if found.asked.free:
        yield f"Computed: {points}, of {dampers}. {ended}"
    else:
        yield f"There was nothing to choose. Computed: {points}{', all of the budget' if found.stopped == 'budget' else ''}."
    if found.left_out:
        yield f"The budget did not allow: {'; '.join(found.left_out)}."
    better = found.ended in ("budget", "converged")
    yield (
        f"Where there are several responses, {JUDGES[found.asked.judge]} counts."
        f"{' A better damper elsewhere cannot be excluded.' if better else ''}"
    )
