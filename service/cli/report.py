"""`damperlab report` writes a stored study as one document."""

from pathlib import Path
from typing import Annotated

from damperlab.service.cli.documents import check_document, write_document
from damperlab.service.cli.options import DataDir, StudyId
from damperlab.service.cli.output import note, working
from damperlab.service.cli.places import file_option
from damperlab.service.cli.store import find_study, label, open_store, unfinished
from damperlab.service.questions.question import Subject


def report(
    study: StudyId,
    output: Annotated[
        Path,
        file_option("--output", "-o", help="The file to write, .html or .pdf."),
    ],
    data_dir: DataDir = None,
) -> None:
    """Write a study as one document.

    The document contains maps, designs, a comparison with a tuned mass damper, accuracy, cost and versions.
    """
    check_document(output)
    store = open_store(data_dir)
    record = find_study(store, study)
    with working(f"Writing {output}"):
        from damperlab.service.study_report import study_report

        write_document(study_report(Subject(record, store, "report")), output)
    note(f"Wrote the report of {label(record)} to {output}{unfinished(record)}.")
