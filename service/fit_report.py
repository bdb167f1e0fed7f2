"""Writes a fit of a frequency response as a JSON document, and as a page of HTML to store or to print."""

import json
from collections.abc import Sequence
from html import escape
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from numpy.typing import NDArray
from typing_extensions import TypedDict

from damperlab.service.html import drawing, page, said, table
from damperlab.studies.faults import StudyFaults
from damperlab.studies.fit.fitted import Estimate, Fitted
from damperlab.studies.fit.history.fitted import FittedHistory
from damperlab.studies.fit.verdict import told, verdict
from damperlab.studies.shapes import Count, Number, Range, Says
from damperlab.studies.spelling import unit_of, without_unit

if TYPE_CHECKING:
    from damperlab.worker.fit.model import FittedCurve

COLUMNS = ("parameter", "value", "low", "high", "deviation", "range")


class Parameter(TypedDict):
    """An estimated parameter, with its confidence interval and the range of the search."""

    value: Number
    low: Number
    high: Number
    deviation: Number
    range: Range
    determined: bool


class Estimates(TypedDict):
    """Estimated parameters and their correlations."""

    parameters: dict[str, Parameter]
    correlation: dict[str, dict[str, Number]]


class FitDocument(Estimates):
    """Fields that the results of all fits have, for frequency responses and for time histories."""

    measured: str
    confidence: Number
    cannot_tell_apart: list[list[str]]
    chi_square: Number
    degrees_of_freedom: Count
    probability: Number
    widening: Number
    others: list[dict[str, Number]]
    evaluations: Count
    words: list[str]


class FittedDocument(FitDocument):
    """Result of a fit of a frequency response."""

    rows: list[dict[str, Number]]
    outliers: list[Count]
    units: dict[str, str]
    study: Annotated[
        dict[str, Any] | None,
        Says(
            description="The prototype with its estimated parameters, as a study; null if this is impossible."
        ),
    ]


def fit_document(fitted: Fitted) -> FittedDocument:
    """Return the result of a fit as a document."""
    question = fitted.question
    measured = question.measured
    return {
        "measured": measured.name,
        "confidence": question.confidence,
        **estimates_document(fitted.estimates, fitted.correlation),
        "cannot_tell_apart": [list(pair[:2]) for pair in fitted.alike],
        "chi_square": fitted.chi_square,
        "degrees_of_freedom": fitted.freedom,
        "probability": fitted.probability,
        "widening": fitted.widening,
        "rows": [
            {
                "frequency": measured.frequency[row],
                "measured": measured.amplitude[row],
                "deviation": fitted.deviation[row],
                "model": fitted.model[row],
                "model_error": fitted.model_error[row],
                "residual": fitted.residual[row],
                "impacts_per_cycle": fitted.impacts_per_cycle[row],
                "stick_fraction": fitted.stick_fraction[row],
            }
            for row in range(measured.rows)
        ],
        "outliers": [row + 1 for row in fitted.outliers],
        "others": [dict(one) for one in fitted.others],
        "evaluations": fitted.evaluations,
        "units": {
            "frequency": "Hz" if measured.in_hertz else "1",
            "amplitude": "m" if measured.in_metres else "1",
        },
        "study": study_of(fitted),
        "words": [*(told(question.confidence, each) for each in fitted.estimates), *verdict(fitted)],
    }


def study_of(fitted: Fitted | FittedHistory) -> dict[str, Any] | None:
    """Return the definition of a study of the fitted prototype; None if no such study is possible."""
    try:
        return fitted.study()
    except StudyFaults:
        return None


def estimates_document(estimates: Sequence[Estimate], correlation: NDArray[np.float64]) -> Estimates:
    """Return the estimated parameters and their correlations as a document."""
    names = [each.name for each in estimates]
    return {
        "parameters": {
            each.name: {
                "value": each.value,
                "low": each.low,
                "high": each.high,
                "deviation": each.spread,
                "range": [each.lowest, each.highest],
                "determined": each.determined,
            }
            for each in estimates
        },
        "correlation": {
            name: dict(zip(names, row, strict=True))
            for name, row in zip(names, correlation.tolist(), strict=True)
        },
    }


def _heading(name: str) -> str:
    """Return the heading of a parameter. For a length, the unit mm is added."""
    return f"{without_unit(name)} [mm]" if unit_of(name) == "m" else name


def _number(name: str, value: float, digits: int = 4) -> str:
    """Return a value of a parameter as text without a unit. Lengths are converted to millimetres."""
    return f"{1e3 * value if unit_of(name) == 'm' else value:.{digits}g}"


def parameter_rows(estimates: Sequence[Estimate]) -> list[tuple[str, ...]]:
    """Return the parameters as rows of a table with the columns `COLUMNS`."""
    return [
        (
            _heading(each.name),
            *(_number(each.name, value, each.digits) for value in (each.value, each.low, each.high)),
            _number(each.name, each.spread, 2),
            f"{_number(each.name, each.lowest)} to {_number(each.name, each.highest)}",
        )
        for each in estimates
    ]


def study_parts(fitted: Fitted | FittedHistory) -> list[str]:
    """Return the parts of a page that show the study of the fitted prototype; empty if no such study is possible."""
    study = study_of(fitted)
    if study is None:
        return []
    text = json.dumps(study, indent=2, ensure_ascii=False)
    return [
        "<h2>The prototype as a study</h2>",
        f"<pre>{escape(text)}</pre>",
        *map(said, filter(None, [fitted.chosen])),
    ]


def fit_report(fitted: Fitted, curves: "list[FittedCurve]") -> str:
    """Return the report of a fit as a self-contained page of HTML.

    Parameters
    ----------
    fitted : Fitted
        Result of the fit.
    curves : list of FittedCurve
        Computed responses, from `damperlab.worker.fit.model.curves_of`.
    """
    from damperlab.service.figures.fit import caption_of, draw_fit

    measured = fitted.question.measured
    frequency = "frequency [Hz]" if measured.in_hertz else "frequency ratio"
    unit = " [m]" if measured.in_metres else ""
    head = (
        frequency,
        f"measured{unit}",
        f"deviation{unit}",
        f"model{unit}",
        f"model error{unit}",
        "residual",
    )
    columns = (
        measured.frequency,
        measured.amplitude,
        fitted.deviation,
        fitted.model,
        fitted.model_error,
        fitted.residual,
    )
    title = f"{measured.name}, fitted"
    parts = [
        f"<h1>{escape(title)}</h1>",
        *(said(sentence) for sentence in verdict(fitted)),
        "<h2>Parameters</h2>",
        table("Parameters", COLUMNS, parameter_rows(fitted.estimates)),
        said(
            f"Intervals of {100 * fitted.question.confidence:g} %; {fitted.evaluations} sets of parameters computed.",
            "quiet",
        ),
        "<h2>Measured and computed</h2>",
        drawing(draw_fit(fitted, curves), caption_of(fitted.question)),
        table("Rows", head, ([f"{value:.4g}" for value in row] for row in zip(*columns, strict=True))),
        *study_parts(fitted),
    ]
    return page(title, parts)
