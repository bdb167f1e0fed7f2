"""Files that `damperlab fit` writes: a figure or a report, and a study."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from damperlab.service.cli.documents import DOCUMENTS, check_document, write_document
from damperlab.service.cli.options import check_file
from damperlab.service.cli.output import make_parent, note, working

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from damperlab.studies.fit.fitted import Fitted
    from damperlab.studies.fit.history.fitted import FittedHistory

FIGURES = (".png", ".svg")


def check_output(output: Path | None) -> None:
    """Check before a computation that a figure or a report can be written; see `check_document`."""
    check_file(output, (*FIGURES, *DOCUMENTS))
    if output is not None and output.suffix in DOCUMENTS:
        check_document(output)


def write_fit(fitted: "Fitted", output: Path) -> None:
    """Write the measured and the fitted response as a figure, or the complete fit as a report."""
    from damperlab.service.figures.fit import draw_fit
    from damperlab.service.fit_report import fit_report
    from damperlab.worker.fit.model import curves_of

    curves = curves_of(fitted)
    _write(output, lambda: draw_fit(fitted, curves), lambda: fit_report(fitted, curves))


def write_history_fit(fitted: "FittedHistory", output: Path) -> None:
    """Write the measured and the fitted time history as a figure, or the complete fit as a report."""
    from damperlab.service.figures.history_fit import draw_history_fit
    from damperlab.service.history_report import history_report

    _write(output, lambda: draw_history_fit(fitted), lambda: history_report(fitted))


def _write(output: Path, draw: "Callable[[], Figure]", report: Callable[[], str]) -> None:
    from damperlab.service.figures.style import save

    with working("Drawing"):
        if output.suffix in DOCUMENTS:
            write_document(report(), output)
        else:
            save(draw(), make_parent(output))
    note(f"Wrote {output}.")


def write_study(fitted: "Fitted | FittedHistory", path: Path) -> None:
    """Write the definition of a study with the fitted prototype to a file."""
    import yaml

    document = fitted.study()
    if path.suffix == ".json":
        text = json.dumps(document, indent=2, ensure_ascii=False) + "\n"
    else:
        text = yaml.safe_dump(document, allow_unicode=True, sort_keys=False)
    make_parent(path).write_text(text, encoding="utf-8")
    note(f"Wrote {path}; `damperlab run {path}` computes it. {fitted.chosen}".rstrip())
