"""Commands that ask a stored study: map, response, optimum. A table, a JSON document, or a file."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from service.cli.options import (
    AsJson,
    At,
    DataDir,
    StudyId,
    check_file,
    read_at,
    read_range,
    read_within,
)
from service.cli.output import make_parent, note, print_json, print_table, say, working
from service.cli.store import label, open_store
from service.cli.words import (
    best_sentences,
    columns_left_out,
    completeness_sentence,
    map_table,
    rows_table,
    slice_sentence,
)

if TYPE_CHECKING:
    from collections.abc import Callable

    import xarray as xr
    from matplotlib.figure import Figure

    from studies.store.record import Record

Output = Annotated[
    Path | None,
    typer.Option(
        "--output", "-o", metavar="FILE", help="Write a .png, .svg, .pdf or .csv file instead of a table."
    ),
]
Interpolate = Annotated[
    bool,
    typer.Option(
        "--interpolate", help="Take values between grid points, where the class of response does not change."
    ),
]
Metric = Annotated[str, typer.Option(help="Which result variable.")]
FAVOURITES = (
    "clearance_ratio",
    "friction_ratio",
    "frequency_ratio",
    "mass_ratio",
    "restitution",
    "damping_ratio",
)
"""Which dimensions a map shows unless it is told; in this order, those with more than one value first."""


def map_(
    study: StudyId,
    x: Annotated[str | None, typer.Option(help="Dimension across.")] = None,
    y: Annotated[str | None, typer.Option(help="Dimension upwards.")] = None,
    metric: Metric = "amplitude_ratio",
    over: Annotated[str | None, typer.Option(help="A third dimension, to be reduced.")] = None,
    reduce: Annotated[str | None, typer.Option(help="How it is reduced: max (default), min or mean.")] = None,
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
    x, y = _choose_axes(cube, x, y, {*fixed, over})
    from studies.answers.resonance_map import resonance_map

    with working("Reading the cube"):
        answer = resonance_map(cube, x, y, metric, over, reduce, fixed, interpolate)
    if output is not None:
        from service.figures.resonance_map import draw_map

        write(answer, lambda: draw_map(answer, metric), output)
    if as_json:
        from service.answers import map_document

        print_json(answered(record, map_document(answer, metric)))
    elif output is None:
        say(slice_sentence(answer, metric, label(record)))
        print_table(*map_table(answer, metric))
        _say_if(columns_left_out(answer, metric))
        _say_if(completeness_sentence(answer))


def response(
    study: StudyId,
    metric: Metric = "amplitude_ratio",
    at: At = None,
    interpolate: Interpolate = False,
    output: Output = None,
    data_dir: DataDir = None,
    as_json: AsJson = False,
) -> None:
    """Show a result over the frequency ratio at one design."""
    check_file(output)
    fixed = read_at(at)
    record, cube = ask(study, data_dir)
    from studies.answers.frequency_response import frequency_response

    with working("Reading the cube"):
        answer = frequency_response(cube, metric, fixed, interpolate)
    if output is not None:
        from service.figures.curves import draw_response

        write(answer, lambda: draw_response(answer, metric), output)
    if as_json:
        from service.answers import response_document

        print_json(answered(record, response_document(answer, metric)))
    elif output is None:
        say(slice_sentence(answer, metric, label(record)))
        print_table(*rows_table(answer))
        _say_if(completeness_sentence(answer))


def optimum(
    study: StudyId,
    objective: Annotated[
        str | None,
        typer.Option(help="What counts: peak, resonance, band_mean or band_rms; peak where there is a band."),
    ] = None,
    band: Annotated[
        str | None, typer.Option(metavar="LO,HI", help="Only frequency ratios in this band count.")
    ] = None,
    top: Annotated[int, typer.Option(min=1, max=10_000, help="How many designs.")] = 10,
    exclude_locked: Annotated[
        bool, typer.Option("--exclude-locked", help="Leave out designs that friction locks to the base.")
    ] = False,
    max_impact_speed: Annotated[
        float | None, typer.Option(help="Leave out designs that impact faster than this, over Z·ω_n.")
    ] = None,
    within: Annotated[
        list[str] | None,
        typer.Option(metavar="DIMENSION=LO,HI", help="Only designs in this range; may be repeated."),
    ] = None,
    pareto: Annotated[
        str | None,
        typer.Option(
            metavar="A,B[,C]",
            help="Instead, the designs that none beats at once in these, as amplitude,mass.",
        ),
    ] = None,
    with_: Annotated[
        list[str] | None,
        typer.Option("--with", metavar="ID", help="A follow-up study to rank together; may be repeated."),
    ] = None,
    output: Output = None,
    data_dir: DataDir = None,
    as_json: AsJson = False,
) -> None:
    """Rank the designs of a study, the best first."""
    check_file(output)
    if pareto is not None and with_:
        raise typer.BadParameter("found both --pareto and --with, allowed: one of the two")
    limits = None if band is None else read_range("--band", band)
    ranges = read_within(within)
    record, cube = ask(study, data_dir)
    from studies.answers.design_question import MOST
    from studies.answers.merged import merged_designs
    from studies.answers.optimal_designs import optimal_designs
    from studies.answers.pareto import pareto_front, read_respects

    question = (objective, limits, MOST, exclude_locked, max_impact_speed, ranges)
    with working("Judging the designs"):
        # More than are shown: the sentences count the designs that are as good, and look for one with impacts.
        if pareto is not None:
            ranked = pareto_front(cube, read_respects(pareto), *question)
        elif with_:
            follow_ups = [ask(other, data_dir) for other in with_]
            cubes = {record.id: cube} | {other.id: its for other, its in follow_ups}
            ranked = merged_designs(cubes, *question)
        else:
            ranked = optimal_designs(cube, *question)
        answer = ranked.isel(rank=slice(top))
    if output is not None:
        from service.figures.curves import draw_ranking

        write(answer, lambda: draw_ranking(answer), output)
    if as_json:
        from service.answers import designs_document

        print_json(answered(record, designs_document(answer)))
    elif output is None:
        for sentence in (*([] if pareto else best_sentences(ranked)), answer.attrs["note"]):
            say(sentence)
        if answer.sizes["rank"] > 1:
            print_table(*rows_table(answer))


def ask(study: str, data_dir: Path | None) -> "tuple[Record, xr.Dataset]":
    """Find a study and open its cube."""
    store = open_store(data_dir)
    record = store.find(study)
    return record, store.cube(record.id)


def _choose_axes(cube: "xr.Dataset", x: str | None, y: str | None, taken: set[str | None]) -> tuple[str, str]:
    """Fill in the axes that were not named with the dimensions that vary and are not spoken for."""
    free = [name for name in FAVOURITES if name not in {*taken, x, y}]
    free.sort(key=lambda name: cube.sizes[name] == 1)
    return x or free.pop(0), y or free.pop(0)


def answered(record: "Record", answer: dict[str, object]) -> dict[str, object]:
    """Put the study in front of its answer."""
    return {"study": record.id, "name": record.name, "state": record.state, **answer}


def write(answer: "xr.Dataset", draw: "Callable[[], Figure] | None", output: Path) -> None:
    """Write an answer: its numbers as CSV, else a figure in the format of the suffix."""
    with working(f"Writing {output}"):
        make_parent(output)
        if output.suffix == ".csv" or draw is None:
            answer.to_dataframe().to_csv(output)
        else:
            from service.figures.style import save

            save(draw(), output)
    note(f"Wrote {output}.")


def _say_if(text: str) -> None:
    if text:
        say(text)
