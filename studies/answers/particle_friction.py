"""Find the largest friction of the particle at which the value of a ranked design rises by at most a tenth."""

from collections.abc import Collection, Iterable, Mapping, Sequence
from itertools import takewhile
from math import inf
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from damperlab.studies.amplitudes import AMPLITUDE, DAMPER, RATIOS_OF
from damperlab.studies.answers.design_question import FREQUENCY, DesignQuestion, axes_within
from damperlab.studies.answers.excited import definition_of
from damperlab.studies.answers.follow_up import Refinement, follow_up, named
from damperlab.studies.answers.largest_acceleration import ACCELERATION
from damperlab.studies.answers.leading import leading
from damperlab.studies.answers.notes import friction_allowed, share
from damperlab.studies.answers.optimal_designs import optimal_designs
from damperlab.studies.answers.query_fault import refused
from damperlab.studies.answers.suite import worst_cases
from damperlab.studies.brief import Note, NoteDocument, notes_document
from damperlab.studies.cavity import FRICTIONLESS, left_open
from damperlab.studies.choices import EventSolver
from damperlab.studies.definition import Study, parse_harmonic
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


def studies_with_friction(cube: "xr.Dataset", ranked: "xr.Dataset", judging: Judging) -> tuple[Study, ...]:
    """Return the studies that compute the damper recommended by a ranking, with friction of the particle.

    Parameters
    ----------
    cube : Dataset
        The ranked study.
    ranked : Dataset
        The answer of `optimal_designs`, `merged_designs` or `worst_case_designs`.
    judging : Judging
        The criteria of the ranking.

    Returns
    -------
    tuple of Study
        One study over `COEFFICIENTS` or, if the ranked study is over base amplitudes, one study for each
        coefficient. The tuple is empty in these cases: the recommended damper does not work by impacts; the
        ranked study is in ratios or incomplete; friction or gravity already acts on the particle; friction
        cannot be combined with the contact or the solver.
    """
    lead = leading(ranked)
    if lead is None or _obstacle(cube, ranked, lead) is not None:
        return ()
    study = parse_harmonic(definition_of(cube))
    if kind_of(cube.sizes) is AMPLITUDES:
        return _over_amplitudes(study, cube, lead, judging)
    made = study_with_friction(study, DesignQuestion.ask(cube, judging), lead)
    return () if made is None else (made,)


def find_friction(cube: "xr.Dataset", ranked: "xr.Dataset", judging: Judging) -> Refinement:
    """Return a `Refinement` that requests the studies of `studies_with_friction`.

    Parameters
    ----------
    cube, ranked, judging
        As in `studies_with_friction`.

    Returns
    -------
    Refinement
        The studies to compute; no studies if the ranking already has the result.

    Raises
    ------
    QueryFault
        If friction of the particle cannot be added to the recommended damper.
    """
    lead = leading(ranked)
    if (obstacle := _obstacle(cube, ranked, lead)) is not None:
        raise refused(*obstacle, obstacle.told)
    assert lead is not None  # without it there is an obstacle
    known = [each for each in ranked.attrs["notes"] if each["kind"] == FRICTION]
    notes = tuple(Note(each["kind"], each["severity"], each["values"]) for each in known)
    studies = () if known else studies_with_friction(cube, ranked, judging)
    found = {name: value for name, value in lead.items() if not isinstance(value, str)}
    return Refinement(studies, bool(known), found, points=sum(each.points for each in studies), notes=notes)


class _Obstacle(NamedTuple):
    """The reason why friction cannot be added to the particle of the recommended damper, as the parts of a fault."""

    field: str
    found: str
    allowed: str
    advice: str

    @property
    def told(self) -> str:
        """The reason as a sentence."""
        return f"Friction cannot be added to the particle of the best damper of {self.found}."


_IN_RATIOS = _Obstacle(
    "physical",
    "a study in ratios",
    "a study in units",
    "give it `mass_kg`, `natural_frequency_hz` and `base_amplitude_m`, from which μ_i follows",
)


def _obstacle(cube: "xr.Dataset", ranked: "xr.Dataset", lead: Mapping[str, Any] | None) -> _Obstacle | None:
    """Return the first reason why friction cannot be added to the recommended damper, or None if there is none."""
    if kind_of(cube.sizes) is SUITE:
        return _Obstacle(
            "study",
            "a ground-motion suite",
            "a study of harmonic excitation",
            f"write `{MADE_BY[PARTICLE_FRICTION]}` into the suite",
        )
    if (complete := ranked.attrs["complete"]) < 1:
        found = f"a study of which {share(complete)} of the designs are computed"
        return _Obstacle("study", found, "a complete study", "compute the rest first")
    if lead is None:
        found, advice = "a study without a design that qualifies", "relax the limits of the question"
        return _Obstacle("study", found, "a study with a best design", advice)
    definition = definition_of(cube)
    obstacle = _obstacle_of(parse_harmonic(definition)) if definition.get("physical") else _IN_RATIOS
    if obstacle is not None:
        return obstacle
    if not _strikes(lead):
        return _Obstacle(
            "study",
            "a study whose best damper has no impacts",
            "a best damper that works by impacts",
            "without impacts that friction has no effect; exclude the damper by a range of friction_ratio",
        )
    return None


def _obstacle_of(study: Study) -> _Obstacle | None:
    """Return the first reason in a study's definition why friction cannot be added, or None if there is none."""
    document = study.document()
    physical = document.get("physical") or {}
    over_amplitudes = kind_of(study.coordinates) is AMPLITUDES
    if not over_amplitudes and PARTICLE_FRICTION not in {each.source for each in quantities_of(document)}:
        return _IN_RATIOS
    given = [*(name for name in BEFORE if name in study.coordinates), *physical.keys() & MADE_BY.values()]
    if given:
        advice = f"vary `{MADE_BY[PARTICLE_FRICTION]}` in the study itself"
        return _Obstacle(given[0], f"a study with `{given[0]}`", "a lying, frictionless cavity", advice)
    if study.contact.model != "instant":
        found = f"a study with `contact.model` {study.contact.model}"
        return _Obstacle("contact.model", found, "instant", "compute it with instantaneous impacts")
    if not isinstance(study.solver, EventSolver):
        found = f"a study with `solver.method` {study.solver.method}"
        return _Obstacle("solver.method", found, "event", "compute it with `solver.method` event")
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
    if _obstacle_of(study) is not None:
        return None
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
        The studies from `studies_with_friction`.
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

    If the results with friction are not computed yet, name the command that computes them instead.

    Parameters
    ----------
    ranked, cube, judging
        As in `studies_with_friction`.
    cubes : iterable of Dataset
        Completed studies with friction.
    """
    asked = studies_with_friction(cube, ranked, judging)
    lead = leading(ranked)
    if not asked or lead is None:
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
