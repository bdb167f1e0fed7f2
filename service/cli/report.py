"""The command report: a stored study as one document."""

import os
from pathlib import Path
from typing import Annotated

import typer

from damperlab.service.cli.options import DataDir, StudyId
from damperlab.service.cli.output import make_parent, note, working
from damperlab.service.cli.store import label, open_store


def report(
    study: StudyId,
    output: Annotated[
        Path,
        typer.Option("--output", "-o", metavar="FILE", help="The file to write, .html; a browser prints it."),
    ],
    data_dir: DataDir = None,
) -> None:
    """Write a study as one document: its maps and designs, a tuned mass damper beside them, accuracy, cost, versions."""
    if output.suffix.lower() not in (".html", ".htm"):
        raise typer.BadParameter(
            f"found {output.name!r}, allowed: a name that ends in .html", param_hint="-o"
        )
    store = open_store(data_dir)
    record = store.find(study)
    make_parent(output)
    with working(f"Writing {output}"):
        from damperlab.service.study_report import study_report

        text = study_report(record, store.cube(record.id))
        partial = output.with_name(f"{output.name}.{os.getpid()}.partial")
        try:
            partial.write_text(text, encoding="utf-8")
            partial.replace(output)
        finally:
            partial.unlink(missing_ok=True)
    note(f"Wrote the report of {label(record)} to {output}.")
