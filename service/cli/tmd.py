"""The command that compares dampers with a tuned mass damper."""

from typing import TYPE_CHECKING

from damperlab.service.cli.asked import asks
from damperlab.service.cli.options import AsJson, DataDir, Details, Output, StudyId, check_file
from damperlab.service.cli.output import print_brief, print_table, working
from damperlab.service.cli.queries import ask, hand_out, say_if
from damperlab.service.cli.words import completeness_sentence, rows_table, words_of
from damperlab.studies.questions import Design, Tuning

if TYPE_CHECKING:
    from matplotlib.figure import Figure


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
    """Compare a design with a tuned mass damper of the same mass."""
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
