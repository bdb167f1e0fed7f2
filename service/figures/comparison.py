"""Responses with the study's damper and with a tuned mass damper over frequency, drawn like the paper's Figure 14."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from damperlab.service.figures.style import (
    BLUE,
    GREY,
    VERMILION,
    fixed_title,
    scale,
    styled,
    ticks_1_2_5,
    title_of,
)


def draw_comparison(answer: xr.Dataset) -> Figure:
    """Draw the responses with the study's damper, with a tuned mass damper, and without a damper.

    The ranges in which the study's damper is better are shaded, if it is known which damper has the lower peak.

    Parameters
    ----------
    answer : Dataset
        The answer of `damperlab.studies.answers.tmd_comparison`.
    """
    r = answer["frequency_ratio"]
    hybrid = answer["hybrid"].values
    with styled():
        figure = Figure(figsize=(6.6, 4.2), layout="constrained")
        axes = figure.add_subplot()
        better = answer.attrs["hybrid_better"] if answer.attrs["judged"] else ()
        for count, (low, high) in enumerate(better):
            axes.axvspan(
                low, high, color=BLUE, alpha=0.12, lw=0, label=None if count else "study's damper better"
            )
        if "amplitude_error" in answer:
            error = answer["amplitude_error"].values
            axes.fill_between(r.values, hybrid - error, hybrid + error, color=BLUE, alpha=0.25, lw=0)
        exact = {name: np.array(values, dtype=float) for name, values in answer.attrs["exact"].items()}
        axes.plot(exact["frequency_ratio"], exact["no_damper"], color=GREY, lw=0.9, label="no damper")
        mu, detuning = answer.attrs["tmd_mass_ratio"], answer.attrs["detuning"]
        name = f"tuned mass damper, μ = {mu:.4g}, {answer.attrs['criterion']}"
        name += f", {detuning:+.3g} in frequency" if detuning else ""
        axes.plot(exact["frequency_ratio"], exact["tmd"], color=VERMILION, ls=(0, (5, 2)), label=name)
        axes.plot(r.values, hybrid, color=BLUE, marker="o", ms=2.2, label="study's damper")
        axes.set_yscale("log")
        shown = np.concatenate((exact["tmd"], hybrid))
        shown = shown[np.isfinite(shown) & (shown > 0)]
        axes.set_ylim(0.8 * shown.min(), 2.5 * shown.max())
        ticks_1_2_5(axes.yaxis)
        scale(axes, "x", r.values)
        axes.grid(color="#dddddd", lw=0.5)
        axes.set_axisbelow(True)
        units = answer["hybrid"].attrs.get("units", "1")
        amplitude = "Amplitude ratio $X/Z$" if units == "1" else f"Amplitude $X$ [{units}]"
        axes.set(xlabel=title_of(r), ylabel=amplitude, title=fixed_title(answer))
        axes.margins(x=0.01)
        axes.legend()
    return figure
