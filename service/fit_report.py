"""A fit as a document: for programs, and as a page to keep or to print."""

import json
from collections.abc import Sequence
from html import escape
from typing import Any

import numpy as np
from numpy.typing import NDArray

from damperlab.service.html import drawing, page, said, table
from damperlab.studies.fit.fitted import Estimate, Fitted
from damperlab.studies.fit.made import Made
from damperlab.studies.fit.specified import specification_text
from damperlab.studies.fit.verdict import told, verdict
from damperlab.studies.spelling import unit_of
from damperlab.worker.fit.model import FittedCurve

COLUMNS = ("parameter", "value", "low", "high", "deviation", "range")


def fit_document(fitted: Fitted, made: Made) -> dict[str, Any]:
    """Put a fit into a document of plain data: parameters, correlations, goodness, rows, sentences, and what it makes."""
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
        **made_document(made),
        "words": [*(told(question.confidence, each) for each in fitted.estimates), *verdict(fitted)],
    }


def made_document(made: Made) -> dict[str, Any]:
    """Put what a fit makes into a document: study and specification, None where there is none, and words about it."""
    return {
        "study": made.study,
        "specification": None if made.specification is None else made.specification.document,
        "specification_words": list(made.words),
    }


def estimates_document(estimates: Sequence[Estimate], correlation: NDArray[np.float64]) -> dict[str, Any]:
    """Put the parameters and their correlations into a document."""
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
    """Name a parameter at the head of a row, with the unit that its values have there: lengths are in millimetres."""
    return f"{name.removesuffix('_m').replace('_', ' ')} [mm]" if unit_of(name) == "m" else name


def _number(name: str, value: float, digits: int = 4) -> str:
    """Write a value of a parameter without its unit; see `_heading`."""
    return f"{1e3 * value if unit_of(name) == 'm' else value:.{digits}g}"


def parameter_rows(estimates: Sequence[Estimate]) -> list[tuple[str, ...]]:
    """Give the parameters as rows of text, under `COLUMNS`."""
    return [
        (
            _heading(each.name),
            *(_number(each.name, value) for value in (each.value, each.low, each.high)),
            _number(each.name, each.spread, 2),
            f"{_number(each.name, each.lowest)} to {_number(each.name, each.highest)}",
        )
        for each in estimates
    ]


def made_parts(made: Made) -> list[str]:
    """Give the parts of a page that show what a fit makes."""
    parts = []
    if made.study is not None:
        study = json.dumps(made.study, indent=2, ensure_ascii=False)
        parts += ["<h2>The prototype as a study</h2>", f"<pre>{escape(study)}</pre>"]
    parts.append("<h2>The specification of a corrected design</h2>")
    if made.specification is None:
        return [*parts, *(said(sentence) for sentence in made.words)]
    return [*parts, f"<pre>{escape(specification_text(made.specification))}</pre>"]


def fit_report(fitted: Fitted, curves: list[FittedCurve], made: Made) -> str:
    """Write a fit as one page of HTML that loads nothing.

    Parameters
    ----------
    fitted : Fitted
        The outcome.
    curves : list of FittedCurve
        Of `damperlab.worker.fit.model.curves_of`.
    made : Made
        What the fit makes.
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
        *made_parts(made),
    ]
    return page(title, parts)
