"""The question for the frequency response of one design, in one study or in two studies."""

from typing import TYPE_CHECKING, NotRequired

from damperlab.service.questions.forms import CURVE, metric_of
from damperlab.service.questions.question import Question, Subject, Words
from damperlab.studies.kinds import AMPLITUDES, HARMONIC
from damperlab.studies.questions import Followed, Second
from damperlab.studies.shapes import Number, Numbers, OfMetric

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

    from damperlab.service.client import answers


class FrequencyResponse(OfMetric):
    """One metric over the frequency ratio."""

    frequency_ratio: Numbers
    values: Numbers
    status: NotRequired[Numbers]
    amplitude_error: NotRequired[Numbers]
    response_class: NotRequired[Numbers]
    acceleration_g: NotRequired[Number]


def answer(study: Subject, selection: Followed, second: Second) -> "xr.Dataset":
    """Give one metric of one design over the frequency. The parameters `<dimension>=value` select the design."""
    from damperlab.studies.answers.compared_response import compared_response
    from damperlab.studies.answers.frequency_response import frequency_response
    from damperlab.studies.answers.suite import require_harmonic

    if second.with_ is None:
        return frequency_response(study.cube, selection)
    other = study.beside(second.with_)
    require_harmonic(other.record.dimensions, study.called, amplitudes=True)
    found = compared_response(study.cube, other.cube, selection)
    found.attrs["studies"] = [study.record.id, other.record.id]
    return found


def _draw(found: "xr.Dataset", names: tuple[str, ...]) -> "Figure":
    from damperlab.service.figures.curves import draw_compared, draw_response

    metric = metric_of(found)
    return draw_compared(found, metric, (names[0], names[1])) if names else draw_response(found, metric)


def _tell(study: Subject, found: "xr.Dataset", details: bool, selection: Followed, second: Second) -> Words:
    from damperlab.service.cli import words
    from damperlab.service.cli.store import label
    from damperlab.studies.answers.phrases import Phrases
    from damperlab.studies.cavity import left_open

    metric = metric_of(found)
    phrases = Phrases.of(study.cube).as_named(selection.metric)
    acts = study.record.definition.get("particle") and bool(found["mass_ratio"] > 0)
    cavity = left_open(study.record.definition) if acts else []
    meant = {"other": metric, "other_amplitude_error": "amplitude_error"}
    return Words(
        study.first_warned(words.response_brief(found, metric, phrases, cavity)),
        [words.slice_sentence(found, metric, label(study.record), phrases)],
        words.rows_table(found, phrases, meant) if details else None,
        (words.completeness_sentence(found),),
    )


FREQUENCY_RESPONSE: "Question[answers.FrequencyResponse]" = Question(
    route="frequency-response",
    command="response",
    first=True,
    summary="One metric over the frequency ratio",
    help="Show the frequency response of one design, or compare those of two studies.",
    asks=(Followed, Second),
    answer=answer,
    gives=FrequencyResponse,
    form=CURVE,
    draw=_draw,
    tell=_tell,
    kinds=(HARMONIC, AMPLITUDES),
)
