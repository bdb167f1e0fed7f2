"""The question for the best designs of a study, optionally ranked together with the designs of follow-ups."""

from collections.abc import Iterable
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any, NotRequired

from typing_extensions import TypedDict

from damperlab.service.questions.forms import RANKING
from damperlab.service.questions.question import Further, Question, Subject, Words
from damperlab.studies.brief import MOST_ROWS, DoubtKind, InShort, Notes
from damperlab.studies.kinds import AMPLITUDES, EVERY_DIMENSION, kind_of
from damperlab.studies.questions import Judging, Ranking
from damperlab.studies.shapes import Count, OfCube, Range, Says, Sentences
from damperlab.studies.vocabulary import RESPECTS, Objective

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

    from damperlab.service.client import answers
    from damperlab.studies.answers.phrases import Phrases
    from damperlab.studies.definition import Study

SAID: tuple[DoubtKind, ...] = ("one_frequency", "cut_off", "end_of_range", "rugged")
"""Kinds of doubt that the short answer states completely, so that the details do not repeat them."""
_NUMBER = {"type": ["number", "null"]}
_TEXT = {"type": "string"}
Design = Annotated[
    dict[str, Any],
    Says(
        required=["rank", "value"],
        properties={
            "rank": {"type": "integer", "minimum": 1},
            "value": _NUMBER,
            "error": _NUMBER,
            "response_class": _TEXT,
            **{name: _TEXT if name == "record" else _NUMBER for name in EVERY_DIMENSION},
        },
    ),
]
"""A design, whose dimensions depend on the kind of study."""


class Doubt(TypedDict):
    """A reason why the best value may not be valid."""

    kind: DoubtKind
    sentence: str


class RankedDesigns(OfCube):
    """Designs, the best first."""

    units: str
    long_name: str
    designs: list[Design]
    designs_total: Count
    clamped: NotRequired[bool]
    points: NotRequired[Count]
    points_failed: NotRequired[Count]
    at: NotRequired[dict[str, float | str | None]]
    meanings: NotRequired[dict[str, dict[str, str]]]
    objective: NotRequired[Objective]
    band: NotRequired[Range]
    frequencies: NotRequired[Count]
    verdict: NotRequired[Sentences]
    doubts: NotRequired[list[Doubt]]
    brief: NotRequired[InShort]
    notes: NotRequired[Notes]
    pareto: NotRequired[list[Annotated[str, Says(enum=list(RESPECTS))]]]


def answer(study: Subject, judging: Judging, ranking: Ranking) -> "xr.Dataset":
    """Rank the designs of a study over its frequencies; `<dimension>=lower,higher` narrows the choice.

    Dampers of a ground-motion suite are ranked by their worst case over its records, scales and structures. Dampers
    of a study over base amplitudes are ranked by their worst case over amplitudes and frequencies.
    """
    from damperlab.studies.answers.ranking import ranked_designs

    opened = partial(with_follow_ups, study)
    return study.warned(ranked_designs(study.cube, judging, ranking, opened, study.motions))


def _missing(study: Subject, found: "xr.Dataset", judging: Judging, _: Ranking) -> "tuple[Study, ...]":
    from damperlab.studies.answers.particle_friction import find_friction

    return find_friction(study.cube, found, judging).studies


def with_follow_ups(study: Subject, follow_ups: Iterable[str]) -> "dict[str, xr.Dataset]":
    """Open the cubes of a study and of its follow-ups. The keys are the ids of the studies."""
    from damperlab.studies.answers.suite import require_harmonic

    opened = [study, *map(study.beside, follow_ups)]
    over_amplitudes = kind_of(study.record.dimensions) is AMPLITUDES
    for each in opened:
        require_harmonic(each.record.dimensions, "follow-ups", over_amplitudes)
    return {each.record.id: each.cube for each in opened}


def _draw(found: "xr.Dataset", names: tuple[str, ...]) -> "Figure":
    from damperlab.service.figures.curves import draw_ranking

    return draw_ranking(found)


def _tell(study: Subject, found: "xr.Dataset", details: bool, judging: Judging, ranking: Ranking) -> Words:
    from damperlab.service.cli.words import axes_of, rows_table, words_of
    from damperlab.studies.answers.phrases import Phrases
    from damperlab.studies.answers.quantities import MEANT

    phrases, words = Phrases.of(study.cube), words_of(found)
    further = (each["sentence"] for each in words.get("doubts", ()) if each["kind"] not in SAID)
    told = [*further, words["note"]]
    # the designs of a Pareto front are always shown in a table, because none of them is the best
    if found.sizes["rank"] < 2 or not (details or "pareto" in found.attrs):
        return Words(words["brief"], told)
    shown = found.drop_vars(["lowest", "highest"], errors="ignore")
    shown = shown if details else shown.isel(rank=slice(MOST_ROWS))
    table = rows_table(shown, phrases, MEANT | _worst_of(found, phrases), axes_of(study.cube))
    return Words(words["brief"], told, table)


def _worst_of(found: "xr.Dataset", phrases: "Phrases") -> dict[str, str]:
    """Return the names of the results in the columns `value` and `error` of a ranking by the worst case."""
    metric = str(found.attrs.get("metric", "amplitude_ratio"))
    error = metric.replace("amplitude", "amplitude_error", 1)
    return {"value": metric} | ({"error": error} if phrases.unit(error) else {})


OPTIMAL_DESIGNS: "Question[answers.Designs]" = Question(
    route="optimal-designs",
    command="optimum",
    first=True,
    summary="Designs in the order of their response",
    help="Rank the designs of a study, the best first. For a suite or several base amplitudes, rank by the worst case.",
    asks=(Judging, Ranking),
    answer=answer,
    gives=RankedDesigns,
    form=RANKING,
    draw=_draw,
    tell=_tell,
    operation="ask_designs",
    further=Further(
        "friction",
        "Find the largest particle friction at which the response of the best damper rises by at most a "
        "tenth.",
        _missing,
    ),
)
