"""Display of an object in a notebook: a heading and a small table, as escaped HTML."""

from collections.abc import Iterable
from html import escape


def card(heading: str, rows: Iterable[tuple[str, object]]) -> str:
    """Write a heading and a table of two columns as HTML.

    Parameters
    ----------
    heading : str
        Heading of the object.
    rows : iterable of (str, object)
        Name and value of each row; a row with the value None is omitted.
    """
    cells = "".join(
        f'<tr><th style="text-align:left">{escape(name)}</th><td style="text-align:left">{escape(str(value))}</td></tr>'
        for name, value in rows
        if value is not None
    )
    return f"<div><strong>{escape(heading)}</strong><table>{cells}</table></div>"
