"""The details of a design, in sentences: its drawing values, what it reaches where, how far it holds, how it is known."""

from collections.abc import Iterator
from math import isinf

from damperlab.studies.design.book import SEED
from damperlab.studies.design.build import Build
from damperlab.studies.design.elsewhere import words_of_amplitudes, words_of_starts
from damperlab.studies.design.ends import at_ends, locked
from damperlab.studies.design.found import Found
from damperlab.studies.design.limit_words import limits_in_words
from damperlab.studies.design.margins import WITHIN, Margin
from damperlab.studies.design.spelling import (
    CALLED,
    allowing,
    comes_to,
    frequency,
    quantity,
    response,
    rounded_up,
    spelled_out,
    under_records,
)
from damperlab.studies.design.starts import FROM
from damperlab.studies.faults import counted
from damperlab.studies.specification.records import Case
from damperlab.studies.specification.specification import JUDGES, Specification
from damperlab.studies.spelling import spelled


def details_of(found: Found) -> list[str]:
    """Put all that was found into sentences."""
    return [
        *_damper(found),
        *_worst(found),
        *limits_in_words(found),
        *_builds(found),
        *words_of_starts(found),
        *words_of_amplitudes(found),
        *_ends(found),
        *_margins(found),
        *_known(found),
    ]


def _damper(found: Found) -> Iterator[str]:
    asked, build = found.asked, found.build
    friction = f"a friction force of {quantity(asked, 'friction_force_n', build.friction_force_n)}"
    if not asked.in_units:
        friction = f"friction {quantity(asked, 'friction_force_n', build.friction_force_n)}"
    drawn = "Drawing" if asked.free else "Given"
    if build.particle_mass_kg == 0.0:
        yield f"{drawn}: {friction}, and no particle."
        return
    clearance = quantity(asked, "clearance_m", build.clearance_m)
    cavity = f" (a free cavity length of {spelled(2 * build.clearance_m, 'm')})" if asked.in_units else ""
    mass = quantity(asked, "particle_mass_kg", build.particle_mass_kg)
    touching = f"in contact for {1e3 * build.contact_time_s:.4g} ms" if build.contact_time_s else ""
    material = ", ".join(filter(None, (material_of(asked, build), touching)))
    rebound = f"a coefficient of restitution of {build.restitution:.4g}"
    yield (
        f"{drawn}: a clearance of {clearance} on either side{cavity}, {friction}, a particle of {mass} and "
        f"{rebound}{f' ({material})' if material else ''}."
    )


def material_of(asked: Specification, build: Build) -> str:
    """Name the material of a design, where the specification names materials."""
    return asked.choices["restitution"].called(build.restitution, build.contact_time_s)


def _worst(found: Found) -> Iterator[str]:
    asked, stated = found.asked, found.stated
    if isinstance(stated.under, Case):
        records = asked.records_of(stated.under)
        shaken, name = under_records(records), records.name
        # one that is generated, at its one scale, is what the sentence begins with
        one = len(records.cases) == 1 and records.alone is not None
        near = "" if one else f", under {stated.under.name}"
    elif not asked.excitations:  # no record lets anything move
        shaken, name, near = under_records(asked.records[0]), asked.records[0].name, ""
    else:
        shaken, name = spelled_out(asked, found.binding), found.binding.name
        near = "" if asked.measure.mean else f", near {frequency(asked, stated.frequency_ratio)}"
    # what is known of a record is as exact as the solver: there is no error to state
    most = f"{allowing(asked, stated.noise)} it is at most {response(asked, rounded_up(stated.most))}"
    other = ""
    if asked.excitations and found.starts is not None and found.starts.beyond:
        other = f"{FROM[asked.judge]}, and from other starts it reaches {response(asked, found.starts.worst)}"
    error = f"; {most}{other}" if asked.excitations else ""
    rest = FROM[asked.judge] if asked.excitations else ""
    over = f"{shaken[:1].upper()}{shaken[1:]}"
    count = len(asked.excitations) + len(asked.records)
    if count > 1:
        over = f"Of {count} excitations `{name}` binds: {shaken}"
    within = " and within the tolerances" if asked.tolerances else ""
    if isinf(stated.value):
        yield f"{over}{within}, nothing bounds the {asked.measure.judged}{near}."
    elif asked.measure.mean:
        several = count > 1 or asked.tolerances or found.binding.highest_m > found.binding.lowest_m
        yield (
            f"{over}{within}, the {asked.measure.judged} (the root of the mean over its frequencies of the square) comes to "
            f"{response(asked, stated.value)}{' at its worst' if several else ''}, as far as was computed{error}."
        )
    else:
        yield (
            f"{over}{within}, the largest {asked.measure.judged} that was computed{rest} is "
            f"{response(asked, stated.value)}{near}{error}."
        )
    if asked.tolerances:
        yield f"As drawn, without tolerances, it is {response(asked, found.nominal.value)}."
    yield from words_of_structure(asked)
    if count > 1:
        parts = [
            f"{response(asked, judged.value)} under `{each.name}` ({spelled_out(asked, each)})"
            for each, judged in zip(asked.excitations, found.under, strict=True)
        ]
        parts += [
            f"{response(asked, judged.value)} under `{each.name}` ({under_records(each)})"
            for each, judged in zip(asked.records, found.under_records, strict=True)
        ]
        yield f"As drawn it {comes_to(asked)} {'; '.join(parts)}."


def words_of_structure(asked: Specification) -> Iterator[str]:
    """Say what a tolerance of the mass leaves as it was given."""
    if "mass_kg" not in asked.tolerances:
        return
    structure = asked.structure
    damping = "dashpot" if structure.dashpot_given else "damping ratio"
    if structure.stiffness_given:
        yield f"The tolerance of the mass leaves stiffness and {damping} as given: the natural frequency changes."
        return
    yield (
        f"The tolerance of the mass leaves natural frequency and {damping} as given: the stiffness changes. For a mass on "
        "given springs give `stiffness_n_per_m`."
    )


def _builds(found: Found) -> Iterator[str]:
    builds, asked = found.builds, found.asked
    if builds is None:
        return
    kept = "keep every limit" if asked.limited_at_all else ""
    if builds.bound is not None:
        bound = response(asked, builds.bound)
        kept += f"{' and ' if kept else ''}stay within {bound}, the worst of the drawn damper and of the corners of its "
        kept += "tolerances"
    yield (
        f"Of {counted(builds.drawn, 'build')} drawn evenly within the tolerances (seed {SEED}), {builds.passed} {kept}: the "
        f"probability is between {builds.low:.3f} and {builds.high:.3f} with a confidence of {asked.confidence:.3g}."
    )
    if builds.drawn < asked.builds:
        yield f"The budget allowed no more than these of the {asked.builds} builds asked for."


def _ends(found: Found) -> Iterator[str]:
    asked = found.asked
    held = locked(found)
    for name, end in at_ends(found).items():
        if held and name == "friction_force_n":
            continue  # more of it changes nothing
        limit = asked.bounds.get(name) if end == "upper" else None
        if limit:
            yield f"The {CALLED[name]} is as large as `{limit}` allows: a larger one may do better."
        elif asked.choices[name].values:
            yield f"The {CALLED[name]} is the {'least' if end == 'lower' else 'largest'} of its list."
        elif getattr(found.build, name) > 0.0:
            yield f"The {CALLED[name]} is at the {end} end of its range; beyond it there may be a better damper."


def _margins(found: Found) -> Iterator[str]:
    asked = found.asked
    if not found.margins or isinf(found.stated.most):  # what has no bound cannot be exceeded
        return
    kept = "every limit holds" if asked.limited_at_all else ""
    if found.stated.violation > 0.0:
        kept = "no limit is exceeded by more than stated above"
    bound = (
        ""
        if asked.limits_measure
        else f"the response stays within {response(asked, WITHIN * found.stated.most)}"
    )
    parts = [_margin(asked, name, margin) for name, margin in found.margins.items()]
    holds = " and ".join(part for part in (kept, bound) if part)
    yield f"With one quantity changed and the others as drawn, {holds} for {'; for '.join(parts)}."
    together = found.together
    if together is None:
        return
    beyond = "" if together.fails is None else f"{100 * together.fails:.0f} %"
    if together.share == 0.0:
        yield f"That does not hold any more where all of them are {beyond} off at once, in one combination or more."
        return
    yield (
        f"The same holds where all of them are {100 * together.share:.0f} % off at once, in every combination"
        f"{f' (not {beyond})' if beyond else ''}."
    )


def _margin(asked: Specification, name: str, margin: Margin) -> str:
    low, high = (quantity(asked, name, value) for value in (margin.low, margin.high))
    fails = [
        f"{quantity(asked, name, value)}"
        for value in (margin.fails_below, margin.fails_above)
        if value is not None
    ]
    beyond = f" (not at {' or '.join(fails)})" if fails else ""
    return f"a {CALLED[name]} from {low} to {high}{beyond}"


def _known(found: Found) -> Iterator[str]:
    """Say what was computed, what ended it, and what it left out."""
    spent, budget = found.book.spent, found.book.budget
    computed = f"{counted(spent, 'point')} {'was' if spent == 1 else 'were'} computed"
    dampers = counted(found.looked_at, "damper")
    told = {
        "budget": f"{computed}: the budget of {budget:,} ended the search after {dampers}.",
        "converged": f"{computed}. The search looked at {dampers} and ended where none beside the best was better.",
        "lists": f"{computed}. The search looked at every combination of the values listed.",
        "nothing": f"{computed}. There was nothing to search: the limits leave one damper.",
    }[found.ended]
    if not found.asked.free:
        ended = f", where the budget of {budget:,} ended it" if found.stopped == "budget" else ""
        told = f"Nothing was to be chosen: this is an assessment of the damper that was given. {computed}{ended}."
    yield told
    if found.left_out:
        yield f"The budget did not allow: {'; '.join(found.left_out)}."
    better = (
        " A better damper elsewhere in the ranges cannot be excluded."
        if found.ended in ("budget", "converged")
        else ""
    )
    counts = f"Where there are several responses, {JUDGES[found.asked.judge]} counts."
    yield f"{'Every response is the one reached from rest.' if found.asked.judge == 'rest' else counts}{better}"
