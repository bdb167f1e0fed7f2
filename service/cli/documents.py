"""Documents that commands write: HTML, or PDF."""

import os
from pathlib import Path

from damperlab.service.cli.options import check_file
from damperlab.service.cli.output import make_parent

DOCUMENTS = (".html", ".htm", ".pdf")


def check_document(output: Path | None) -> None:
    """Refuse, before any work is done, a document that cannot be written.

    Raises
    ------
    BadParameter
        If its name says no known format.
    QueryFault
        If it is a PDF, and nothing here prints one.
    """
    check_file(output, DOCUMENTS)
    if output is not None and output.suffix == ".pdf":
        from damperlab.service.printing import require_printer

        require_printer()


def write_document(text: str, output: Path) -> None:
    """Write a page of HTML as the name of the file says; the file appears when it is complete."""
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
