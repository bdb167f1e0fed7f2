"""Files that the command fit writes: a figure or a report, a study, a specification."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from damperlab.service.cli.documents import DOCUMENTS, check_document, write_document
from damperlab.service.cli.options import check_file
from damperlab.service.cli.output import make_parent, note, working

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from damperlab.studies.fit.fitted import Fitted
    from damperlab.studies.fit.history.fitted import FittedHistory
    from damperlab.studies.fit.history.question import HistoryQuestion
    from damperlab.studies.fit.made import Correction, Made
    from damperlab.studies.fit.question import FitQuestion
    from damperlab.studies.fit.specified import Specified

FIGURES = (".png", ".svg")


class Wanted(NamedTuple):
    """What the options say of the answer: the files it is written to, and the specification that it corrects."""

    output: Path | None
    study: Path | None
    specification: Path | None
    correction: "Correction | None"
    as_json: bool

    def check(self, question: "FitQuestion | HistoryQuestion") -> None:
        """Refuse, before anything is computed, files that cannot be made of the answer."""
        from damperlab.studies.fit.made import check_specification, check_study

        if self.study is not None:
            check_study(question)
        if self.specification is not None or self.correction is not None:
            check_specification(question, self.correction)

    def make(self, fitted: "Fitted | FittedHistory") -> "Made":
        """Make the study and the specification, and write those that are wanted."""
        from damperlab.studies.fit.made import made_of, specification_of

        made = made_of(fitted, self.correction)
        if self.study is not None:
            write_study(fitted.study(), self.study)
        if self.specification is not None:
            found = made.specification
            if found is None:  # raises what stood against it
                found = specification_of(fitted.question, list(fitted.estimates), self.correction)
            write_specification(found, self.specification)
        return made


def check_output(output: Path | None) -> None:
    """Refuse, before any work is done, a figure or report that cannot be written; see `check_document`."""
    check_file(output, (*FIGURES, *DOCUMENTS))
    if output is not None and output.suffix in DOCUMENTS:
        check_document(output)


def write_fit(fitted: "Fitted", made: "Made", output: Path) -> None:
    """Write the measured and the fitted response as a figure, or all of the fit as a report."""
    from damperlab.service.figures.fit import draw_fit
    from damperlab.service.fit_report import fit_report
    from damperlab.worker.fit.model import curves_of

    curves = curves_of(fitted)
    _write(output, lambda: draw_fit(fitted, curves), lambda: fit_report(fitted, curves, made))


def write_history_fit(fitted: "FittedHistory", made: "Made", output: Path) -> None:
    """Write the measured and the fitted time history as a figure, or all of the fit as a report."""
    from damperlab.service.figures.history_fit import draw_history_fit
    from damperlab.service.history_report import history_report

    _write(output, lambda: draw_history_fit(fitted), lambda: history_report(fitted, made))


def _write(output: Path, draw: "Callable[[], Figure]", report: Callable[[], str]) -> None:
    from damperlab.service.figures.style import save

    with working("Drawing"):
        if output.suffix in DOCUMENTS:
            write_document(report(), output)
        else:
            save(draw(), make_parent(output))
    note(f"Wrote {output}.")


def write_study(document: dict[str, Any], path: Path) -> None:
    """Write the prototype as a study."""
    import yaml

    text = _json(document)
    if path.suffix != ".json":
        text = yaml.safe_dump(document, allow_unicode=True, sort_keys=False)
    make_parent(path).write_text(text, encoding="utf-8")
    note(f"Wrote {path}; `damperlab run {path}` computes it.")


def write_specification(specified: "Specified", path: Path) -> None:
    """Write a specification; what is guessed is said in comments, which JSON has none of."""
    from damperlab.studies.fit.specified import specification_text

    text = _json(specified.document) if path.suffix == ".json" else specification_text(specified)
    make_parent(path).write_text(text, encoding="utf-8")
    note(f"Wrote {path}; `damperlab design {path}` searches a damper for it.")


def _json(document: dict[str, Any]) -> str:
    return json.dumps(document, indent=2, ensure_ascii=False) + "\n"


def read_correction(correct: str, data_dir: Path | None) -> "Correction":
    """Read the specification that is corrected, with the records of its excitation."""
    from damperlab.service.cli.store import data_folder
    from damperlab.studies.fit.made import Correction
    from damperlab.studies.ground.shelf import Shelf
    from damperlab.studies.specification.reading import read_specification

    shelf = Shelf(data_folder(data_dir))
    return Correction(read_specification(correct, shelf), shelf)
