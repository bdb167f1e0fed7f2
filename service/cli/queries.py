"""Commands that ask a stored study: map, response, optimum. A table, a JSON document, or a file."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from damperlab.service.cli.dialect import fixes_dimensions
from damperlab.service.cli.options import (
    AsJson,
    At,
    Band,
    DataDir,
    ExcludeLocked,
    MaxImpactSpeed,
    Objective,
    Output,
    StudyId,
    Top,
    Within,
    check_file,
    read_at,
    read_judging,
)
from damperlab.service.cli.output import make_parent, note, print_json, print_table, say, working
from damperlab.service.cli.store import label, open_store
from damperlab.service.cli.words import (
    columns_left_out,
    completeness_sentence,
    map_table,
    rows_table,
    slice_sentence,
    worst_sentence,
)
from damperlab.studies.vocabulary import Reduction

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    import xarray as xr
    from matplotlib.figure import Figure

    from damperlab.studies.store.record import Record

Interpolate = Annotated[
    bool,
    typer.Option(
        "--interpolate", help="Interpolate between grid points where the response class does not change."
    ),
]
MapMetric = Annotated[
    str | None,
    typer.Option(
        help="Result variable to show; amplitude_ratio by default, peak_relative_displacement_m for a ground-motion suite."
    ),
]
Metric = Annotated[str, typer.Option(help="Result variable to show.")]


@fixes_dimensions
def map_(
    study: StudyId,
    x: Annotated[str | None, typer.Option(help="Dimension on the horizontal axis.")] = None,
    y: Annotated[str | None, typer.Option(help="Dimension on the vertical axis.")] = None,
    metric: MapMetric = None,
    over: Annotated[
        str | None, typer.Option(help="A third dimension, over which the result is reduced.")
    ] = None,
    reduce: Annotated[
        Reduction | None, typer.Option(help="How the third dimension is reduced; max by default.")
    ] = None,
    at: At = None,
    interpolate: Interpolate = False,
    output: Output = None,
    data_dir: DataDir = None,
    as_json: AsJson = False,
) -> None:
    """Show a result over two dimensions, such as the amplitude at resonance over clearance and friction."""
    check_file(output)
    fixed = read_at(at)
    record, cube = ask(study, data_dir)
    from damperlab.service.answers import map_document
    from damperlab.studies.answers.resonance_map import resonance_map
    from damperlab.studies.answers.selection import main_metric
    from damperlab.studies.answers.shown import shown_axes

    metric = metric or main_metric(cube)
    x, y = shown_axes({str(name): size for name, size in cube.sizes.items()}, x, y, {*fixed, over})

    with working("Reading the cube"):
        answer = resonance_map(cube, x, y, metric, over, reduce, fixed, interpolate)

    def draw() -> "Figure":
        from damperlab.service.figures.resonance_map import draw_map

        return draw_map(answer, metric)

    def tell() -> None:
        say(slice_sentence(answer, metric, label(record)))
        print_table(*map_table(answer, metric))
        say_if(columns_left_out(answer, metric))
        say_if(completeness_sentence(answer))

    hand_out(record, answer, output, as_json, draw, lambda: map_document(answer, metric), tell)


@fixes_dimensions
def response(
    study: StudyId,
    metric: Metric = "amplitude_ratio",
    at: At = None,
    interpolate: Interpolate = False,
    with_: Annotated[
        str | None,
        typer.Option(
            "--with",
            metavar="ID",
            help="A second study to compare with, such as the downward sweep of a hysteresis.",
        ),
    ] = None,
    output: Output = None,
    data_dir: DataDir = None,
    as_json: AsJson = False,
) -> None:
    """Show a frequency response of one design, or compare that of two studies."""
    check_file(output)
    if interpolate and with_ is not None:
        raise typer.BadParameter("--interpolate and --with cannot be combined. Leave one of them out.")
    fixed = read_at(at)
    record, cube = ask(study, data_dir, "response")
    from damperlab.service.answers import response_document
    from damperlab.studies.answers.compared_response import compared_response
    from damperlab.studies.answers.frequency_response import frequency_response

    if with_ is None:
        with working("Reading the cube"):
            answer = frequency_response(cube, metric, fixed, interpolate)
    else:
        other, second = ask(with_, data_dir, "response")
        with working("Reading the cubes"):
            answer = compared_response(cube, second, metric, fixed)
        answer.attrs["studies"] = [record.id, other.id]
        names = (record.name or record.id, other.name or other.id)

    def draw() -> "Figure":
        from damperlab.service.figures.curves import draw_compared, draw_response

        return draw_response(answer, metric) if with_ is None else draw_compared(answer, metric, names)

    def tell() -> None:
        say(slice_sentence(answer, metric, label(record)))
        print_table(*rows_table(answer))
        say_if(completeness_sentence(answer))

    hand_out(record, answer, output, as_json, draw, lambda: response_document(answer, metric), tell)


def optimum(
    study: StudyId,
    objective: Objective = None,
    band: Band = None,
    top: Top = 10,
    exclude_locked: ExcludeLocked = False,
    max_impact_speed: MaxImpactSpeed = None,
    within: Within = None,
    metric: Annotated[
        str | None,
        typer.Option(
            help="Result that dampers of a ground-motion suite are ranked by; peak_relative_displacement_m by default.",
        ),
    ] = None,
    record_: Annotated[
        list[str] | None,
        typer.Option(
            "--record",
            metavar="ID",
            help="Consider only this record of a ground-motion suite. May be repeated.",
        ),
    ] = None,
    pareto: Annotated[
        str | None,
        typer.Option(
            metavar="A,B[,C]",
            help="List the Pareto-optimal designs in these objectives, as in amplitude,mass.",
        ),
    ] = None,
    with_: Annotated[
        list[str] | None,
        typer.Option(
            "--with", metavar="ID", help="Rank the designs of this follow-up study as well. May be repeated."
        ),
    ] = None,
    output: Output = None,
    data_dir: DataDir = None,
    as_json: AsJson = False,
) -> None:
    """Rank the designs of a study, the best first; dampers of a ground-motion suite by their worst case."""
    check_file(output)
    if pareto is not None and with_:
        raise typer.BadParameter("--pareto and --with cannot be combined. Leave one of them out.")
    judging = read_judging(objective, band, exclude_locked, max_impact_speed, within)
    record, cube = ask(study, data_dir)
    from damperlab.studies.registry import is_survey

    if is_survey(record.dimensions):
        harmonic = {
            "--objective": objective,
            "--band": band,
            "--exclude-locked": exclude_locked,
            "--max-impact-speed": max_impact_speed,
            "--pareto": pareto,
            "--with": with_,
        }
        _refuse(harmonic, "a ground-motion suite ranks dampers by --metric, over --record and --within")
        _worst(record, cube, metric, top, record_, judging["ranges"], output, as_json)
        return
    _refuse(
        {"--metric": metric, "--record": record_},
        "it belongs to ground-motion suites; rank a harmonic study with --objective",
    )
    from damperlab.service.answers import designs_document
    from damperlab.studies.answers.design_question import MOST
    from damperlab.studies.answers.merged import merged_designs
    from damperlab.studies.answers.optimal_designs import optimal_designs
    from damperlab.studies.answers.pareto import pareto_front, read_respects

    with working("Judging the designs"):
        if pareto is not None:
            answer = pareto_front(cube, read_respects(pareto), top=MOST, **judging).isel(rank=slice(top))
        elif with_:
            follow_ups = [ask(other, data_dir, "optimum --with") for other in with_]
            cubes = {record.id: cube} | {other.id: its for other, its in follow_ups}
            answer = merged_designs(cubes, top=top, **judging)
        else:
            answer = optimal_designs(cube, top=top, **judging)

    def draw() -> "Figure":
        from damperlab.service.figures.curves import draw_ranking

        return draw_ranking(answer)

    def tell() -> None:
        for sentence in (*answer.attrs.get("verdict", ()), answer.attrs["note"]):
            say(sentence)
        if answer.sizes["rank"] > 1:
            print_table(*rows_table(answer.drop_vars(["lowest", "highest"])))

    hand_out(record, answer, output, as_json, draw, lambda: designs_document(answer), tell)


def _refuse(options: "Mapping[str, object]", advice: str) -> None:
    """Refuse options that this kind of study does not know."""
    for name, value in options.items():
        if value:
            raise typer.BadParameter(
                f"{name} does not apply to this kind of study: {advice}.", param_hint=name
            )


def _worst(
    record: "Record",
    cube: "xr.Dataset",
    metric: str | None,
    top: int,
    records: list[str] | None,
    ranges: dict[str, tuple[float, float]],
    output: Path | None,
    as_json: bool,
) -> None:
    """Rank a survey's dampers."""
    from damperlab.service.answers import worst_document
    from damperlab.studies.answers.survey import worst_case_designs

    with working("Judging the dampers"):
        answer = worst_case_designs(cube, metric, top, records, ranges)

    def draw() -> "Figure":
        from damperlab.service.figures.curves import draw_ranking

        return draw_ranking(answer)

    def tell() -> None:
        for sentence in (worst_sentence(answer), answer.attrs["note"]):
            say_if(sentence)
        if answer.sizes["rank"] > 1:
            print_table(*rows_table(answer))

    hand_out(record, answer, output, as_json, draw, lambda: worst_document(answer), tell)


def ask(study: str, data_dir: Path | None, harmonic: str = "") -> "tuple[Record, xr.Dataset]":
    """Find a study and open its cube; `harmonic` names a question that no survey answers."""
    from damperlab.studies.answers.survey import require_harmonic

    store = open_store(data_dir)
    record = store.find(study)
    if harmonic:
        require_harmonic(record.dimensions, harmonic)
    return record, store.cube(record.id)


def hand_out(
    record: "Record",
    answer: "xr.Dataset",
    output: Path | None,
    as_json: bool,
    draw: "Callable[[], Figure] | None",
    document: "Callable[[], dict[str, Any]]",
    tell: "Callable[[], None]",
) -> None:
    """Give an answer in the form that was asked for: a file, a JSON document, or words.

    Parameters
    ----------
    record, answer : Record, Dataset
        The study and what it answered.
    output : Path or None
        The file to write: the numbers as CSV, else a figure.
    as_json : bool
        Whether to print the document.
    draw, document, tell : callable
        Make the figure (None where there is none), make the document, print the words.
    """
    if output is not None:
        with working(f"Writing {output}"):
            make_parent(output)
            if output.suffix == ".csv" or draw is None:
                from damperlab.studies.answers.classes import with_words

                with_words(answer).to_dataframe().to_csv(output)
            else:
                from damperlab.service.figures.style import save

                save(draw(), output)
        note(f"Wrote {output}.")
    if as_json:
        print_json(answered(record, document()))
    elif output is None:
        tell()


def answered(record: "Record", answer: dict[str, Any]) -> dict[str, Any]:
    """Put the study in front of its answer."""
    return {"study": record.id, "name": record.name, "state": record.state, **answer}


def say_if(text: str) -> None:
    """Say a sentence that there may not be."""
    if text:
        say(text)
