"""Commands that compare: tmd, and robust."""

from typing import TYPE_CHECKING

from damperlab.service.cli.asked import asks
from damperlab.service.cli.options import AsJson, DataDir, Details, Output, StudyId, check_file
from damperlab.service.cli.output import print_brief, print_table, working
from damperlab.service.cli.queries import ask, hand_out, say_if
from damperlab.service.cli.words import axes_of, completeness_sentence, rows_table, words_of
from damperlab.studies.questions import Amplitudes, Design, Judging, Tuning

if TYPE_CHECKING:
    from matplotlib.figure import Figure


ROBUST_COLUMNS = {
    "value": "worst X/Z",
    "error": "error of it",
    "best_case": "best X/Z",
    "nominal": "X/Z at the nominal amplitude",
    "distance": "share off the grid",
}
"""What columns of a robust ranking are called on a terminal: its values are ratios, whatever the study is given in."""


@asks
def tmd(
    study: StudyId,
    tuning: Tuning,
    design: Design,
    output: Output = None,
    data_dir: DataDir = None,
    details: Details = False,
    as_json: AsJson = False,
) -> None:
    """Compare one design of a study with a tuned mass damper of the same mass, over frequency."""
    check_file(output)
    record, whole = ask(study, data_dir, "tmd", amplitudes=True)
    from damperlab.service.comparisons import columns_document
    from damperlab.studies.answers.excited import excitation_of
    from damperlab.studies.answers.one_amplitude import at_one_amplitude, said_of_it
    from damperlab.studies.answers.phrases import Phrases
    from damperlab.studies.answers.tmd_comparison import tmd_comparison

    with working("Tuning"):
        cube, at = at_one_amplitude(whole, design.at)
        answer = said_of_it(tmd_comparison(cube, tuning, at), cube, whole)

    def draw() -> "Figure":
        from damperlab.service.figures.comparison import draw_comparison

        return draw_comparison(answer)

    def tell() -> None:
        words = words_of(answer)
        print_brief(words["brief"], [words["note"]], details)
        if not details:
            return
        # a force beside a shaken base has no base amplitude that its static displacement could be over
        of_force = answer.attrs["excitation"] != excitation_of(cube)
        phrases = Phrases.of(cube.drop_vars(list(cube.data_vars)) if of_force else cube)
        columns = dict.fromkeys(("hybrid", "tmd", "no_damper"), "amplitude_ratio")
        print_table(*rows_table(answer, phrases, columns))
        say_if(completeness_sentence(answer))

    hand_out(record, answer, output, as_json, draw, lambda: columns_document(answer), tell)


@asks
def robust(
    study: StudyId,
    amplitudes: Amplitudes,
    judging: Judging,
    output: Output = None,
    data_dir: DataDir = None,
    details: Details = False,
    as_json: AsJson = False,
) -> None:
    """Rank dampers of fixed force and clearance by their worst case while the base amplitude varies."""
    check_file(output, (".csv",))
    record, cube = ask(study, data_dir, "robust")
    from damperlab.service.answers import designs_document
    from damperlab.studies.answers.phrases import Phrases
    from damperlab.studies.answers.robust import robust_designs

    with working("Judging the dampers"):
        answer = robust_designs(cube, amplitudes.amplitudes, judging, amplitudes.top)

    def tell() -> None:
        phrases = Phrases.of(cube)
        words = words_of(answer)
        print_brief(words["brief"], [words["note"]], details)
        if not details:
            return
        shown = answer.rename(amplitude="base_amplitude")
        if phrases.unit("amplitude_ratio"):
            # the ratios of the grid point are over the base amplitude of the worst case; `distance` says how far off it is
            shown = shown.drop_vars([name for name in answer.data_vars if str(name).endswith("_used")])
        head, rows = rows_table(shown, phrases, {"base_amplitude": "amplitude_ratio"}, axes_of(cube))
        print_table(tuple(ROBUST_COLUMNS.get(name, name) for name in head), rows)

    hand_out(record, answer, output, as_json, None, lambda: designs_document(answer), tell)
