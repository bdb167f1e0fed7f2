"""Work-precision diagrams: error against run time, with one panel per scene and one curve per method."""

from collections.abc import Mapping, Sequence
from math import ceil
from typing import Any

from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter

from damperlab.service.figures.style import BLUE, GREY, VERMILION, styled

COLUMNS = 3
OTHERS = (GREY, "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000", "#7f4f24")
"""Colours of the methods that have a setting, for example a step size. The event-driven methods have no
setting and use the colours `OURS`."""
OURS = (VERMILION, BLUE)
MARKERS = "osD^vPX"


def draw_work_precision(diagrams: Sequence[Mapping[str, Any]]) -> Figure:
    """Draw work–precision diagrams.

    Parameters
    ----------
    diagrams : sequence of mapping
        The entry `diagrams` of a report from `damperlab.worker.accuracy.report`.
    """
    rows = ceil(len(diagrams) / COLUMNS)
    with styled({"font.size": 9.5, "axes.titlesize": 10, "axes.labelsize": 10}):
        figure = Figure(figsize=(9.6, 0.7 + 2.7 * rows), layout="constrained")
        panels = figure.subplots(rows, COLUMNS, sharex=True, sharey=True, squeeze=False).ravel()
        for panel, diagram in zip(panels, diagrams, strict=False):
            ours = others = 0
            for curve in diagram["curves"]:
                points = [point for point in curve["points"] if point["error"] is not None]
                x = [point["microseconds"] for point in points]
                y = [point["error"] for point in points]
                if curve["setting"]:
                    colour, marker, size, line = OTHERS[others % len(OTHERS)], MARKERS[others % 7], 3.5, "-"
                    others += 1
                else:
                    colour, marker, size, line = OURS[ours % 2], "*", 12.0, "none"
                    ours += 1
                label = curve["method"]
                panel.plot(x, y, color=colour, marker=marker, ms=size, ls=line, lw=1.0, label=label)
            panel.set(xscale="log", yscale="log", title=f"{diagram['title']}, {diagram['cycles']} cycles")
            for axis in (panel.xaxis, panel.yaxis):
                axis.set_minor_formatter(NullFormatter())
            panel.yaxis.set_major_locator(LogLocator(numticks=10))
            panel.grid(color="#dddddd", lw=0.5)
            panel.set_axisbelow(True)
        for panel in panels[len(diagrams) :]:
            panel.set_visible(False)
        for panel in panels[max(0, len(diagrams) - COLUMNS) : len(diagrams)]:
            panel.tick_params(labelbottom=True)  # the panel below, with the shared labels, may be hidden
        figure.supxlabel("run time per excitation cycle [µs]", fontsize=10)
        figure.supylabel("relative error of the end state", fontsize=10)
        if diagrams:
            handles, labels = panels[0].get_legend_handles_labels()
            figure.legend(handles, labels, loc="outside upper center", ncols=3, fontsize=9)
    return figure
