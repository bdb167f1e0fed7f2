"""Figures of the paper, drawn in this project's style."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from damperlab.service.figures.style import BLUE, GREY, VERMILION, styled, ticks_1_2_5

COLOURS = (BLUE, VERMILION, "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000", "#7f4f24", GREY)
"""Colours of the Okabe-Ito palette, in the order of the curves."""
FREQUENCY, AMPLITUDE = "Frequency ratio $r$", "Amplitude ratio $X/Z$"
DASHED = (0, (5, 2))


def draw_responses(panels: Sequence[Mapping[str, Any]]) -> Figure:
    """Draw frequency responses, one panel per clearance, one curve per contact model (Figure 7).

    Parameters
    ----------
    panels : sequence of mapping
        Each panel has a `title`, `curves` (frequencies, values and errors of each curve, by name) and a `level` (the
        value in the paper).
    """
    with styled():
        figure = Figure(figsize=(8.4, 3.9), layout="constrained")
        for axes, panel in zip(figure.subplots(1, len(panels), sharey=True), panels, strict=True):
            for colour, (name, (r, values, error)) in zip(COLOURS, panel["curves"].items(), strict=False):
                axes.fill_between(r, values - error, values + error, color=colour, alpha=0.2, lw=0)
                axes.plot(r, values, color=colour, lw=1.0, label=name)
            axes.axhline(panel["level"], color="black", lw=0.8, ls=DASHED, label="paper, Table 3")
            axes.set(title=panel["title"], xlabel=FREQUENCY)
            _logarithmic(axes)
        figure.axes[0].set_ylabel(AMPLITUDE)
        _legend(figure, 4)
    return figure


def draw_histories(histories: Mapping[tuple[float, float], Mapping[str, NDArray[np.float64]]]) -> Figure:
    """Draw displacement over time, one row per clearance, one column per restitution (Figure 8).

    Parameters
    ----------
    histories : mapping
        For each clearance ratio and restitution, the columns `time` and `u` of a simulation at r = 1.
    """
    rows = sorted({ratio for ratio, _ in histories})
    columns = sorted({e for _, e in histories})
    with styled():
        figure = Figure(figsize=(8.4, 5.4), layout="constrained")
        panels = figure.subplots(len(rows), len(columns), sharex=True, sharey="row", squeeze=False)
        for line, ratio in zip(panels, rows, strict=True):
            for axes, colour, e in zip(line, COLOURS, columns, strict=False):
                history = histories[ratio, e]
                axes.plot(history["time"] / (2 * np.pi), history["u"], color=colour, lw=0.6)
                axes.set_title(f"$d/Z$ = {ratio:g}, $e$ = {e:g}")
                axes.margins(x=0.01)
            line[0].set_ylabel("$x/Z$")
        for axes in panels[-1]:
            axes.set_xlabel("Time in excitation cycles")
    return figure


def draw_finite_time(
    r: NDArray[np.float64],
    friction: NDArray[np.float64],
    steady: NDArray[np.float64],
    finite: NDArray[np.float64],
    cycles: int,
) -> Figure:
    """Draw frequency responses with friction alone, in steady state and in the first cycles from rest (Figure 9).

    Parameters
    ----------
    r, friction : ndarray, shapes (frequencies,) and (ratios,)
        Frequency ratios and friction ratios.
    steady, finite : ndarray, shape (ratios, frequencies)
        Amplitude ratio X/Z in steady state, and largest |x|/Z in the first `cycles` cycles.
    cycles : int
        Number of cycles from rest.
    """
    with styled():
        figure = Figure(figsize=(8.4, 4.2), layout="constrained")
        panels = figure.subplots(1, 2, sharey=True)
        titles = ("steady", f"largest peak in {cycles} cycles from rest")
        for axes, values, title in zip(panels, (steady, finite), titles, strict=True):
            for colour, ratio, curve in zip(COLOURS, friction, values, strict=False):
                axes.plot(r, curve, color=colour, lw=1.0, label=f"$γ_F$ = {ratio:.2g}")
            axes.set(title=title, xlabel=FREQUENCY)
            _logarithmic(axes)
        panels[0].set_ylabel(AMPLITUDE)
        _legend(figure, 5)
    return figure


def draw_friction_law(
    friction: NDArray[np.float64], curves: Mapping[str, Sequence[float]], levels: Mapping[str, float]
) -> Figure:
    """Draw X/Z at r = 1 over the friction ratio, with the paper's measured peaks (Figures 9 and 10)."""
    with styled():
        figure = Figure(figsize=(6.6, 4.0), layout="constrained")
        axes = figure.add_subplot()
        for colour, (name, values) in zip(COLOURS, curves.items(), strict=False):
            axes.plot(friction, values, color=colour, label=name)
        for place, (name, level) in enumerate(levels.items()):
            axes.axhline(level, color="black", lw=0.8, ls=(DASHED, (0, (1, 2)))[place % 2], label=f"paper, {name}")  # fmt: skip
        axes.axvline(np.pi / 4, color=GREY, lw=0.8)
        axes.annotate("π/4", (np.pi / 4, 0.97), xycoords=("data", "axes fraction"), xytext=(3, 0),
                      textcoords="offset points", va="top")  # fmt: skip
        axes.set(xlabel="Friction ratio $γ_F$", ylabel=f"{AMPLITUDE} at $r$ = 1")
        _logarithmic(axes)
        axes.legend()
    return figure


def draw_beside_tuned_mass(
    lam: NDArray[np.float64],
    absorbers: Mapping[str, NDArray[np.float64]],
    without: NDArray[np.float64],
    hybrids: Mapping[str, tuple[NDArray[np.float64], NDArray[np.float64]]],
) -> Figure:
    """Draw responses with the hybrid damper at several friction ratios, and with tuned mass dampers (Figure 14)."""
    with styled():
        figure = Figure(figsize=(6.6, 4.6), layout="constrained")
        axes = figure.add_subplot()
        axes.plot(lam, without, color=GREY, lw=0.9, label="no damper")
        for line, (name, values) in zip((DASHED, "-."), absorbers.items(), strict=False):
            axes.plot(lam, values, color="black", ls=line, label=name)
        for colour, (name, (r, values)) in zip(COLOURS, hybrids.items(), strict=False):
            axes.plot(r, values, color=colour, lw=1.0, label=name)
        axes.set(xlabel=FREQUENCY, ylabel=AMPLITUDE)
        _logarithmic(axes)
        axes.set_ylim(0.4, 60)
        axes.legend(ncols=2, loc="upper left")
    return figure


def draw_numbers(
    names: Sequence[str], measured: Sequence[float], computed: Mapping[str, Sequence[float]]
) -> Figure:
    """Draw amplitude ratios of several cases, measured and computed, side by side (Table 3).

    Parameters
    ----------
    names : sequence of str
        Names of the cases.
    measured : sequence of float
        X/Z as printed in the paper, one value per case.
    computed : mapping
        Computed X/Z for each assumption, one value per case.
    """
    with styled():
        figure = Figure(figsize=(8.4, 3.6), layout="constrained")
        axes = figure.subplots()
        place = np.arange(len(names))
        axes.plot(place, measured, color="black", marker="_", ms=26, mew=2, ls="", label="paper, Table 3")
        for colour, marker, (name, values) in zip(COLOURS, "os", computed.items(), strict=False):
            axes.plot(place, values, color=colour, marker=marker, ms=6, ls="", label=name)
        axes.set_xticks(place, names)
        axes.set_ylabel(AMPLITUDE)
        _logarithmic(axes)
        axes.margins(x=0.06)
        _legend(figure, 3)
    return figure


def _logarithmic(axes: Axes) -> None:
    axes.set_yscale("log")
    ticks_1_2_5(axes.yaxis)
    axes.grid(color="#dddddd", lw=0.5)
    axes.set_axisbelow(True)
    axes.margins(x=0.01)


def _legend(figure: Figure, columns: int) -> None:
    handles, labels = figure.axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=columns)
