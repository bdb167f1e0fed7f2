"""Converts pages of HTML to PDF with WeasyPrint, which is installed with the extra `pdf`."""

import warnings
from typing import Any

from damperlab.studies.answers.query_fault import refused

NEEDED = "a PDF needs WeasyPrint, of the extra damperlab[pdf], and the system library Pango"


def require_printer() -> Any:
    """Import WeasyPrint and return the module.

    Raises
    ------
    QueryFault
        If WeasyPrint is not installed or cannot find Pango.
    """
    try:
        with warnings.catch_warnings():
            # WeasyPrint warns that a later version will require HarfBuzz's subsetting library
            warnings.simplefilter("ignore", DeprecationWarning)
            import weasyprint
    except (ImportError, OSError) as error:
        why = "WeasyPrint is not installed" if isinstance(error, ImportError) else "WeasyPrint finds no Pango"
        advice = "install both, as in `pip install damperlab[pdf]`, or print the HTML with a browser"
        told = f"A PDF cannot be written here: {why}."
        raise refused("format", "pdf", NEEDED, advice, told) from None
    return weasyprint


def printed(text: str) -> bytes:
    """Convert a self-contained page of HTML to a PDF with A4 pages.

    Parameters
    ----------
    text : str
        HTML, made by `damperlab.service.html.page`. No addresses in the HTML are fetched.

    Returns
    -------
    bytes
        PDF with searchable text and vector graphics.

    Raises
    ------
    QueryFault
        If WeasyPrint is not installed or cannot find Pango.
    """
    weasyprint = require_printer()
    fetcher = weasyprint.URLFetcher(allowed_protocols=("data",))
    content: bytes = weasyprint.HTML(string=text, url_fetcher=fetcher).write_pdf()
    return content
