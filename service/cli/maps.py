"""The command that shows a map of a stored study, or those of two and their difference."""

from typing import TYPE_CHECKING

from damperlab.service.cli.asked import asks
from damperlab.service.cli.options import AsJson, DataDir, Details, Output, StudyId, check_file
from damperlab.service.cli.output import print_brief, print_table, say, working
from damperlab.service.cli.queries import ask, hand_out, say_if
from damperlab.service.cli.store import label
from damperlab.service.cli.words import (
    columns_left_out,
    completeness_sentence,
    map_brief,
    map_table,
    slice_sentence,
)
from damperlab.studies.questions import Plane, Selection, Subtracted

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@asks
def map_(
    study: StudyId,
    plane: Plane,
    selection: Selection,
    second: Subtracted,
    output: Output = None,
    data_dir: DataDir = None,
    details: Details = False,
    as_json: AsJson = False,
) -> None:
    """Show a result over two dimensions of a study.

    As the amplitude at resonance over clearance and friction. With --minus the maps of two studies and their difference.
    """
    check_file(output)
    record, cube = ask(study, data_dir)
    from damperlab.service.answers import map_document
    from damperlab.studies.answers.map_difference import map_difference
    from damperlab.studies.answers.phrases import Phrases
    from damperlab.studies.answers.resonance_map import resonance_map
    from damperlab.studies.answers.selection import main_metric
    from damperlab.studies.answers.shown import shown_axes

    metric = selection.metric or main_metric(cube)
    sizes = {str(name): size for name, size in cube.sizes.items()}
    x, y = shown_axes(sizes, plane.x, plane.y, {*selection.at, plane.over})

    names = (label(record), "")
    if second.minus is None:
        with working("Reading the cube"):
            answer = resonance_map(cube, x, y, selection, plane.over, plane.reduce)
    else:
        other, its = ask(second.minus, data_dir)
        with working("Reading the cubes"):
            answer = map_difference(cube, its, x, y, selection, plane.over, plane.reduce)
        answer.attrs["studies"] = [record.id, other.id]
        names = (label(record), label(other))

    def draw() -> "Figure":
        from damperlab.service.figures.map_difference import draw_difference
        from damperlab.service.figures.resonance_map import draw_map

        return draw_map(answer, metric) if second.minus is None else draw_difference(answer, metric, names)

    def tell() -> None:
        phrases = Phrases.of(cube).as_named(selection.metric)
        print_brief(map_brief(answer, metric, phrases, second.minus is not None).document(), (), details)
        if not details:
            return
        whose = names[0] if second.minus is None else f"{names[0]} less {names[1]}"
        say(slice_sentence(answer, metric, whose, phrases))
        print_table(*map_table(answer, metric, phrases, None if second.minus is None else "difference"))
        say_if(columns_left_out(answer, metric))
        say_if(completeness_sentence(answer))

    hand_out(record, answer, output, as_json, draw, lambda: map_document(answer, metric), tell)
