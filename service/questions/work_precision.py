"""The question for a work-precision diagram: the errors of the points of a study against the run times."""

from typing import TYPE_CHECKING

from damperlab.service.questions.forms import along
from damperlab.service.questions.question import Question, Subject, Words
from damperlab.studies.kinds import HARMONIC
from damperlab.studies.shapes import Numbers, OfPoints

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

    from damperlab.service.client import answers


class WorkPrecision(OfPoints):
    """Error against run time over the points of a study."""

    run_time: Numbers
    number: Numbers
    error_low: Numbers
    error_median: Numbers
    error_high: Numbers
    max_cycles_share: Numbers


def answer(study: Subject) -> "xr.Dataset":
    """Sort the points by run time, and give the errors for each time."""
    from damperlab.studies.answers.work_precision import work_precision

    return work_precision(study.cube)


def _draw(found: "xr.Dataset", names: tuple[str, ...]) -> "Figure":
    from damperlab.service.figures.curves import draw_precision

    return draw_precision(found)


def _tell(study: Subject, found: "xr.Dataset", details: bool) -> Words:
    from damperlab.service.cli.output import number

    names = ("run_time", *map(str, found.data_vars))
    rows = zip(*(found[name].values.tolist() for name in names), strict=True)
    spelled = [tuple(number(value, 3) for value in row) for row in rows]
    return Words(None, [found.attrs["note"]], (("run_time [s]", *names[1:]), spelled))


WORK_PRECISION: "Question[answers.WorkPrecision]" = Question(
    route="work-precision",
    command="precision",
    summary="Error against run time over the points",
    help="Show the error of a study's points against their run time (work-precision diagram).",
    asks=(),
    answer=answer,
    gives=WorkPrecision,
    form=along("run_time"),
    draw=_draw,
    tell=_tell,
    kinds=(HARMONIC,),
    details=False,
)
