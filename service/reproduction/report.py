"""The report on the paper: all sections in order, as data and as text."""

import time
from collections.abc import Callable
from datetime import UTC, datetime
from typing import Any

from matplotlib.figure import Figure

from damperlab.service.reproduction.disagreements import disagreements
from damperlab.service.reproduction.earthquake import figure_a2, table_a1
from damperlab.service.reproduction.friction import figure_9, figure_10
from damperlab.service.reproduction.hybrid import figure_11, figure_12, table_3
from damperlab.service.reproduction.particle import figure_7, figure_8
from damperlab.service.reproduction.rubbing import table_3_rubbing
from damperlab.service.reproduction.section import MET, Section, Solve
from damperlab.service.reproduction.tuned_mass import figure_14, table_4
from damperlab.worker.jit import source_hash
from damperlab.worker.provenance import code_version

SECTIONS: dict[str, Callable[[Solve, bool], Section]] = {
    "figure 7": figure_7,
    "figure 8": figure_8,
    "figure 9": figure_9,
    "figures 10 and 9": figure_10,
    "figure 11": figure_11,
    "figure 12": figure_12,
    "table 3": table_3,
    "table 3 with friction of the particle": table_3_rubbing,
    "table 4": table_4,
    "figure 14": figure_14,
    "table A1": table_a1,
    "figure A2": figure_a2,
    "the paper compared with itself": disagreements,
}
"""Functions that compute the sections, by the names shown during the computation."""
PAPER = (
    "M. A. Akbar, W. O. Wong, E. Rustighi, A Hybrid Damper with Tunable Particle Impact Damping and Coulomb Friction, "
    "Machines 2023, 11, 545"
)


def make_report(
    solve: Solve, quick: bool = False, on_section: Callable[[str], None] = lambda what: None
) -> tuple[dict[str, Any], dict[str, Figure]]:
    """Compute every section of the report.

    Parameters
    ----------
    solve : callable
        Function that returns the cube of a study, computed or found in a store.
    quick : bool
        Whether to make a short form with a few points of each study, for tests.
    on_section : callable
        Function that is called with the name of each section before the section is computed.

    Returns
    -------
    dict, dict of Figure
        The report as JSON-able data (`created`, `version`, `kernels`, `quick`, `seconds`, `paper`, `sections`), and the
        figures by file name.
    """
    began = time.perf_counter()
    made = []
    for name, section in SECTIONS.items():
        on_section(name)
        made.append(section(solve, quick))
    report = {
        "created": datetime.now(UTC).isoformat(timespec="seconds"),
        "version": code_version(),
        "kernels": source_hash(),
        "quick": quick,
        "seconds": time.perf_counter() - began,
        "paper": PAPER,
        "sections": [section.document() for section in made],
    }
    return report, {name: figure for section in made for name, figure in section.figures.items()}


def in_markdown(report: dict[str, Any]) -> str:
    """Write a report as Markdown.

    Parameters
    ----------
    report : dict
        The report from `make_report`. The text links to figures in the same folder.
    """
    lines = [
        "# The paper reproduced",
        "",
        f"{report['paper']}.",
        "",
        f"Computed {report['created']} with damperlab {report['version']} (kernels {report['kernels']}) in "
        f"{report['seconds']:.0f} s. Every number under *This run* was computed for this report; the "
        "numbers of the paper are as printed. X/Z is the mean over steady cycles of the largest |x|/Z of a "
        "cycle, unless a row says otherwise. *Error* is its standard error, or its distance from "
        "periodicity. *Difference* is the number of this run divided by the paper's, minus one.",
        "",
    ]
    if report["quick"]:
        lines += ["**Short form: few points of each study and short runs, for trying out.**", ""]
    lines += ["| Part | Numbers met | Result |", "|---|---:|---|"]
    for section in report["sections"]:
        met, printed = section["met"]
        lines.append(_line((section["title"], f"{met} of {printed}" if printed else "", section["verdict"])))
    lines += [
        "",
        f"A number is met if at least one interpretation of the paper comes within {MET:.0%} of it.",
        "",
    ]
    for section in report["sections"]:
        lines += [f"## {section['title']}", ""]
        for name in section["figures"]:
            lines += [f"![{section['title']}]({name})", ""]
        for words in section["words"]:
            lines += [words, ""]
        lines += [
            '<details markdown="1"><summary>Numbers and studies</summary>',
            "",
            *_numbers(section),
            "</details>",
            "",
        ]
    return "\n".join(lines)


def _numbers(section: dict[str, Any]) -> list[str]:
    lines = _rows(section["rows"])
    for table in section["tables"]:
        lines += [_line(table["columns"]), _line(["---"] * len(table["columns"]))]
        lines += [*(_line(row) for row in table["rows"]), ""]
    if section["studies"]:
        names = [f"`{s['id']}` {s['name']} ({s['points']} points)" for s in section["studies"]]
        lines += [f"Studies: {'; '.join(names)}.", ""]
    return lines


def _rows(rows: list[dict[str, Any]]) -> list[str]:
    lines = [
        "| Quantity | Paper | Where in the paper | This run | Error | Difference | Contact model | Assumption |",
        "|---|---:|---|---:|---:|---:|---|---|",
    ]
    for row in rows:
        error = "" if row["error"] is None else f"{row['error']:.1g}"
        # the paper's numbers are rounded, so smaller differences mean nothing; adding 0.0 turns -0.0 into 0.0
        difference = "" if row["difference"] is None else f"{round(row['difference'], 5) + 0.0:+.1%}"
        paper = "" if row["paper"] is None else f"{row['paper']:.6g}"
        lines.append(
            _line(
                (row["quantity"], paper, row["place"] or "", _number(row["ours"]), error, difference, row["contact"],
                 row["assumption"])
            )
        )  # fmt: skip
    return [*lines, ""]


def _line(cells: Any) -> str:
    return "| " + " | ".join(str(cell).replace("|", "\\|") for cell in cells) + " |"


def _number(value: float | None) -> str:
    return "none" if value is None else f"{value:.6g}"
