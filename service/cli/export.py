"""`damperlab export` writes a stored cube to one file for other programs."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from damperlab.service.cli.failures import UsageFault
from damperlab.service.cli.options import DataDir, StudyId
from damperlab.service.cli.output import make_parent, note, working
from damperlab.service.cli.places import file_option
from damperlab.service.cli.store import find_study, label, open_store, unfinished
from damperlab.studies.faults import Fault
from damperlab.studies.vocabulary import EXPORT_FORMATS, EXPORT_SUFFIXES, ExportFormat

if TYPE_CHECKING:
    import xarray as xr


def export(
    study: StudyId,
    output: Annotated[
        Path,
        file_option(
            "--output",
            "-o",
            help="The file to write: .nc, or one row for each point as .csv or .parquet.",
        ),
    ],
    file_format: Annotated[
        ExportFormat | None,
        typer.Option(
            "--format", help="The format, if the suffix of the file does not show it.", show_default=False
        ),
    ] = None,
    names: Annotated[
        bool,
        typer.Option(
            "--names",
            help="Keep the names of the user, the host and the key's owner in the file's provenance. "
            "By default they are removed.",
        ),
    ] = False,
    licence: Annotated[
        str | None,
        typer.Option(
            help="Licence of the results, for example CC-BY-4.0; it is written into the file.",
            show_default=False,
        ),
    ] = None,
    crate: Annotated[
        bool,
        typer.Option("--crate", help="Describe the file in an RO-Crate: ro-crate-metadata.json next to it."),
    ] = False,
    data_dir: DataDir = None,
) -> None:
    """Write a study's results to a file."""
    file_format = file_format or _format_of(output)
    from damperlab.studies.store.export.crate import FILE, crate_beside, write_crate
    from damperlab.studies.store.export.export import without_names, write_file

    store = open_store(data_dir)
    record = find_study(store, study)
    described = crate_beside(output)
    if crate and described not in ("", output.name):
        told = f"{output.parent / FILE} describes {described}."
        advice = "write the file into a folder of its own"
        raise UsageFault(
            Fault("--crate", f"that of {described}", "no other crate in the folder", advice, told)
        )
    make_parent(output)

    def written() -> "xr.Dataset":
        cube = store.cube(record.id)
        cube = cube if names else without_names(cube)
        cube = cube if licence is None else cube.assign_attrs(license=licence)
        write_file(cube, output, file_format)
        return cube

    with working(f"Writing {output}"):
        cube = store.steadily([record.id], written)
    if crate or described == output.name:  # the crate must describe the file as it is now
        write_crate(cube, output)
    note(f"Wrote {record.points_total:,} points of {label(record)} to {output}{unfinished(record)}.")


def _format_of(output: Path) -> ExportFormat:
    """Infer the format from the name of the file."""
    known = EXPORT_SUFFIXES.get(output.suffix.lower())
    if known is None:
        message = (
            f"The format of {output.name!r} is not known from its name. End the name with "
            f"{', '.join(EXPORT_SUFFIXES)}, or add --format with one of {', '.join(EXPORT_FORMATS)}."
        )
        raise typer.BadParameter(message, param_hint="-o")
    return known
