"""The question which parameter matters."""

from typing import TYPE_CHECKING, Annotated

from damperlab.service.questions.forms import along
from damperlab.service.questions.question import Question, Subject, Words
from damperlab.service.questions.shapes import Count, Number, Numbers, OfPoints, Says
from damperlab.studies.kinds import EVERY_DIMENSION
from damperlab.studies.questions import Varied

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

    from damperlab.service.client import answers


class Importance(OfPoints):
    """Shares of a result's variance along ``dimension``, and the span of the mean."""

    dimension: list[Annotated[str, Says(enum=list(EVERY_DIMENSION))]]
    share: Numbers
    effect: Numbers
    number: Numbers
    metric: str
    over: str
    interactions: Number
    mean: Number
    standard_deviation: Number
    designs: Count
    without: Count


def answer(study: Subject, varied: Varied) -> "xr.Dataset":
    """Share out the variance of a result over the grid: what each parameter explains alone, and what combinations do."""
    from damperlab.studies.answers.importance import importance

    return importance(study.cube, varied)


def _draw(found: "xr.Dataset", names: tuple[str, ...]) -> "Figure":
    from damperlab.service.figures.importance import draw_importance

    return draw_importance(found)


def _tell(study: Subject, found: "xr.Dataset", details: bool, varied: Varied) -> Words:
    """List the parameters."""
    from damperlab.service.cli.output import number
    from damperlab.service.cli.words import words_of
    from damperlab.studies.answers.phrases import Phrases

    phrases, of = Phrases.of(study.cube), found.attrs["metric"]
    columns = (found[name].values.tolist() for name in ("dimension", "share", "effect", "number"))
    rows: list[tuple[str, ...]] = [
        (phrases.label(name), number(share, 4), number(phrases.printed(of, effect)), str(size))
        for name, share, effect, size in zip(*columns, strict=True)
    ]
    head = ("parameter", "share", phrases.column("effect", of), "values")
    return Words(None, [words_of(found)["note"]], (head, rows))


IMPORTANCE: "Question[answers.Importance]" = Question(
    route="importance",
    command="importance",
    summary="Which parameter matters",
    help="Say which parameter matters: the share of a result's variance over the grid that each explains alone.",
    asks=(Varied,),
    answer=answer,
    gives=Importance,
    form=along("dimension"),
    draw=_draw,
    tell=_tell,
    details=False,
)
