"""The figure of a fit: what was measured, and the response with the estimated parameters."""

import numpy as np
from matplotlib.figure import Figure

from damperlab.service.figures.style import BLUE, GREY, STYLE, VERMILION, styled, ticks_1_2_5
from damperlab.studies.fit.fitted import Fitted
from damperlab.studies.fit.question import FitQuestion
from damperlab.worker.fit.curve import Curve

MILLIMETRES = 1e3
MOST_CURVES = 8
"""Of rows measured at more conditions than these, the first are drawn with a curve."""
LOG_FROM = 10.0


def draw_fit(fitted: Fitted, curves: list[Curve]) -> Figure:
    """Draw measured amplitudes with their standard deviations, the fitted response, and below it what is left.

    Parameters
    ----------
    fitted : Fitted
        The outcome.
    curves : list of Curve
        Of `damperlab.worker.fit.curve.curves_of`; one for each condition.
    """
    question = fitted.question
    measured = question.measured
    scale, unit = (MILLIMETRES, " [mm]") if measured.in_metres else (1.0, "")
    with styled():
        figure = Figure(figsize=(6.6, 5.2), layout="constrained")
        above, below = figure.subplots(2, 1, sharex=True, height_ratios=(3, 1))
        shown = curves[:MOST_CURVES]
        tones = np.linspace(1.0, 0.35, len(shown))
        for tone, curve in zip(tones, shown, strict=True):
            label = _condition(curve) if len(curves) > 1 else "fitted response"
            above.plot(curve.frequency, curve.amplitude * scale, color=BLUE, alpha=tone, lw=1.0, label=label)
        whisker = {"fmt": "o", "ms": 3.2, "color": "black", "ecolor": GREY, "capsize": 1.5, "lw": 0.8}
        above.errorbar(
            measured.frequency,
            measured.amplitude * scale,
            yerr=fitted.deviation * scale,
            label="measured, ± one standard deviation",
            **whisker,
        )
        off = fitted.outliers
        if off:
            above.plot(
                measured.frequency[off],
                measured.amplitude[off] * scale,
                ls="none",
                marker="o",
                ms=8,
                mfc="none",
                color=VERMILION,
                label="outlier",
            )
        if measured.amplitude.max() >= LOG_FROM * measured.amplitude.min():
            above.set_yscale("log")
            ticks_1_2_5(above.yaxis)
        above.set_ylabel(f"Amplitude{unit}" if measured.in_metres else "Amplitude ratio $X/Z$")
        above.legend()
        below.axhspan(-2, 2, color=GREY, alpha=0.2, lw=0)
        below.plot(measured.frequency, fitted.residual, ls="none", marker="o", ms=3.2, color="black")
        below.set_ylabel("Residual [σ]")
        below.set_xlabel("Frequency [Hz]" if measured.in_hertz else "Frequency ratio $r$ = ω/$ω_n$")
        for axes in (above, below):
            axes.grid(color="#dddddd", lw=0.5)
            axes.set_axisbelow(True)
            axes.margins(x=0.02)
        title = ", ".join(f"{each.name} = {each.value:.4g}" for each in fitted.estimates)
        figure.suptitle(title, x=0.02, ha="left", fontsize=STYLE["axes.titlesize"])
    return figure


def caption_of(question: FitQuestion) -> str:
    """Say what the figure shows."""
    return (
        f"The measured amplitudes of {question.measured.name}, the response with the estimated parameters, and what is left "
        "in standard deviations of measurement and model together; the band holds 95 % of them if the model is right."
    )


def _condition(curve: Curve) -> str:
    if not curve.conditions:
        return "fitted response"
    return ", ".join(f"{name} = {value:.4g}" for name, value in curve.conditions.items())
