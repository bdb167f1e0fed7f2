"""The report of a design, a page of HTML to print and sign: the damper to build, its results, and the alternatives."""

import json
from collections.abc import Iterable
from html import escape

import damperlab
from damperlab.service.documents import plain
from damperlab.service.figures.design import draw_alternatives, draw_amplitudes, draw_front
from damperlab.service.html import drawing, page, said, table
from damperlab.studies.design.absorber import DETUNED
from damperlab.studies.design.alternatives import CALLED as ALONE
from damperlab.studies.design.answer import answer_document, cases_of, limits_of
from damperlab.studies.design.build import Build
from damperlab.studies.design.drawing import Line, drawing_of
from damperlab.studies.design.found import Found
from damperlab.studies.design.kept import KnownDesign, Round
from damperlab.studies.design.shelf import Shelf
from damperlab.studies.design.spelling import (
    frequency,
    length,
    limited,
    quantity,
    response,
    spelled_out,
    transients,
    under_records,
)
from damperlab.studies.design.starts import Reached
from damperlab.studies.design.verdict import CALLED as DAMPERS
from damperlab.studies.design.verdict import called_of, kind_of, verdict_of
from damperlab.studies.design.words import details_of
from damperlab.studies.specification.excitation import Case
from damperlab.studies.specification.measure import DAMPER_LIMITS, LIMITS
from damperlab.studies.specification.specification import JUDGES, Specification
from damperlab.studies.spelling import spelled

OF_THE_STRUCTURE = {
    "mass_kg": "mass of the structure",
    "natural_frequency_hz": "natural frequency",
    "damping_ratio": "damping ratio",
}


def keep_answer(shelf: Shelf, design_id: str, found: Found, rounds: int, started: str) -> str:
    """Store the answer and the report of a design, and return the report.

    Parameters
    ----------
    shelf : Shelf
        Store of designs.
    design_id : str
        Full id of the design.
    found : Found
        Result of the search.
    rounds : int
        Number of rounds of studies in the search.
    started : str
        Time at which the search started, in ISO 8601.
    """
    answer, report = plain(answer_document(found)), design_report(found)
    known = KnownDesign(design=answer["design"], worst=answer["worst"], feasible=answer["feasible"])
    shelf.follow(design_id, Round("the answer", rounds, found.book.spent, 0, (), known, started))
    shelf.finish(design_id, answer, report)
    return report


def design_report(found: Found) -> str:
    """Return the report of a design as a self-contained page of HTML with embedded SVG figures."""
    asked = found.asked
    title = asked.name or "design"
    brief, _ = verdict_of(found)
    damper, own = brief.damper, kind_of(found.build)
    assert damper is not None  # the verdict of a design always names a damper, which may be "no_damper"
    called = called_of(found, damper)
    parts = [
        f"<h1>{escape(title)}</h1>",
        *(said(sentence) for sentence in brief.sentences),
        "<h2>What was asked</h2>",
        table("What was asked", ("what", "value", "tolerance"), _asked(found)),
        *_drawing(f"The damper: {DAMPERS[damper]}", drawing_of(found, damper)),
    ]
    if damper != own:
        parts += _drawing(called.capitalize(), drawing_of(found, own))
        parts.append(
            said(f"The rest of this report describes the {called}, except where another damper is named.")
        )
    parts += [
        *_excitations(found),
        "<h2>Beside other dampers</h2>",
        table(
            "Dampers",
            ("damper", "clearance", "friction force", "particle", "e", "worst case"),
            _dampers(found, called),
        ),
    ]
    if asked.excitations:
        parts.append(
            drawing(
                draw_alternatives(found, called),
                "Response of each damper as drawn, under the largest amplitude, at every computed frequency of "
                "the band. The tuned mass damper has the mass of the particle.",
            )
        )
    parts += _starts(found)
    if found.shown:
        parts += [
            "<h2>Under other amplitudes</h2>",
            drawing(
                draw_amplitudes(found),
                "Response of the damper as drawn, under amplitudes within and beyond the specified range. "
                "Its friction force and clearance stay the same."
                + (
                    ""
                    if asked.measure.mean
                    else " Dots mark the peaks at the frequencies that were computed."
                ),
            ),
        ]
    parts += _masses(found)
    if asked.limited_at_all:
        parts += [
            "<h2>Limits</h2>",
            table("Limits", ("limit", "allowed", "reached", "kept", "binds"), _limits(found)),
        ]
    parts += [
        "<h2>Details</h2>",
        *(said(sentence) for sentence in details_of(found, damper)),
        "<h2>Signatures</h2>",
        '<div class="signature">',
        table("Signatures", ("drawn up", "checked", "date"), [("", "", "")]),
        "</div>",
        "<h2>Specification</h2>",
        f"<pre>{escape(json.dumps(asked.document, indent=2, ensure_ascii=False))}</pre>",
        said(f"damperlab {damperlab.__version__}; specification {asked.digest[:12]}.", "quiet"),
    ]
    return page(title, parts)


def _asked(found: Found) -> Iterable[tuple[str, str, str]]:
    """Yield the rows of the table of requirements: structure, excitations, judged quantity and assumptions."""
    asked = found.asked
    own = {"damping_ratio": f"{asked.structure.damping_ratio:.4g}"}
    if asked.in_units:
        own |= {
            "mass_kg": spelled(asked.structure.mass_kg, "kg"),
            "natural_frequency_hz": spelled(asked.structure.natural_frequency_hz, "Hz"),
        }
    for name, words in OF_THE_STRUCTURE.items():
        if name in own:
            tolerance = asked.tolerances.get(name)
            yield words, own[name], "" if tolerance is None else f"± {100 * tolerance.size:.3g} %"
    for each in asked.excitations:
        yield _named("excitation", each.name), spelled_out(asked, each), ""
    for records in asked.records:
        yield _named("excitation", records.name), under_records(records), ""
    largest = "" if asked.measure.mean else "largest "
    yield "judged by", f"{largest}{asked.measure.judged}", ""
    yield "assumed", "the cavity is horizontal; the particle slides without friction", ""
    if asked.judge != "rest":
        yield "of several responses", JUDGES[asked.judge], ""
    yield "confidence", f"{asked.confidence:.3g}", ""


def _named(what: str, name: str) -> str:
    return f"{what} {name}".strip()


def _masses(found: Found) -> Iterable[str]:
    asked = found.asked
    if len(found.front) < 2:
        return
    rows = [
        (
            quantity(asked, "particle_mass_kg", each.mass_kg),
            response(asked, each.score.value) + ("" if each.score.violation == 0.0 else ", exceeds a limit"),
            *(
                "" if other is None else response(asked, other)
                for other in (each.absorber, each.particle_alone)
            ),
            *_without_mass(found, each.build),
            f"{each.looked_at:,}",
        )
        for each in found.front
    ]
    columns = (
        "particle", "best as drawn", "tuned mass damper", "particle alone", "clearance", "friction force", "e", "looked at"
    )  # fmt: skip
    yield "<h2>Mass against response</h2>"
    yield table("Mass against response", columns, rows)
    yield drawing(
        draw_front(found),
        "Response of the best damper found for each mass, as drawn. The search for each mass started from the "
        "damper of the neighbouring mass. The tuned mass damper, too, is tuned for the nominal "
        "structure, without tolerances.",
    )


def _without_mass(found: Found, build: Build) -> tuple[str, str, str]:
    asked, particle = found.asked, build.particle_mass_kg > 0.0
    return (
        quantity(asked, "clearance_m", build.clearance_m) if particle else "",
        quantity(asked, "friction_force_n", build.friction_force_n),
        f"{build.restitution:.4g}" if particle else "",
    )


def _starts(found: Found) -> Iterable[str]:
    asked, starts = found.asked, found.starts
    if starts is None or not starts.where:
        return
    rows = [
        (
            frequency(asked, at.frequency_ratio) if each is at.responses[0] else "",
            length(asked, each.displacement),
            *(() if asked.measure.of_displacement else (_value(asked, each),)),
            f"{round(each.share * starts.count)} of {starts.count}",
            (each.response_class or "not known").replace("_", " "),
            "yes" if each.from_rest else "no",
        )
        for at in starts.where
        for each in at.responses
    ]
    judged = () if asked.measure.of_displacement else (asked.measure.words,)
    columns = ("near", "displacement of the structure", *judged, "starts", "class", "from rest")
    yield "<h2>More than one response</h2>"
    yield table("More than one response", columns, rows)
    yield said(
        "Responses of the damper as drawn, under the largest amplitude, at the frequencies where different starts "
        "lead to different responses. At most the three most frequent responses at each frequency are listed. The "
        "class is known for the most frequent response and for the response from rest.",
        "quiet",
    )


def _value(asked: Specification, reached: Reached) -> str:
    return "not known" if reached.value is None else response(asked, reached.value)


def _excitations(found: Found) -> Iterable[str]:
    asked = found.asked
    if asked.records:
        cases = (
            (each.source.called, f"{each.scale:g}", response(asked, value)) for each, value in cases_of(found)
        )
        kind = transients(asked)
        each = {"sweeps": "sweep", "shocks": "shock"}.get(kind, "record" if "record" in kind else kind)
        yield f"<h2>Under each {each}</h2>"
        yield table(kind.capitalize(), (each, "scale", "as drawn"), cases)
    if len(asked.excitations) + len(asked.records) < 2:
        return
    by_record = isinstance(found.stated.under, Case) or not asked.excitations
    rows = [
        (
            each.name,
            spelled_out(asked, each),
            response(asked, judged.value),
            "" if asked.measure.mean else frequency(asked, judged.frequency_ratio),
            "yes" if each == found.binding and not by_record else "no",
        )
        for each, judged in zip(asked.excitations, found.under, strict=True)
    ]
    for records, worst in zip(asked.records, found.under_records, strict=True):
        at = worst.under.name if isinstance(worst.under, Case) else ""
        binds = by_record and found.stated.under in records.cases
        told = response(asked, worst.value), at, "yes" if binds else "no"
        rows.append((records.name, under_records(records), *told))
    yield "<h2>Under each excitation</h2>"
    yield table("Excitations", ("excitation", "what it is", "worst case as drawn", "near", "binds"), rows)


def _drawing(title: str, lines: list[Line]) -> Iterable[str]:
    if lines:
        yield f"<h2>{title}</h2>"
        yield table(title, ("quantity", "value", "tolerance", "may change alone within"), lines)


def _dampers(found: Found, called: str) -> Iterable[tuple[str, ...]]:
    asked = found.asked
    exceeds = found.compared.violation > 0.0
    yield _damper(found, called, found.build, response(asked, found.largest) + _exceeding(exceeds))
    for name, other in found.others.items():
        value = response(asked, other.score.value) + _exceeding(other.score.violation > 0.0)
        yield _damper(found, ALONE[name], other.build, value)
    if found.absorber is not None:
        mass = quantity(asked, "particle_mass_kg", found.build.particle_mass_kg)
        value = response(asked, found.absorber.value) + _exceeding(bool(found.absorber.exceeded))
        yield "tuned mass damper", "", "", mass, "", value
        out = f"tuned mass damper, up to {100 * DETUNED:.0f} % out of tune"
        yield out, "", "", mass, "", response(asked, found.absorber.detuned)


def _exceeding(exceeds: bool) -> str:
    return ", exceeds a limit" if exceeds else ""


def _damper(found: Found, name: str, build: Build, value: str) -> tuple[str, ...]:
    asked, particle = found.asked, build.particle_mass_kg > 0.0
    return (
        name,
        quantity(asked, "clearance_m", build.clearance_m) if particle else "",
        quantity(asked, "friction_force_n", build.friction_force_n),
        quantity(asked, "particle_mass_kg", build.particle_mass_kg) if particle else "",
        f"{build.restitution:.4g}" if particle else "",
        value,
    )


def _limits(found: Found) -> Iterable[tuple[str, ...]]:
    asked, rows = found.asked, limits_of(found)
    for name, row in zip((*asked.limits, *asked.damper_limits), rows, strict=True):
        shown = [limited(asked, name, row[key]) for key in ("allowed", "reached")]
        about = LIMITS.get(name) or DAMPER_LIMITS[name]
        yield about.words, *shown, *("yes" if row[key] else "no" for key in ("kept", "binds"))
