"""The report on the paper as a page: `python -m docs.reproduced`, or of what `damperlab check paper -o DIR` wrote, with DIR."""

import json
import sys
import tempfile
from pathlib import Path
from typing import Any

from docs.computed import record
from docs.console import ROOT, run

from damperlab.service.reproduction.report import in_markdown

PAGE = ROOT / "docs" / "reproduction.md"
KEY = "docs/reproduction.md"
RECOMPUTED = ("figures 10 and 9", "table 4", "the paper compared with itself")
"""Sections that take seconds: a test computes them anew and compares every number."""
INTRODUCTION = (
    "`damperlab check paper -o DIR` writes this report, and draws the figures next to it. The report compares "
    "every number with the paper's, for every interpretation of the paper's open choices. The last section "
    "lists contradictions within the paper."
)


def page_of(report: dict[str, Any]) -> str:
    """Put a report into a page.

    Parameters
    ----------
    report : dict
        Of `make_report`, in its long form.

    Raises
    ------
    ValueError
        If it is the short form.
    """
    if report["quick"]:
        raise ValueError("This report is the short form; run damperlab check paper without --quick.")
    bare = [{**section, "figures": []} for section in report["sections"]]
    title, _, rest = in_markdown({**report, "sections": bare}).partition("\n\n")
    return f"{title}\n\n{INTRODUCTION}\n\n{rest}"


def section_in(page: str, title: str) -> str:
    """Text of one section of a page, without its head; empty where it has none of this title."""
    _, _, rest = page.partition(f"\n## {title}\n")
    return rest.partition("\n## ")[0].strip()


def main() -> None:
    """Make the page of the report in the folder that is named, or of one that is made for it."""
    with tempfile.TemporaryDirectory() as own:
        folder = Path(sys.argv[1]) if sys.argv[1:] else Path(own)
        if not sys.argv[1:]:
            run(f"damperlab check paper -o {folder}", folder)
        PAGE.write_text(page_of(json.loads((folder / "reproduction.json").read_text())))
    record([KEY])
    print(KEY)


if __name__ == "__main__":
    main()
