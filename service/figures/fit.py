"""The figure of a fit: the measurement, and the response with the estimated parameters."""

from collections.abc import Iterable, Mapping

import numpy as np
from matplotlib import colormaps
from matplotlib.figure import Figure

from damperlab.service.figures.style import (
    BLUE,
    COLOURS,
    GREY,
    LOG_FROM,
    STYLE,
    VERMILION,
    styled,
    ticks_1_2_5,
    told,
)
from damperlab.studies.fit.fitted import Estimate, Fitted
from damperlab.studies.fit.question import RATIO_OF, FitQuestion
from damperlab.studies.spelling import unit_of
from damperlab.studies.vocabulary import OF_PARTICLE
from damperlab.worker.fit.model import FittedCurve

MILLIMETRES = 1e3
_ALSO = {"mass_kg": "$M$", "damping_n_s_per_m": "$c$"}
"""Symbols of quantities that no study varies."""
MOST_NAMED = 8
"""Largest number of conditions in the legend. If there are more conditions, the legend shows the first."""
TONES = colormaps[COLOURS].resampled(256)
FEW = (BLUE, VERMILION, "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "black", GREY)
"""Colours of up to eight conditions, from the Okabe-Ito palette: distinguishable with any colour vision."""
MASSES = ("mass_ratio", "particle_mass_kg")


def draw_fit(fitted: Fitted, curves: list[FittedCurve]) -> Figure:
    """Draw measured amplitudes with their standard deviations, the fitted response, and the residuals below.

    Parameters
    ----------
    fitted : Fitted
        The result of the fit.
    curves : list of FittedCurve
        The curves from `damperlab.worker.fit.model.curves_of`, one for each condition.
    """
    question = fitted.question
    measured = question.measured
    scale, unit = (MILLIMETRES, " [mm]") if measured.in_metres else (1.0, "")
    with styled():
        figure = Figure(figsize=(6.6, 5.6), layout="constrained")
        above, below = figure.subplots(2, 1, sharex=True, height_ratios=(3, 1))
        several = len(curves) > 1
        for index, (curve, (conditions, rows)) in enumerate(
            zip(curves, question.configurations, strict=True)
        ):
            colour = FEW[index] if len(curves) <= len(FEW) else TONES(0.9 * index / (len(curves) - 1))
            label = _condition(conditions) if index < MOST_NAMED else None
            above.plot(curve.frequency, curve.amplitude * scale, color=colour, lw=0.9, label=label)
            for axes, heights, deviation in (
                (above, measured.amplitude[rows] * scale, fitted.deviation[rows] * scale),
                (below, fitted.residual[rows], None),
            ):
                axes.errorbar(
                    measured.frequency[rows],
                    heights,
                    yerr=deviation,
                    fmt="o",
                    ms=3.2,
                    color=colour if several else "black",
                    ecolor=GREY,
                    capsize=1.5,
                    lw=0.8,
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
        drawn = np.concatenate([measured.amplitude, *(curve.amplitude for curve in curves)])
        if np.nanmax(drawn) >= LOG_FROM * np.nanmin(drawn):
            above.set_yscale("log")
            ticks_1_2_5(above.yaxis)
        above.set_ylabel(f"Amplitude{unit}" if measured.in_metres else "Amplitude ratio $X/Z$")
        figure.legend(loc="outside lower center", ncols=2 if several else 3)
        below.axhspan(-2, 2, color=GREY, alpha=0.2, lw=0)
        below.set_ylabel("Residual [σ]")
        below.set_xlabel("Frequency [Hz]" if measured.in_hertz else "Frequency ratio $r$ = ω/$ω_n$")
        for axes in (above, below):
            axes.grid(color="#dddddd", lw=0.5)
            axes.set_axisbelow(True)
            axes.margins(x=0.02)
        figure.suptitle(title_of(fitted.estimates), x=0.02, ha="left", fontsize=STYLE["axes.titlesize"])
    return figure


def title_of(estimates: Iterable[Estimate]) -> str:
    """Return the symbols and the values of the parameters, with lengths in mm."""
    return ", ".join(_equal(each.name, each.value) for each in estimates)


def caption_of(question: FitQuestion) -> str:
    """Return the caption of the figure."""
    return (
        f"The measured amplitudes of {question.measured.name}, the response with the estimated parameters, "
        "and the residuals in combined standard deviations of measurement and model. If the model is right, "
        "the band contains 95 % of the residuals."
    )


def _condition(conditions: Mapping[str, float]) -> str:
    """Write the conditions of a group of rows. Conditions of the cavity are left out if there is no particle."""
    if not conditions:
        return "fitted response; measured: dots, ± one standard deviation"
    alone = any(conditions.get(name) == 0.0 for name in MASSES)
    return ", ".join(
        _equal(name, value)
        for name, value in conditions.items()
        if not (alone and RATIO_OF.get(name, name) in OF_PARTICLE and name not in MASSES)
    )


def _equal(name: str, value: float) -> str:
    return told(_ALSO.get(name, name), value, unit_of(name) or "1")
