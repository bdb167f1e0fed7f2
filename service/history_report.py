"""Writes a fit of a time history as a JSON document, and as a page of HTML to store or to print."""

from html import escape
from typing import Annotated, Any

from damperlab.service.fit_report import (
    COLUMNS,
    FitDocument,
    estimates_document,
    parameter_rows,
    study_of,
    study_parts,
)
from damperlab.service.html import drawing, page, said, table
from damperlab.studies.fit.history.fitted import FittedHistory
from damperlab.studies.fit.verdict import told, verdict_of_history
from damperlab.studies.shapes import Count, Number, Numbers, Says


class FittedHistoryDocument(FitDocument):
    """Result of a fit of a time history."""

    stretch_s: Number
    rows_counted: Count
    correlated: Number
    time_s: Numbers
    measured_m: Numbers
    model_m: Numbers
    deviation_m: Numbers
    study: Annotated[
        dict[str, Any] | None,
        Says(
            description="The prototype as a study around its natural frequency; null if the motion of its "
            "base is undetermined."
        ),
    ]


def history_document(fitted: FittedHistory) -> FittedHistoryDocument:
    """Return the result of a fit of a time history as a document."""
    question = fitted.question
    measured = question.measured
    return {
        "measured": measured.name,
        "confidence": question.confidence,
        **estimates_document(fitted.estimates, fitted.correlation),
        "cannot_tell_apart": [list(pair[:2]) for pair in fitted.alike],
        "stretch_s": fitted.stretch_s,
        "rows_counted": fitted.rows,
        "chi_square": fitted.chi_square,
        "degrees_of_freedom": fitted.freedom,
        "probability": fitted.probability,
        "widening": fitted.widening,
        "correlated": fitted.correlated,
        "others": [dict(one) for one in fitted.others],
        "evaluations": fitted.evaluations,
        "time_s": measured.time_s.tolist(),
        "measured_m": measured.displacement_m.tolist(),
        "model_m": fitted.model_m.tolist(),
        "deviation_m": fitted.deviation_m.tolist(),
        "study": study_of(fitted),
        "words": [
            *(told(question.confidence, each) for each in fitted.estimates),
            *verdict_of_history(fitted),
        ],
    }


def history_report(fitted: FittedHistory) -> str:
    """Return the report of a fit of a time history as a self-contained page of HTML."""
    from damperlab.service.figures.history_fit import draw_history_fit

    title = f"{fitted.question.measured.name}, fitted"
    counted = f"Intervals of {100 * fitted.question.confidence:g} %; {fitted.evaluations} histories computed."
    caption = (
        "The measured displacement, the displacement with the estimated parameters, and the residuals in "
        "standard deviations; the shaded part was not used."
    )
    parts = [
        f"<h1>{escape(title)}</h1>",
        *(said(sentence) for sentence in verdict_of_history(fitted)),
        "<h2>Parameters</h2>",
        table("Parameters", COLUMNS, parameter_rows(fitted.estimates)),
        said(counted, "quiet"),
        "<h2>Measured and computed</h2>",
        drawing(draw_history_fit(fitted), caption),
        *study_parts(fitted),
    ]
    return page(title, parts)
