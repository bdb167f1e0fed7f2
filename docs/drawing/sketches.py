"""Sketches: the scene of the model, its friction law, and where things run and are kept."""

from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Circle, FancyArrowPatch, FancyBboxPatch, Rectangle

from damperlab.service.figures.style import BLUE, GREY, VERMILION

INK = "#222222"


def _blank(width: float, height: float) -> tuple[Figure, Any]:
    """Give a figure and axes whose unit is a tenth of an inch."""
    figure = Figure(figsize=(width, height))
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set(xlim=(0, width * 10), ylim=(0, height * 10))
    axes.set_axis_off()
    return figure, axes


def _arrow(axes: Any, begin: tuple[float, float], end: tuple[float, float], style: str = "-|>") -> None:
    axes.add_patch(
        FancyArrowPatch(
            begin, end, arrowstyle=style, mutation_scale=10, color=INK, lw=1.0, shrinkA=0, shrinkB=0
        )
    )


def draw_scene() -> Figure:
    """Draw base, spring, dashpot and friction pad, the mass with its cavity, and the particle in it."""
    figure, axes = _blank(6.4, 2.9)
    axes.add_patch(Rectangle((2, 3), 2.4, 22, facecolor="#dddddd", edgecolor=INK, hatch="///", lw=1.0))
    axes.add_patch(Rectangle((2, 2), 52, 1.2, facecolor="#dddddd", edgecolor=INK, hatch="///", lw=1.0))
    spring = np.linspace(4.4, 22, 200)
    axes.plot(spring, 20 + 1.4 * np.sin((spring - 4.4) / 17.6 * 16 * np.pi), color=INK, lw=1.1)
    axes.text(13, 23, "spring $k$", ha="center")
    axes.plot([4.4, 11], [12, 12], color=INK, lw=1.1)
    axes.plot([16, 11, 11, 16], [14, 14, 10, 10], color=INK, lw=1.1)
    axes.plot([14, 14], [10.8, 13.2], color=INK, lw=1.1)
    axes.plot([14, 22], [12, 12], color=INK, lw=1.1)
    axes.text(13, 15.4, "dashpot $c$", ha="center")
    axes.add_patch(Rectangle((22, 6), 30, 18, facecolor="#dfe9f2", edgecolor=BLUE, lw=1.4))
    axes.add_patch(Rectangle((26, 12), 22, 7, facecolor="white", edgecolor=BLUE, lw=1.2))
    axes.add_patch(Circle((37, 15.5), 2.2, facecolor=VERMILION, edgecolor=INK, lw=0.8))
    axes.text(37, 15.2, "$m$", ha="center", va="center", color="white")
    for wall, edge in ((26, 34.8), (48, 39.2)):
        _arrow(axes, (wall, 15.5), (edge, 15.5), "<|-|>")
        axes.text((wall + edge) / 2, 16.6, "$d$", ha="center")
    axes.text(37, 20.8, "structure $M$", ha="center", color=BLUE)
    axes.text(37, 8.4, "particle in its cavity, restitution $e$", ha="center", color=VERMILION)
    axes.add_patch(Rectangle((34, 3.2), 6, 2.8, facecolor=GREY, edgecolor=INK, lw=0.8))
    axes.text(41.2, 4.2, "friction $F_f$", va="center")
    _arrow(axes, (3.2, 26.6), (10, 26.6))
    axes.text(10.6, 26.6, "$z = Z$ sin $ωt$", va="center")
    _arrow(axes, (37, 26.6), (44, 26.6))
    axes.text(44.6, 26.6, "$x$", va="center")
    return figure


def draw_friction() -> Figure:
    """Draw Coulomb's law beside what a mass does that it holds for a while."""
    figure = Figure(figsize=(3.4, 2.4), layout="constrained")
    axes = figure.subplots()
    axes.plot([-1, 0, 0, 1], [-1, -1, 1, 1], color=VERMILION, lw=1.6)
    axes.axhline(0, color=GREY, lw=0.6)
    axes.set(xticks=[0], yticks=[-1, 0, 1], yticklabels=["$-γ_F$", "0", "$γ_F$"], ylim=(-1.5, 1.5))
    axes.set(xlabel="relative velocity $v'$", ylabel="friction over $kZ$")
    axes.annotate("sticking", (0, 0.3), (0.3, 0.3), arrowprops={"arrowstyle": "-|>", "color": INK})
    axes.text(0.35, 1.12, "slipping")
    return figure


def _box(axes: Any, x: float, y: float, words: str, colour: str = BLUE, width: float = 14.0) -> None:
    axes.add_patch(
        FancyBboxPatch(
            (x, y), width, 5.0, boxstyle="round,pad=0.3,rounding_size=0.8", fc="white", ec=colour, lw=1.2
        )
    )
    axes.text(x + width / 2, y + 2.5, words, ha="center", va="center", linespacing=1.15, fontsize=9.5)


def draw_cluster() -> Figure:
    """Draw who talks to whom where several machines compute."""
    figure, axes = _blank(7.0, 2.7)
    _box(axes, 1, 11, "damperlab run\ndamperlab serve")
    _box(axes, 22, 11, "Dask scheduler\ntcp://HOST:8786", GREY)
    for row, y in enumerate((19, 11, 3)):
        _box(axes, 43, y, f"machine {row + 1}\none worker a core", VERMILION)
        _arrow(axes, (36.6, 13.5), (42.5, y + 2.5), "<|-|>")
    _arrow(axes, (15.5, 13.5), (21.5, 13.5), "<|-|>")
    _box(axes, 60.5, 11, "cubes", BLUE, 8)
    for y in (21.5, 13.5, 5.5):
        _arrow(axes, (57.6, y), (60.0, 13.5 if y == 13.5 else 15.0 if y > 13.5 else 12.0))
    axes.text(18.6, 16.4, "blocks", ha="center", va="center", fontsize=9, color=INK)
    axes.text(64.5, 8.6, "shared folder\nor S3", ha="center", va="center", fontsize=9, color=INK)
    _box(axes, 1, 2, "catalogue: SQLite\nor PostgreSQL", BLUE)
    _arrow(axes, (8, 10.5), (8, 7.5), "<|-|>")
    return figure


def draw_stores() -> Figure:
    """Draw the two things that are kept, and where each may be."""
    figure, axes = _blank(7.0, 2.1)
    _box(axes, 1, 8, "damperlab", GREY, 11)
    _box(axes, 22, 13, "catalogue:\nwhat there is", BLUE)
    _box(axes, 22, 3, "cubes:\nthe numbers", VERMILION)
    for y in (15.5, 5.5):
        _arrow(axes, (12.5, 10.5), (21.5, y), "<|-|>")
    for row, (words, y) in enumerate((("SQLite in the data folder", 16.2), ("PostgreSQL", 12.2))):
        axes.text(
            45,
            y + 1,
            words + (" (default)" if row == 0 else ": DAMPERLAB_CATALOGUE"),
            va="center",
            fontsize=9.5,
        )
        _arrow(axes, (36.6, 15.5), (44.3, y + 1))
    for row, (words, y) in enumerate((("Zarr in the data folder", 6.2), ("any S3 bucket", 2.2))):
        axes.text(
            45, y + 1, words + (" (default)" if row == 0 else ": --store s3://…"), va="center", fontsize=9.5
        )
        _arrow(axes, (36.6, 5.5), (44.3, y + 1))
    return figure


def draw_layers() -> Figure:
    """Draw the way of a study through the program: from its definition to an answer."""
    figure, axes = _blank(7.2, 1.5)
    stages = ("study", "plan", "block", "kernel", "cube", "answer")
    colours = (BLUE, BLUE, VERMILION, VERMILION, BLUE, GREY)
    for place, (stage, colour) in enumerate(zip(stages, colours, strict=True)):
        _box(axes, 1 + 12 * place, 5, stage, colour, 8)
        if place:
            _arrow(axes, (1 + 12 * place - 3.5, 7.5), (1 + 12 * place - 0.5, 7.5))
    for x, words in (
        (11, "studies: what is asked"),
        (35, "worker: how it is computed"),
        (60, "service: the doors"),
    ):
        axes.text(x, 2, words, ha="center", fontsize=9.5)
    return figure
