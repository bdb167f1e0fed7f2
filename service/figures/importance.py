"""Shares of a result's variance as bars."""

import xarray as xr
from matplotlib.figure import Figure

from damperlab.service.figures.style import BLUE, GREY, SYMBOLS, styled


def draw_importance(answer: xr.Dataset) -> Figure:
    """Draw what each parameter explains alone, and what combinations do.

    Parameters
    ----------
    answer : Dataset
        Of `damperlab.studies.answers.importance`.
    """
    names = [SYMBOLS.get(str(name), str(name)) for name in answer["dimension"].values]
    shares = [*answer["share"].values, answer.attrs["interactions"]]
    with styled():
        figure = Figure(figsize=(6.0, 0.6 + 0.34 * len(shares)), layout="constrained")
        axes = figure.add_subplot()
        bars = axes.barh([*names, "combinations"], shares, color=[BLUE] * len(names) + [GREY])
        axes.bar_label(bars, [f"{share:.0%}" for share in shares], padding=3)
        axes.invert_yaxis()
        axes.set(xlabel=str(answer["share"].attrs["long_name"]).split(" that ")[0])
        axes.margins(x=0.1)
    return figure
