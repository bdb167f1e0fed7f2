"""Documents as PDF, printed from their HTML by WeasyPrint, which comes with the extra `pdf`."""

import warnings
from typing import Any

from damperlab.studies.answers.query_fault import refused

NEEDED = "a PDF needs WeasyPrint, of the extra damperlab[pdf], and the system library Pango"


def require_printer() -> Any:
    """Give WeasyPrint.

    Raises
    ------
    QueryFault
        If it is not installed, or finds no Pango.
    """
    try:
        with warnings.catch_warnings():
            # it works without HarfBuzz's subsetting library, but warns that a later version will require it
            warnings.simplefilter("ignore", DeprecationWarning)
            import weasyprint
    except (ImportError, OSError) as error:
        why = "WeasyPrint is not installed" if isinstance(error, ImportError) else "WeasyPrint finds no Pango"
        advice = "install both, as in `pip install damperlab[pdf]`, or print the HTML with a browser"
        told = f"A PDF cannot be written here: {why}."
        raise refused("format", "pdf", NEEDED, advice, told) from None
    return weasyprint


def printed(text: str) -> bytes:
    """Print a self-contained page of HTML on sheets of A4.

    Parameters
    ----------
    text : str
        Of `damperlab.service.html.page`. Addresses in it are never followed.

    Returns
    -------
    bytes
        PDF; text stays text, and figures stay vector graphics.

    Raises
    ------
    QueryFault
        As `require_printer` does.
    """
    weasyprint = require_printer()
    fetcher = weasyprint.URLFetcher(allowed_protocols=("data",))
    content: bytes = weasyprint.HTML(string=text, url_fetcher=fetcher).write_pdf()
    return content
