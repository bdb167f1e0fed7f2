"""Figures of frequency responses, ranked designs, errors over run time, and time histories."""

from collections.abc import Mapping

import numpy as np
import xarray as xr
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from damperlab.service.figures.style import (
    BLUE,
    GREY,
    STYLE,
    SYMBOLS,
    VERMILION,
    drawn,
    fixed_title,
    norm_of,
    scale,
    styled,
    ticks_1_2_5,
    title_of,
    told,
)
from damperlab.studies.kinds import EVERY_DIMENSION
from damperlab.studies.variables import Status


def draw_response(answer: xr.Dataset, metric: str) -> Figure:
    """Draw a metric over the frequency ratio, with a band for the error.

    Parameters
    ----------
    answer : Dataset
        The answer of `damperlab.studies.answers.frequency_response`.
    metric : str
        The variable to draw.
    """
    answer = drawn(answer)
    values = answer[metric]
    x = answer[values.dims[0]]
    failed = answer["status"].values > Status.MAX_CYCLES
    error = answer.get("amplitude_error") if metric == "amplitude_ratio" else None
    with styled():
        figure = Figure(figsize=(6.6, 4.2), layout="constrained")
        axes = figure.add_subplot()
        if error is not None:
            band = (values.values - error.values, values.values + error.values)
            axes.fill_between(x.values, *band, color=BLUE, alpha=0.25, lw=0, label="± error")
        axes.plot(x.values, values.values, color=BLUE, marker="o", ms=2.6, label=title_of(values))
        if failed.any():
            axes.plot(
                x.values[failed],
                np.zeros(int(failed.sum())),
                ls="none",
                marker="x",
                color=VERMILION,
                transform=axes.get_xaxis_transform(),
                clip_on=False,
                label="failed",
            )
        shown = np.ma.masked_invalid(values.values)
        if shown.count() and isinstance(norm_of(shown), LogNorm):
            axes.set_yscale("log")
            ticks_1_2_5(axes.yaxis)
        elif (shown == shown.round()).all():  # counts
            axes.yaxis.set_major_locator(MaxNLocator(integer=True))
        scale(axes, "x", x.values)
        axes.grid(color="#dddddd", lw=0.5)
        axes.set_axisbelow(True)
        axes.set(xlabel=title_of(x), ylabel=title_of(values), title=fixed_title(answer))
        axes.margins(x=0.01)
        axes.legend()
    return figure


def draw_compared(answer: xr.Dataset, metric: str, names: tuple[str, str]) -> Figure:
    """Draw a metric of two studies over the frequency ratio. Frequencies at which the studies differ are shaded.

    Parameters
    ----------
    answer : Dataset
        The answer of `damperlab.studies.answers.compared_response`.
    metric : str
        The compared variable.
    names : (str, str)
        Names of the studies.
    """
    answer = drawn(answer)
    x = answer["frequency_ratio"]
    r = x.values
    edges = np.concatenate(([r[0]], (r[1:] + r[:-1]) / 2, [r[-1]]))
    with styled():
        figure = Figure(figsize=(6.6, 4.2), layout="constrained")
        axes = figure.add_subplot()
        for count, (low, high) in enumerate(answer.attrs["apart"]):
            inside = np.flatnonzero((r >= low) & (r <= high))
            span = edges[inside[0]], edges[inside[-1] + 1]
            axes.axvspan(*span, color=GREY, alpha=0.25, lw=0, label=None if count else "they differ")
        for name, variable, error, colour, marker in (
            (names[0], metric, "amplitude_error", BLUE, "o"),
            (names[1], "other", "other_amplitude_error", VERMILION, "x"),
        ):
            values = answer[variable].values
            if metric == "amplitude_ratio" and error in answer:
                doubt = answer[error].values
                axes.fill_between(r, values - doubt, values + doubt, color=colour, alpha=0.25, lw=0)
            axes.plot(r, values, color=colour, marker=marker, ms=2.6, lw=0.9, label=name)
        shown = np.ma.masked_invalid(np.concatenate((answer[metric].values, answer["other"].values)))
        if shown.count() and isinstance(norm_of(shown), LogNorm):
            axes.set_yscale("log")
            ticks_1_2_5(axes.yaxis)
        scale(axes, "x", r)
        axes.grid(color="#dddddd", lw=0.5)
        axes.set_axisbelow(True)
        axes.set(xlabel=title_of(x), ylabel=title_of(answer[metric]), title=fixed_title(answer))
        axes.margins(x=0.01)
        axes.legend()
    return figure


def draw_ranking(answer: xr.Dataset) -> Figure:
    """Draw the values and errors of ranked designs, with the best design on top.

    Parameters
    ----------
    answer : Dataset
        The answer of `optimal_designs` or `worst_case_designs` in `damperlab.studies.answers`.
    """
    answer = drawn(answer)
    count = answer.sizes["rank"]
    columns = {name: answer[name].values for name in EVERY_DIMENSION if name in answer.coords}
    units = {name: str(answer[name].attrs.get("units", "1")) for name in columns}
    vary = [name for name, column in columns.items() if len(set(column.tolist())) > 1]
    names = [", ".join(told(name, columns[name][row], units[name]) for name in vary) for row in range(count)]
    shared = [
        told(name, column[0], units[name]) for name, column in columns.items() if name not in vary and count
    ]
    errors = np.nan_to_num(answer["error"].values) if "error" in answer else None
    with styled():
        figure = Figure(figsize=(6.6, 1.3 + 0.28 * count), layout="constrained")
        axes = figure.add_subplot()
        places = np.arange(count)
        axes.errorbar(
            answer["value"].values, places, xerr=errors, fmt="o", ms=4.5, color=BLUE, capsize=2.5, lw=1
        )
        axes.set_yticks(places, names)
        axes.set_ylim(max(count, 1) - 0.5, -0.5)
        axes.grid(axis="x", color="#dddddd", lw=0.5)
        axes.set_axisbelow(True)
        axes.tick_params(axis="y", length=0)
        axes.spines["left"].set_visible(False)
        axes.set(xlabel=title_of(answer["value"]), title=", ".join(shared))
    return figure


def draw_precision(answer: xr.Dataset) -> Figure:
    """Draw the errors of a study's points against their run times.

    Parameters
    ----------
    answer : Dataset
        The answer of `damperlab.studies.answers.work_precision`.
    """
    time = answer["run_time"]
    floor = 1e-18
    low, middle, high = (
        np.maximum(answer[name].values, floor) for name in ("error_low", "error_median", "error_high")
    )
    with styled():
        figure = Figure(figsize=(6.6, 4.2), layout="constrained")
        axes = figure.add_subplot()
        share = answer["number"].values / max(1, int(answer["number"].sum()))
        axes.vlines(time.values, low, high, color=BLUE, alpha=0.35, lw=3, label="10 to 90 % of the points")
        axes.scatter(
            time.values,
            middle,
            s=12 + 240 * share,
            color=BLUE,
            zorder=3,
            label="median; area: number of points",
        )
        axes.set(xscale="log", yscale="log", xlabel=title_of(time))
        axes.set(ylabel="Error over amplitude ratio", title=answer.attrs["note"])
        axes.grid(color="#dddddd", lw=0.5)
        axes.set_axisbelow(True)
        axes.legend()
    return figure


def draw_history(history: Mapping[str, NDArray[np.float64]], ratios: Mapping[str, float]) -> Figure:
    """Draw a time history: mass and base and, if there is a particle, the distance between mass and particle.

    Parameters
    ----------
    history : mapping of ndarray
        Columns `time` [1/ω_n], `u`, `v`, `p` [Z] of `damperlab.worker.point.Simulation.history`.
    ratios : mapping of float
        The ratios of the simulated point. There is no clearance ratio without a particle.
    """
    clearance = ratios.get("clearance_ratio")
    cycles = history["time"] * ratios["frequency_ratio"] / (2 * np.pi)
    title = ", ".join(f"{symbol} = {ratios[name]:.4g}" for name, symbol in SYMBOLS.items() if name in ratios)
    with styled():
        rows = 1 if clearance is None else 2
        figure = Figure(figsize=(6.6, 2.1 + 1.7 * rows), layout="constrained")
        panels = figure.subplots(rows, 1, sharex=True, squeeze=False)[:, 0]
        panels[0].plot(cycles, history["u"], color=BLUE, lw=0.8, label="mass $x/Z$")
        panels[0].plot(cycles, history["u"] - history["v"], color=GREY, lw=0.8, label="base $z/Z$")
        panels[0].set(ylabel="Displacement over $Z$")
        if clearance is not None:
            gap = history["u"] - history["p"]
            panels[1].plot(cycles, gap, color=VERMILION, lw=0.8, label="mass from particle $(x-y)/Z$")
            for wall in (-clearance, clearance):
                name = "walls" if wall > 0 else None
                panels[1].axhline(wall, color="black", lw=0.8, ls=(0, (4, 3)), label=name)
            panels[1].set(ylabel="Distance over $Z$")
        for panel in panels:
            panel.legend(loc="lower right", bbox_to_anchor=(1.0, 0.98), ncols=2, borderaxespad=0.0)
            panel.margins(x=0.005)
        panels[-1].xaxis.set_major_locator(MaxNLocator(integer=True, min_n_ticks=1))
        panels[-1].set_xlabel("Time in excitation cycles")
        figure.suptitle(title, x=0.02, ha="left", fontsize=STYLE["axes.titlesize"])
    return figure
