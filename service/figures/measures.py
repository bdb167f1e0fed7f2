"""Dampers under one ground motion: peak and rms displacement, with the spread over perturbed starts."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from damperlab.service.figures.style import BLUE, GREY, STYLE, VERMILION, styled

SHOWN = (("peak_relative_displacement_m", "Peak"), ("rms_relative_displacement_m", "Rms"))


def draw_measures(answer: xr.Dataset) -> Figure:
    """Draw peak and rms of the displacement relative to the base, one bar per damper.

    Parameters
    ----------
    answer : Dataset
        Answer with the dimension `case` and the two measures [m]. For perturbed starts there are also the variables
        `…_lowest` and `…_highest` of each measure.
    """
    labels = answer["label"].values.tolist()
    colours = [{"none": GREY, "hybrid": VERMILION}.get(case, BLUE) for case in answer["case"].values]
    places = np.arange(len(labels))
    with styled():
        figure = Figure(figsize=(6.6, 1.3 + 0.38 * len(labels)), layout="constrained")
        panels = figure.subplots(1, len(SHOWN), sharey=True)
        for panel, (name, word) in zip(panels, SHOWN, strict=True):
            values = 1e3 * answer[name].values
            panel.barh(places, values, color=colours, height=0.62)
            if f"{name}_lowest" in answer:
                ends = [1e3 * answer[f"{name}_{end}"].values for end in ("lowest", "highest")]
                middle, half = (ends[0] + ends[1]) / 2, (ends[1] - ends[0]) / 2
                panel.errorbar(middle, places, xerr=half, fmt="none", ecolor="black", capsize=3, lw=1)
            panel.set(xlabel=f"{word} of $x - z$ [mm]", xlim=(0, None))
            panel.grid(axis="x", color="#dddddd", lw=0.5)
            panel.set_axisbelow(True)
            panel.tick_params(axis="y", length=0)
        panels[0].set_yticks(places, labels)
        panels[0].set_ylim(len(labels) - 0.4, -0.6)
        figure.suptitle(
            str(answer.attrs["record"]["name"]), x=0.02, ha="left", fontsize=STYLE["axes.titlesize"]
        )
    return figure
