"""The question for a fragility curve: the probability that a result exceeds a limit as ground motions are scaled up."""

from typing import TYPE_CHECKING, NotRequired

from damperlab.service.questions.forms import along
from damperlab.service.questions.question import Question, Subject, Words
from damperlab.studies.brief import InShort
from damperlab.studies.kinds import SUITE
from damperlab.studies.questions import Fragile
from damperlab.studies.shapes import Count, Number, Numbers, OfPoints

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

    from damperlab.service.client import answers


class Fragility(OfPoints):
    """Probability that a damper exceeds a limit, along ``scale``."""

    scale: Numbers
    exceeded: Numbers
    probability: Numbers
    lowest: Numbers
    median: Numbers
    highest: Numbers
    # the fields of `damperlab.studies.answers.over_records.OverRecords`
    mean: Numbers
    mean_error: Numbers
    rms: Numbers
    rms_error: Numbers
    quantile: Numbers
    quantile_low: Numbers
    quantile_high: Numbers
    quantile_share: Number
    threshold: Number
    metric: str
    records: Count
    brief: InShort
    never: Count
    median_scale: NotRequired[Number]
    median_scale_interval: NotRequired[Numbers]
    dispersion: NotRequired[Number]
    dispersion_interval: NotRequired[Numbers]


def answer(study: Subject, fragile: Fragile) -> "xr.Dataset":
    """Fit the probability of exceeding a limit over the scale of the records of a ground-motion suite."""
    from damperlab.studies.answers.fragility import fragility

    return fragility(study.cube, fragile)


def _draw(found: "xr.Dataset", names: tuple[str, ...]) -> "Figure":
    from damperlab.service.figures.fragility import draw_fragility

    return draw_fragility(found)


def _tell(study: Subject, found: "xr.Dataset", details: bool, fragile: Fragile) -> Words:
    from damperlab.service.cli.words import rows_table
    from damperlab.studies.answers.phrases import Phrases

    shares = ("exceeded", "probability")
    meant = {str(name): str(found.attrs["metric"]) for name in found.data_vars if name not in shares}
    table = rows_table(found, Phrases.of(study.cube), meant) if details else None
    return Words(found.attrs["brief"], [found.attrs["note"]], table)


FRAGILITY: "Question[answers.Fragility]" = Question(
    route="fragility",
    command="fragility",
    summary="Probability that a damper exceeds a limit as the records are scaled up",
    help="Fit the probability that a damper exceeds a limit, as a function of the scale of the records of a "
    "ground-motion suite.",
    asks=(Fragile,),
    answer=answer,
    gives=Fragility,
    form=along("scale"),
    draw=_draw,
    tell=_tell,
    kinds=(SUITE,),
)
