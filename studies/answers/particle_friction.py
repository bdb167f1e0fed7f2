"""Find the largest friction of the particle at which the value of a ranked design rises by at most a tenth."""

from collections.abc import Collection, Iterable, Mapping, Sequence
from itertools import takewhile
from math import inf
from typing import TYPE_CHECKING, Any

import numpy as np

from damperlab.studies.amplitudes import AMPLITUDE, DAMPER, RATIOS_OF
from damperlab.studies.answers.design_question import DesignQuestion, axes_within
from damperlab.studies.answers.excited import definition_of
from damperlab.studies.answers.follow_up import Refinement, follow_up, named
from damperlab.studies.answers.largest_acceleration import ACCELERATION
from damperlab.studies.answers.leading import leading
from damperlab.studies.answers.notes import friction_allowed, share
from damperlab.studies.answers.optimal_designs import optimal_designs
from damperlab.studies.answers.phrases import FREQUENCY
from damperlab.studies.answers.query_fault import QueryFault
from damperlab.studies.answers.suite import worst_cases
from damperlab.studies.brief import Note, NoteDocument, notes_document
from damperlab.studies.cavity import FRICTIONLESS, left_open
from damperlab.studies.choices import EventSolver
from damperlab.studies.definition import Study, parse_harmonic
from damperlab.studies.faults import Fault
from damperlab.studies.kinds import AMPLITUDES, SUITE, kind_of
from damperlab.studies.physical import DERIVATIONS
from damperlab.studies.questions import Judging, Ranking
from damperlab.studies.units import quantities_of
from damperlab.studies.variables import BEFORE, MADE_BY, PARTICLE_FRICTION

if TYPE_CHECKING:
    import xarray as xr

COEFFICIENTS = (0.01, 0.02, 0.05, 0.1, 0.2, 0.5)
"""Examined friction coefficients μ_i, from a rolling ball through PTFE to dry metals."""
FRICTION = "particle_friction"
"""Kind of the note that `friction_note` returns."""
WITHIN = 1.1
"""Largest allowed ratio of the value with friction to the value without friction."""


def find_friction(cube: "xr.Dataset", ranked: "xr.Dataset", judging: Judging) -> Refinement:
    """Request the study that computes the recommended damper with friction of the particle.

    Parameters
    ----------
    cube : Dataset
        The ranked study.
    ranked : Dataset
        The answer of `ranking.ranked_designs`.
    judging : Judging
        The criteria of the ranking.

    Returns
    -------
    Refinement
        The studies to compute: one study over `COEFFICIENTS` or, if the ranked study is over base amplitudes, one
        study for each coefficient. No studies if the ranking already has the result.

    Raises
    ------
    QueryFault
        If friction of the particle cannot be added to the recommended damper.
    """
    lead, studies = _asked(cube, ranked, judging)
    known = [each for each in ranked.attrs["notes"] if each["kind"] == FRICTION]
    notes = tuple(Note(each["kind"], each["severity"], each["values"]) for each in known)
    studies = () if known else studies
    found = {name: value for name, value in lead.items() if not isinstance(value, str)}
    return Refinement(studies, bool(known), found, points=sum(each.points for each in studies), notes=notes)


def _asked(
    cube: "xr.Dataset", ranked: "xr.Dataset", judging: Judging
) -> tuple[dict[str, Any], tuple[Study, ...]]:
    """Return the recommended damper, and its studies with friction of the particle; see `find_friction`."""
    if kind_of(cube.sizes) is SUITE:
        advice = f"write `{MADE_BY[PARTICLE_FRICTION]}` into the suite"
        raise QueryFault(_refusal("a ground-motion suite", "a study of harmonic excitation", advice))
    if (complete := ranked.attrs["complete"]) < 1:
        found = f"a study of which {share(complete)} of the designs are computed"
        raise QueryFault(_refusal(found, "a complete study", "compute the rest first"))
    lead = leading(ranked)
    if lead is None:
        found, advice = "a study without a design that qualifies", "relax the limits of the question"
        raise QueryFault(_refusal(found, "a study with a best design", advice))
    definition = definition_of(cube)
    if not definition.get("physical"):
        raise QueryFault(_IN_RATIOS)
    study = parse_harmonic(definition)
    if (fault := _why_not(study)) is not None:
        raise QueryFault(fault)
    if not _strikes(lead):
        found, allowed = "a study whose best damper has no impacts", "a best damper that works by impacts"
        advice = (
            "without impacts that friction has no effect; exclude the damper by a range of friction_ratio"
        )
        raise QueryFault(_refusal(found, allowed, advice))
    if kind_of(cube.sizes) is AMPLITUDES:
        return lead, _over_amplitudes(study, cube, lead, judging)
    return lead, (_over_coefficients(study, DesignQuestion.ask(cube, judging), lead),)


def _refusal(found: str, allowed: str, advice: str, field: str = "study") -> Fault:
    """Return the fault of a study if friction cannot be added to the particle of its best damper."""
    told = f"Friction cannot be added to the particle of the best damper of {found}."
    return Fault(field, found, allowed, advice, told)


_IN_RATIOS = _refusal(
    "a study in ratios",
    "a study in units",
    "give it `mass_kg`, `natural_frequency_hz` and `base_amplitude_m`, from which μ_i follows",
    "physical",
)


def _why_not(study: Study) -> Fault | None:
    """Return why friction cannot be added to the particle of any damper of a study, or None."""
    document = study.document()
    physical = document.get("physical") or {}
    over_amplitudes = kind_of(study.coordinates) is AMPLITUDES
    if not over_amplitudes and PARTICLE_FRICTION not in {each.source for each in quantities_of(document)}:
        return _IN_RATIOS
    given = [*(name for name in BEFORE if name in study.coordinates), *physical.keys() & MADE_BY.values()]
    if given:
        advice = f"vary `{MADE_BY[PARTICLE_FRICTION]}` in the study itself"
        return _refusal(f"a study with `{given[0]}`", "a lying, frictionless cavity", advice, given[0])
    if study.contact.model != "instant":
        found = f"a study with `contact.model` {study.contact.model}"
        return _refusal(found, "instant", "compute it with instantaneous impacts", "contact.model")
    if not isinstance(study.solver, EventSolver):
        found = f"a study with `solver.method` {study.solver.method}"
        return _refusal(found, "event", "compute it with `solver.method` event", "solver.method")
    return None


def _strikes(lead: Mapping[str, Any]) -> bool:
    """Whether the recommended damper works by impacts.

    In a study over base amplitudes, every particle with mass is assumed to strike.
    """
    if "impact_share" in lead:
        return bool(lead["impact_share"] != 0.0)  # NaN if unknown
    return bool(lead["mass_ratio"] > 0.0)


def study_with_friction(study: Study, question: DesignQuestion, design: Mapping[str, float]) -> Study | None:
    """Make the study that computes one design with friction of its particle.

    Parameters
    ----------
    study : Study
        The study of the design.
    question : DesignQuestion
        The criteria by which designs are judged, with the judged frequencies.
    design : mapping of float
        The design, by dimension. Its particle strikes.

    Returns
    -------
    Study or None
        A study over `COEFFICIENTS` and the judged frequencies. None in these cases: the study is in ratios;
        friction or gravity already acts on the particle; friction cannot be combined with the contact or the
        solver.
    """
    if _why_not(study) is not None:
        return None
    return _over_coefficients(study, question, design)


def _over_coefficients(study: Study, question: DesignQuestion, design: Mapping[str, float]) -> Study:
    in_units = {each.source: each.factor for each in quantities_of(study.document())}
    axes: dict[str, object] = {name: design[name] for name in question.design}
    axes |= {
        FREQUENCY: question.frequencies.tolist(),
        PARTICLE_FRICTION: [each / in_units[PARTICLE_FRICTION] for each in COEFFICIENTS],
    }
    return follow_up(study, axes, "with friction")


def _over_amplitudes(
    study: Study, cube: "xr.Dataset", damper: Mapping[str, Any], judging: Judging
) -> tuple[Study, ...]:
    """Make the studies of one damper over the judged base amplitudes and frequencies, one study per coefficient."""
    document = study.document()
    met = axes_within(cube, judging.ranges)
    physical = {name: value for name, value in document["physical"].items() if name not in _MADE}
    physical |= {name: damper[name] for name in RATIOS_OF}
    physical[AMPLITUDE] = cube[AMPLITUDE].values[met[AMPLITUDE]].tolist()
    axes: dict[str, object] = {name: damper[name] for name in DAMPER if name not in RATIOS_OF}
    axes[FREQUENCY] = cube[FREQUENCY].values[met[FREQUENCY]].tolist()
    document |= {"damping_ratio": cube["damping_ratio"].values[met["damping_ratio"]].tolist(), "axes": axes}
    coefficient = MADE_BY[PARTICLE_FRICTION]
    return tuple(
        parse_harmonic(
            document | {"name": named(study, f"μ_i = {each:g}"), "physical": physical | {coefficient: each}}
        )
        for each in COEFFICIENTS
    )


_MADE = tuple(DERIVATIONS[name].source for name in ("damping_ratio", "mass_ratio", FREQUENCY))
"""Physical quantities that a follow-up does not contain, because it contains the corresponding ratios."""


def friction_note(
    asked: Sequence[Study],
    cubes: "Iterable[xr.Dataset]",
    judging: Judging,
    value: float,
    metric: str | None = None,
) -> Note | None:
    """Return a note with the largest examined μ_i that a damper tolerates.

    Up to this μ_i, the value of the damper is at most `WITHIN` times `value`. The note also contains the next
    larger coefficient.

    Parameters
    ----------
    asked : sequence of Study
        The studies from `find_friction`.
    cubes : iterable of Dataset
        Cubes of completed studies, which may include those of `asked`.
    judging : Judging
        The criteria of the ranking.
    value : float
        The value of the damper in the ranking.
    metric : str, optional
        The criterion, for a study over base amplitudes.

    Returns
    -------
    Note or None
        None if a study of `asked` is not among the cubes.
    """
    cubes = list(cubes)
    found: dict[float, float] = {}
    for study in asked:
        cube = next((cube for cube in cubes if _is_of(cube, study)), None)
        if cube is None:
            return None
        found |= _values(cube, judging, metric)
    held = len(list(takewhile(lambda each: found.get(each, inf) <= WITHIN * value, COEFFICIENTS)))
    fails = COEFFICIENTS[held] if held < len(COEFFICIENTS) else None
    return Note(FRICTION, "hint", {"up_to": (0.0, *COEFFICIENTS)[held], "fails": fails})


def has_friction_added(cube: "xr.Dataset", ranked: "xr.Dataset") -> bool:
    """Whether the study of `cube` defines the friction of the particle, and the study of `ranked` leaves it open."""
    open_there, open_here = (FRICTIONLESS in left_open(definition_of(each)) for each in (ranked, cube))
    return open_there and not open_here


def with_friction(
    ranked: "xr.Dataset", cube: "xr.Dataset", judging: Judging, cubes: "Iterable[xr.Dataset]"
) -> "xr.Dataset":
    """Add the note of `friction_note` to a ranking.

    If the results with friction are not computed yet, the text names the command that computes them.

    Parameters
    ----------
    ranked, cube, judging
        As in `find_friction`.
    cubes : iterable of Dataset
        Completed studies with friction.
    """
    try:
        lead, asked = _asked(cube, ranked, judging)
    except QueryFault:  # friction cannot be added, so there is nothing to say about it
        return ranked
    note = friction_note(asked, cubes, judging, lead["value"], ranked.attrs.get("metric"))
    said = (
        "`optimum --friction` finds the largest μ_i at which the damper keeps its value"
        if note is None
        else " ".join(friction_allowed(note))
    )
    notes = [] if note is None else notes_document([note])
    ranked.attrs |= _told(ranked.attrs, said, notes)
    if "in_units" in ranked.attrs:
        ranked.attrs["in_units"] |= _told(ranked.attrs["in_units"], said, notes)
    return ranked


def _told(words: Mapping[str, Any], said: str, notes: list[NoteDocument]) -> dict[str, Any]:
    """Return the brief and the notes of an answer, both with additions.

    `said` is appended to the row of the acceleration in the brief. `notes` are appended to the notes, if the answer
    has any.
    """
    brief = words["brief"]
    rows = [[*row[:2], f"{row[2]}; {said}"] if row[0] == ACCELERATION else row for row in brief["rows"]]
    told: dict[str, Any] = {"brief": brief | {"rows": rows}}
    return told | ({"notes": [*words["notes"], *notes]} if "notes" in words else {})


def _is_of(cube: "xr.Dataset", study: Study) -> bool:
    """Whether a cube holds the points of a study."""
    axes = study.coordinates
    same = kind_of(cube.sizes) is kind_of(axes) and all(
        name in cube.sizes and np.array_equal(cube[name], axis) for name, axis in axes.items()
    )
    return same and _coefficient(definition_of(cube)) == _coefficient(study.document())


def _coefficient(definition: Mapping[str, Any]) -> float | None:
    coefficient: float | None = (definition.get("physical") or {}).get(MADE_BY[PARTICLE_FRICTION])
    return coefficient


def _values(cube: "xr.Dataset", judging: Judging, metric: str | None) -> dict[float, float]:
    """Return the value of the damper for each friction coefficient.

    Coefficients with which the damper does not qualify are left out.
    """
    if kind_of(cube.sizes) is AMPLITUDES:
        ranked = worst_cases(cube, ranking=Ranking(top=1, metric=metric))
        coefficients: Collection[float] = [float(_coefficient(definition_of(cube)) or 0.0)] * ranked.sizes[
            "rank"
        ]
    else:
        ranked = optimal_designs(cube, judging, len(COEFFICIENTS))
        places = [
            cube[PARTICLE_FRICTION].values.tolist().index(each) for each in ranked[PARTICLE_FRICTION].values
        ]
        coefficients = [COEFFICIENTS[place] for place in places]
    return dict(zip(coefficients, ranked["value"].values.tolist(), strict=True))
