"""Parts of reports, which are self-contained pages of HTML with embedded figures."""

import base64
import io
import re
from collections.abc import Iterable
from html import escape
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.figure import Figure

STYLE = """
:root { color-scheme: light; }
body { font: 16px/1.5 system-ui, "Segoe UI", Roboto, "Noto Sans", sans-serif; color: #16202e; }
body { max-width: 56rem; margin: 2rem auto; padding: 0 1rem; }
h1 { line-height: 1.2; overflow-wrap: anywhere; } h2 { margin-top: 2rem; border-bottom: 1px solid #d5dbe3; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; font-size: .9rem; }
th, td { text-align: left; padding: .25rem .9rem .25rem 0; border-bottom: 1px solid #d5dbe3; vertical-align: baseline; }
.wide { overflow-x: auto; } td.short { white-space: nowrap; overflow-wrap: normal; }
figure { margin: 1rem 0; } figure img { max-width: 100%; height: auto; }
figcaption, .quiet { color: #4d5a6b; font-size: .9rem; }
pre { white-space: pre-wrap; overflow-wrap: anywhere; font-size: .8rem; }
@page { margin: 18mm 15mm; @bottom-right { content: counter(page) " / " counter(pages); font-size: 9pt; color: #4d5a6b; } }
@media print { body { margin: 0; max-width: none; font-size: 10.5pt; } }
@media print { h2 { break-after: avoid; } figure, tr { break-inside: avoid; } td + td { overflow-wrap: anywhere; } }
@media print { table { font-size: 8.5pt; } th, td { padding-right: .5rem; } }
@media print { .signature td { height: 12mm; width: 33%; } .signature table { width: 100%; } }
"""


SHORT = 12
"""A table cell with at most this number of characters is not wrapped."""


def page(title: str, parts: Iterable[str]) -> str:
    """Return a page of HTML.

    Parameters
    ----------
    title : str
        Title of the page, as plain text.
    parts : iterable of str
        Parts of the content, as HTML.
    """
    title = escape(title)
    return (
        f'<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n<title>{title} · damperlab</title>\n'
        f'<meta name="viewport" content="width=device-width">\n<style>{STYLE}</style>\n</head>\n<body>\n<main>\n'
        + "\n".join(parts)
        + "\n</main>\n</body>\n</html>\n"
    )


def said(text: str, kind: str = "") -> str:
    """Return a paragraph of HTML.

    Parameters
    ----------
    text : str
        Plain text. Names in backticks are set in a code font.
    kind : str
        CSS class of the paragraph; "quiet" for remarks.
    """
    named = re.sub("`([^`]+)`", r"<code>\1</code>", escape(text))
    return f"<p{f' class={kind}' if kind else ''}>{named}</p>"


def table(label: str, head: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    """Return an HTML table of plain texts. Screen readers read the label of the table."""
    heads = "".join(f'<th scope="col">{escape(text)}</th>' for text in head)
    body = "".join("<tr>" + "".join(_cell(str(cell)) for cell in row) + "</tr>" for row in rows)
    region = f'class="wide" tabindex="0" role="region" aria-label="{label}"'
    return f"<div {region}><table><thead><tr>{heads}</tr></thead><tbody>{body}</tbody></table></div>"


def _cell(text: str) -> str:
    """Return a table cell. A short text, for example a number with its unit, is not wrapped."""
    return f"<td{' class=short' if 0 < len(text) <= SHORT else ''}>{escape(text)}</td>"


def drawing(figure: "Figure", caption: str) -> str:
    """Return a figure as embedded SVG, with the caption below it."""
    from damperlab.service.figures.style import styled

    drawn = io.BytesIO()
    for axes in figure.axes:
        axes.set_title("", loc="left")  # the caption replaces the title
    # text is drawn as outlines, because fonts of other machines have other widths
    with styled({"svg.fonttype": "path"}):
        figure.savefig(drawn, format="svg", metadata={"Date": None})
    # an embedded image has its own ids, so the ids of two figures on a page cannot collide
    data = base64.b64encode(drawn.getvalue()).decode()
    text = escape(caption)
    return f'<figure><img alt="{text}" src="data:image/svg+xml;base64,{data}"><figcaption>{text}</figcaption></figure>'
