"""The question that compares a design with a tuned mass damper."""

from typing import TYPE_CHECKING, NotRequired

from typing_extensions import TypedDict

from damperlab.service.questions.forms import along
from damperlab.service.questions.question import Question, Subject, Words
from damperlab.studies.brief import InShort, Notes
from damperlab.studies.kinds import AMPLITUDES, HARMONIC
from damperlab.studies.questions import Design, Tuning
from damperlab.studies.shapes import Count, Number, Numbers, OfPoints, Range, Sentences
from damperlab.studies.vocabulary import Criterion

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

    from damperlab.service.client import answers


class Frequencies(TypedDict):
    """Frequencies to compute next."""

    start: Number
    stop: Number
    num: Count


class Exact(TypedDict):
    """Exact curves for a figure, at frequencies close enough to miss no peak."""

    frequency_ratio: Numbers
    tmd: Numbers
    no_damper: Numbers


class TmdComparison(OfPoints):
    """A design compared with a tuned mass damper over the frequency ratio."""

    next_frequencies: NotRequired[Frequencies]
    frequency_ratio: Numbers
    hybrid: Numbers
    tmd: Numbers
    no_damper: Numbers
    criterion: Criterion
    band: Range
    verdict: Sentences
    brief: InShort
    notes: Notes
    hybrid_better: list[Range]
    exact: Exact
    judged: bool
    tmd_mass_ratio: Number
    tmd_tuning: Number
    tmd_damping_ratio: Number
    hybrid_peak: Number
    hybrid_peak_error: Number
    hybrid_peak_at: Number
    tmd_peak: Number
    tmd_peak_at: Number
    ratio: Number
    hybrid_bandwidth: Number
    tmd_bandwidth: Number
    hybrid_better_share: Number


def answer(study: Subject, tuning: Tuning, design: Design) -> "xr.Dataset":
    """Compare the responses, peaks and bandwidths with both dampers. By default, the dampers have equal masses."""
    from damperlab.studies.answers.one_amplitude import at_one_amplitude, said_of_it
    from damperlab.studies.answers.tmd_comparison import tmd_comparison

    cube, at = at_one_amplitude(study.cube, design.at)
    return study.warned(said_of_it(tmd_comparison(cube, tuning, at), cube, study.cube))


def _draw(found: "xr.Dataset", names: tuple[str, ...]) -> "Figure":
    from damperlab.service.figures.comparison import draw_comparison

    return draw_comparison(found)


def _tell(study: Subject, found: "xr.Dataset", details: bool, tuning: Tuning, design: Design) -> Words:
    from damperlab.service.cli.words import completeness_sentence, rows_table, words_of
    from damperlab.studies.answers.excited import excitation_of
    from damperlab.studies.answers.one_amplitude import at_one_amplitude
    from damperlab.studies.answers.phrases import Phrases
    from damperlab.studies.answers.quantities import MEANT

    words = words_of(found)
    if not details:
        return Words(words["brief"], [])
    cube, _ = at_one_amplitude(study.cube, design.at)
    # a comparison under a force is in ratios, because a study with a shaken base has no static displacement
    of_force = found.attrs["excitation"] != excitation_of(cube)
    phrases = Phrases.of(cube.drop_vars(list(cube.data_vars)) if of_force else cube)
    table = rows_table(found, phrases, MEANT)
    return Words(words["brief"], [words["note"]], table, (completeness_sentence(found),))


TMD_COMPARISON: "Question[answers.TmdComparison]" = Question(
    route="tmd-comparison",
    command="tmd",
    first=True,
    summary="One design compared with a tuned mass damper",
    help="Compare a design with a tuned mass damper of the same mass.",
    asks=(Tuning, Design),
    answer=answer,
    gives=TmdComparison,
    form=along("frequency_ratio"),
    draw=_draw,
    tell=_tell,
    kinds=(HARMONIC, AMPLITUDES),
)
