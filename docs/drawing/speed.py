"""The table of speeds in `docs/accuracy.md`, drawn: the page is the only place where its numbers are written."""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from damperlab.service.figures.style import BLUE, GREY, VERMILION, ticks_1_2_5

PAGE = Path(__file__).parents[1] / "accuracy.md"


def speeds() -> dict[str, list[float]]:
    """Read microseconds per cycle by scene: the integration alone, with peaks, with energies, and the paper's method."""
    table = PAGE.read_text().split("paper's method |\n")[1].partition("\n\n")[0]
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in table.splitlines()[1:]]
    return {name.split(" (")[0]: [float(value) for value in values] for name, *values in rows}


def draw_speed() -> Figure:
    """Draw the table as points on a logarithmic scale, a line for each scene."""
    found = speeds()
    values = np.array(list(found.values()))[::-1]
    figure = Figure(figsize=(7.0, 0.5 + 0.32 * len(found)), layout="constrained")
    axes = figure.subplots()
    rows = np.arange(len(found))
    axes.hlines(rows, values.min(axis=1), values.max(axis=1), color="#dddddd", lw=1.0)
    names = ("integration alone", "with peaks", "and energies", "paper's method")
    for column, (name, colour) in enumerate(zip(names, (BLUE, "#56b4e9", VERMILION, GREY), strict=True)):
        axes.plot(values[:, column], rows, "o", ms=5, color=colour, label=name)
    axes.set(
        xscale="log", yticks=rows, yticklabels=list(found)[::-1], xlabel="Microseconds per excitation cycle"
    )
    ticks_1_2_5(axes.xaxis)
    # over the names of the scenes too: four entries are wider than the axes
    axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=4, borderaxespad=0.0, columnspacing=1.0)
    return figure
