"""The command importance: which parameter of a study matters."""

from typing import TYPE_CHECKING

from damperlab.service.cli.asked import asks
from damperlab.service.cli.options import AsJson, DataDir, Output, StudyId, check_file
from damperlab.service.cli.output import number, print_table, say, working
from damperlab.service.cli.queries import ask, hand_out
from damperlab.service.cli.words import words_of
from damperlab.studies.questions import Varied

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@asks
def importance(
    study: StudyId,
    varied: Varied,
    output: Output = None,
    data_dir: DataDir = None,
    as_json: AsJson = False,
) -> None:
    """Say which parameter matters: the share of a result's variance over the grid that each explains alone."""
    check_file(output)
    record, cube = ask(study, data_dir)
    from damperlab.service.comparisons import columns_document
    from damperlab.studies.answers.importance import importance as shared_out

    with working("Reading the cube"):
        answer = shared_out(cube, varied)

    def draw() -> "Figure":
        from damperlab.service.figures.importance import draw_importance

        return draw_importance(answer)

    def tell() -> None:
        say(words_of(answer)["note"])
        units = answer["effect"].attrs["units"]
        head = ("parameter", "share", "effect" if units == "1" else f"effect [{units}]", "values")
        columns = (answer[name].values.tolist() for name in ("dimension", "share", "effect", "number"))
        rows = (
            (name, number(share, 4), number(effect), str(size))
            for name, share, effect, size in zip(*columns, strict=True)
        )
        print_table(head, rows)

    hand_out(record, answer, output, as_json, draw, lambda: columns_document(answer), tell)
