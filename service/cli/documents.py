"""Documents written by commands: HTML, or PDF."""

import os
from pathlib import Path

from damperlab.service.cli.options import check_file
from damperlab.service.cli.output import make_parent

DOCUMENTS = (".html", ".htm", ".pdf")


def check_document(output: Path | None) -> None:
    """Refuse, before computing, a document that cannot be written.

    Raises
    ------
    BadParameter
        If its suffix is no known format.
    QueryFault
        If it is a PDF, and no printer for it is installed.
    """
    check_file(output, DOCUMENTS)
    if output is not None and output.suffix == ".pdf":
        from damperlab.service.printing import require_printer

        require_printer()


def write_document(text: str, output: Path) -> None:
    """Write a page of HTML in the format of the file's suffix; the file appears when it is complete."""
    content = text.encode()
    if output.suffix == ".pdf":
        from damperlab.service.printing import printed

        content = printed(text)
    partial = make_parent(output).with_name(f"{output.name}.{os.getpid()}.partial")
    try:
        partial.write_bytes(content)
        partial.replace(output)
    finally:
        partial.unlink(missing_ok=True)
