"""The question for a map over two dimensions, of one study, or of two studies and their difference."""

from typing import TYPE_CHECKING, Annotated, NotRequired

from damperlab.service.questions.forms import MAP, metric_of
from damperlab.service.questions.question import Question, Subject, Words
from damperlab.studies.brief import Notes
from damperlab.studies.faults import Fault, StudyFaults, describe
from damperlab.studies.field import given
from damperlab.studies.kinds import shown_axes
from damperlab.studies.questions import Plane as Axes
from damperlab.studies.questions import Selection, Subtracted, Window
from damperlab.studies.shapes import Numbers, OfMetric, Plane, Says
from damperlab.studies.vocabulary import Reduction

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

    from damperlab.service.client import answers


MOST_POINTS = 4_000_000
"""Largest number of values of a map that is sent by HTTP. A larger map would need much memory."""


class ResonanceMap(OfMetric):
    """One metric over two dimensions."""

    x_dimension: str
    y_dimension: str
    x: Numbers
    y: Numbers
    values: Annotated[Plane, Says(description="values[y][x]")]
    status: NotRequired[Plane]
    amplitude_error: NotRequired[Plane]
    response_class: NotRequired[Plane]
    computed_share: NotRequired[Plane]
    over: NotRequired[str]
    reduce: NotRequired[Reduction]
    thinned: NotRequired[bool]
    other: NotRequired[Plane]
    difference: NotRequired[Plane]
    studies: NotRequired[list[str]]
    notes: NotRequired[Notes]


def answer(
    study: Subject, axes: Axes, selection: Selection, second: Subtracted, shown: Window
) -> "xr.Dataset":
    """Slice the cube: `values[y][x]`. Other dimensions are fixed by `<dimension>=value`, or reduced with `over`.

    If no frequency is given, the map shows the largest value over the study's band. With `minus`, the answer also has
    `other` and `difference`. `other` holds the values of the second study. `difference` holds the first study minus
    the second.
    """
    from damperlab.studies.answers.map_difference import map_difference
    from damperlab.studies.answers.resonance_map import resonance_map
    from damperlab.studies.answers.window import window

    x, y = _axes(study, axes, selection)
    if study.http:
        _check(study, axes, x, y)
    if second.minus is None:
        found = resonance_map(study.cube, x, y, selection, axes.over, axes.reduce)
    else:
        other = study.beside(second.minus)
        found = map_difference(study.cube, other.cube, x, y, selection, axes.over, axes.reduce)
        found.attrs["studies"] = [study.record.id, other.record.id]
    return window(found, {x: shown.x_range, y: shown.y_range}, shown.most) if given(shown) else found


def _axes(study: Subject, axes: Axes, selection: Selection) -> tuple[str, str]:
    sizes = {str(name): size for name, size in study.cube.sizes.items()}
    return shown_axes(sizes, axes.x, axes.y, {*selection.at, axes.over})


def _check(study: Subject, axes: Axes, x: str, y: str) -> None:
    """Refuse a request that names no axes or whose map would be too large."""
    from damperlab.service.problems import lacking
    from damperlab.studies.answers.selection import dimensions_of
    from damperlab.studies.units import in_ratios

    cube = study.cube
    if missing := [name for name in ("x", "y") if getattr(axes, name) is None]:
        raise lacking(missing, [name for name in dimensions_of(cube) if cube[name].dtype.kind == "f"])
    x, y = in_ratios(cube, (x, y))
    points = cube.sizes.get(x, 1) * cube.sizes.get(y, 1)
    if points > MOST_POINTS:
        advice = "export the cube, or choose shorter dimensions"
        allowed = f"at most {MOST_POINTS} points"
        told = f"The map would have {points:,} points; at most {MOST_POINTS:,} are allowed."
        raise StudyFaults([Fault("x, y", f"{describe(points)} points", allowed, advice, told)])


def _draw(found: "xr.Dataset", names: tuple[str, ...]) -> "Figure":
    from damperlab.service.figures.map_difference import draw_difference
    from damperlab.service.figures.resonance_map import draw_map
    from damperlab.studies.answers.quantities import in_quantities

    metric = metric_of(found)
    if "difference" in found:
        return draw_difference(found, metric, (names[0], names[1]))
    return draw_map(*in_quantities(found, metric))


def _tell(
    study: Subject, found: "xr.Dataset", details: bool, axes: Axes, selection: Selection, *_: object
) -> Words:
    from damperlab.service.cli import words
    from damperlab.service.cli.store import label
    from damperlab.studies.answers.phrases import Phrases

    metric, two = metric_of(found), "difference" in found
    phrases = Phrases.of(study.cube).as_named(selection.metric)
    brief = study.first_warned(words.map_brief(found, metric, phrases, two, study.cube.sizes))
    whose = label(study.record)
    if two:
        whose += f" less {label(study.beside(found.attrs['studies'][1]).record)}"
    return Words(
        brief,
        [words.slice_sentence(found, metric, whose, phrases)],
        words.map_table(found, metric, phrases, "difference" if two else None) if details else None,
        (words.columns_left_out(found, metric), words.completeness_sentence(found)),
    )


RESONANCE_MAP: "Question[answers.ResonanceMap]" = Question(
    route="resonance-map",
    command="map",
    first=True,
    summary="One metric over two dimensions",
    help="Show a result over two dimensions of a study.\n\n"
    "An example is the amplitude at resonance over clearance and friction."
    " With --minus it shows the maps of two studies and their difference.",
    asks=(Axes, Selection, Subtracted, Window),
    answer=answer,
    gives=ResonanceMap,
    form=MAP,
    draw=_draw,
    draws_units=True,
    tell=_tell,
)
