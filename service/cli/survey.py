"""The command survey: a grid over records, scales and designs."""

from pathlib import Path
from typing import Annotated, Any

import typer

from service.cli.options import AsJson, DataDir, check_file, check_name
from service.cli.output import make_parent, note, number, print_json, print_table, say, working
from service.cli.store import data_folder

SUFFIXES = (".nc", ".csv")


def survey(
    file: Annotated[
        Path, typer.Argument(metavar="SURVEY", help="A .yaml or .json file: records, scale, and design axes.")
    ],
    metric: Annotated[
        str, typer.Option(help="What counts in the ranking, as peak_relative_displacement_m.")
    ] = "peak_relative_displacement_m",
    top: Annotated[int, typer.Option(min=1, max=1000, help="How many designs.")] = 10,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", metavar="FILE", help="Write all results as .nc or .csv.")
    ] = None,
    data_dir: DataDir = None,
    as_json: AsJson = False,
) -> None:
    """Compute designs under several records and scales, and rank them by their worst case.

    It runs in this process on all cores and is not kept in the store: -o keeps it.
    """
    check_file(output, SUFFIXES)
    from studies.ground.shelf import Shelf
    from studies.ground.survey import read_survey
    from worker.ground.response import GroundResponse

    check_name("--metric", metric, tuple(GroundResponse.__dataclass_fields__))
    asked = read_survey(_document(file), Shelf(data_folder(data_dir)))
    with working(f"Computing {asked.points:,} points (the first time, kernels are compiled)"):
        from worker.ground.survey import best_designs, run_survey

        answer = run_survey(asked)
    best = best_designs(answer, metric, top)
    if output is not None:
        if output.suffix == ".nc":
            answer.to_netcdf(make_parent(output), engine="h5netcdf")
        else:
            frame = answer.to_dataframe().reset_index()
            frame.to_csv(make_parent(output), index=False, float_format="%.17g")
        note(f"Wrote {output}.")
    if as_json:
        print_json({"points": asked.points, "metric": metric, "best": _rows(best)})
        return
    failed = int((answer["status"] != 0).sum())
    say(f"{asked.points:,} points, {failed} failed. Worst over records, scales and structures:")
    names = [str(name) for name in best.data_vars]
    print_table(names, ([number(float(row[name])) for name in names] for row in _rows(best)))


def _rows(best: Any) -> list[dict[str, float]]:
    columns = {str(name): best[name].values.tolist() for name in best.data_vars}
    return [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]


def _document(file: Path) -> Any:
    from studies.text import Format, load_text

    formats: dict[str, Format] = {".json": "json", ".yaml": "yaml", ".yml": "yaml"}
    if file.suffix.lower() not in formats:
        raise typer.BadParameter(f"found {file.name!r}, allowed: a name that ends in {', '.join(formats)}")
    try:
        return load_text(file.read_bytes(), formats[file.suffix.lower()])
    except OSError as error:
        raise typer.BadParameter(f"found {file}, which cannot be read: {error.strerror}") from None
