"""The figure of a fit of a time history."""

from matplotlib.figure import Figure

from damperlab.service.figures.fit import title_of
from damperlab.service.figures.style import BLUE, GREY, STYLE, styled
from damperlab.studies.fit.history.fitted import FittedHistory

MILLIMETRES = 1e3


def draw_history_fit(fitted: FittedHistory) -> Figure:
    """Draw the measured and the fitted displacement, and the residuals below. Ignored samples are shaded.

    Parameters
    ----------
    fitted : FittedHistory
        The result of the fit.
    """
    measured = fitted.question.measured
    time = measured.time_s
    with styled():
        figure = Figure(figsize=(6.6, 5.0), layout="constrained")
        above, below = figure.subplots(2, 1, sharex=True, height_ratios=(3, 1))
        above.plot(time, measured.displacement_m * MILLIMETRES, ".", color="black", ms=2.5, label="measured")
        above.plot(time, fitted.model_m * MILLIMETRES, color=BLUE, lw=0.9, label="fitted")
        kind = (
            "Displacement against the base" if measured.relative and not measured.released else "Displacement"
        )
        above.set_ylabel(f"{kind} [mm]")
        residual = (measured.displacement_m - fitted.model_m) / fitted.deviation_m
        below.plot(time[: fitted.rows], residual[: fitted.rows], ".", color="black", ms=2.5)
        below.axhspan(-2, 2, color=GREY, alpha=0.2, lw=0)
        below.set_ylabel("Residual [σ]")
        below.set_xlabel("Time [s]")
        for axes in (above, below):
            if not fitted.whole:
                axes.axvspan(fitted.stretch_s, time[-1], color=GREY, alpha=0.15, lw=0)
            axes.grid(color="#dddddd", lw=0.5)
            axes.set_axisbelow(True)
            axes.margins(x=0.02)
        figure.legend(loc="outside lower center", ncols=2)
        figure.suptitle(title_of(fitted.estimates), x=0.02, ha="left", fontsize=STYLE["axes.titlesize"])
    return figure
