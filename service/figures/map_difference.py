"""Figure of the maps of two studies with a common colour scale, and of the difference between the maps."""

import numpy as np
import xarray as xr
from matplotlib.colors import LogNorm, Normalize
from matplotlib.figure import Figure

from damperlab.service.figures.resonance_map import cell_edges
from damperlab.service.figures.style import (
    COLOURS,
    EMPTY,
    STYLE,
    drawn,
    fixed_title,
    norm_of,
    scale,
    styled,
    ticks_1_2_5,
    title_of,
    told,
)
from damperlab.studies.answers.map_difference import DIFFERENCE

DIVERGING = "PuOr_r"
"""Colour scale that is white at 0. Purple and orange are distinguishable with any colour vision."""


def draw_difference(answer: xr.Dataset, metric: str, names: tuple[str, str]) -> Figure:
    """Draw two maps on one colour scale, and their difference on a scale that is white at 0.

    Parameters
    ----------
    answer : Dataset
        The answer of `damperlab.studies.answers.map_difference`, dimensions (y, x).
    metric : str
        The mapped variable.
    names : (str, str)
        Names of the studies.
    """
    elsewhere = answer.attrs.get("other_at", {})
    units = {name: str(answer[name].attrs.get("units", "1")) for name in elsewhere}
    own_place = ", ".join(told(name, answer[name].item(), units[name]) for name in elsewhere)
    its_place = ", ".join(told(name, value, units[name]) for name, value in elsewhere.items())
    answer = drawn(answer)
    y, x = (answer[name] for name in answer[metric].dims)
    panels = [np.ma.masked_invalid(answer[name].values.astype(float)) for name in (metric, "other")]
    apart = np.ma.masked_invalid(answer[DIFFERENCE].values)
    both = np.ma.masked_invalid(np.concatenate([panel.compressed() for panel in panels]))
    largest = float(np.abs(apart).max()) if apart.count() else 0.0
    norm = norm_of(both) if both.count() else Normalize(0.0, 1.0)
    titled = (
        (panels[0], "; ".join(filter(None, (names[0], own_place))), norm, COLOURS),
        (panels[1], "; ".join(filter(None, (names[1], its_place))), norm, COLOURS),
        (apart, "The first minus the second", Normalize(-(largest or 1.0), largest or 1.0), DIVERGING),
    )
    with styled({"axes.spines.top": True, "axes.spines.right": True}):
        figure = Figure(figsize=(12.6, 4.6), layout="constrained")
        axes = figure.subplots(1, 3, sharex=True, sharey=True)
        meshes = []
        for panel, (values, title, its_norm, colours) in zip(axes, titled, strict=True):
            panel.set_facecolor(EMPTY)
            meshes.append(
                panel.pcolormesh(
                    cell_edges(x.values),
                    cell_edges(y.values),
                    values,
                    norm=its_norm,
                    cmap=colours,
                    rasterized=True,
                )
            )
            scale(panel, "x", x.values)
            scale(panel, "y", y.values)
            panel.set(title=title, xlabel=title_of(x))
        axes[0].set_ylabel(title_of(y))
        shared = figure.colorbar(meshes[1], ax=axes[:2], pad=0.02, aspect=28)
        shared.set_label(title_of(answer[metric]))
        if isinstance(norm, LogNorm):
            ticks_1_2_5(shared.ax.yaxis)
        own = figure.colorbar(meshes[2], ax=axes[2], pad=0.02, aspect=28)
        own.set_label(title_of(answer[DIFFERENCE].rename(metric)))
        figure.suptitle(fixed_title(answer.drop_vars(list(elsewhere))), fontsize=STYLE["axes.titlesize"])
    return figure
