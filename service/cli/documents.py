"""HTML and PDF documents that commands write."""

import os
from pathlib import Path

from damperlab.service.cli.options import check_file
from damperlab.service.cli.output import make_parent

DOCUMENTS = (".html", ".htm", ".pdf")


def check_document(output: Path | None) -> None:
    """Check before a computation that a document can be written.

    Raises
    ------
    BadParameter
        If the suffix of the file belongs to no known format.
    QueryFault
        If the file is a PDF, and the library that prints PDF is not installed.
    """
    check_file(output, DOCUMENTS)
    if output is not None and output.suffix == ".pdf":
        from damperlab.service.printing import require_printer

        require_printer()


def write_document(text: str, output: Path) -> None:
    """Write a page of HTML to a file; the page is printed as PDF if the suffix is .pdf.

    The file appears only when it is complete.
    """
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
