"""Figures of the answers: resonance map, frequency response, time history, ranked designs. Dataset in, Figure out.

Figures are built from `matplotlib.figure.Figure` alone: no pyplot, no global state, so threads of the service may draw.
"""

from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import LogFormatter, LogLocator, NullLocator
from numpy.typing import NDArray

from studies.variables import ResponseClass, Status

STYLE: dict[str, Any] = {
    "font.family": "STIXGeneral",
    "mathtext.fontset": "stix",
    "font.size": 10,
    "axes.titlesize": 10,
    "axes.labelsize": 11,
    "axes.linewidth": 0.7,
    "xtick.direction": "out",
    "ytick.direction": "out",
    "lines.linewidth": 1.2,
    "legend.fontsize": 9,
    "legend.frameon": False,
    "svg.fonttype": "none",
    "savefig.dpi": 200,
}
"""One look for all figures; the serif face is matplotlib's own, so a figure is the same on every machine."""

COLOURS = "viridis"
"""Even in lightness and readable without colour vision."""

INK = "#1a1a1a"
ACCENT = "#d55e00"
"""Vermilion of the Okabe-Ito palette: stands out from every viridis tone for all kinds of colour vision."""

SYMBOLS = {
    "damping_ratio": "ζ",
    "restitution": "e",
    "mass_ratio": "β",
    "clearance_ratio": "d/Z",
    "friction_ratio": "γ$_F$",
    "frequency_ratio": "r",
}


def axis_title(array: xr.DataArray) -> str:
    """Long name and unit of a coordinate or variable, as an axis carries them."""
    name = str(array.attrs.get("long_name", array.name)).replace("γ_F", "γ$_F$").replace("ω_n", "ω$_n$")
    units = str(array.attrs.get("units", "1"))
    return name[:1].upper() + name[1:] + ("" if units == "1" else f" [{units}]")


def save(figure: Figure, path: Path) -> None:
    """Write a figure in the format of its suffix; no date inside, so that the same answer gives the same file."""
    metadata = {"Date": None} if path.suffix == ".svg" else None
    with rc_context(STYLE):
        figure.savefig(path, metadata=metadata)


def draw_map(
    x: xr.DataArray,
    y: xr.DataArray,
    values: NDArray[np.float64],
    *,
    value_title: str,
    title: str,
    response_class: NDArray[np.int8] | None = None,
    status: NDArray[np.int8] | None = None,
    best: tuple[float, float, float] | None = None,
) -> Figure:
    with rc_context(STYLE):
        figure = Figure(figsize=(6.4, 4.6), layout="constrained")
        axes = figure.add_subplot()
        xs, ys = x.values, y.values
        shown = np.ma.masked_invalid(values)
        norm = _norm(shown)
        mesh = axes.pcolormesh(xs, ys, shown, shading="nearest", norm=norm, cmap=COLOURS, rasterized=True)
        levels = _levels(norm)
        lines = axes.contour(xs, ys, shown, levels=levels, colors="white", linewidths=0.6, alpha=0.85)
        axes.clabel(lines, fmt=lambda v: f"{v:g}", fontsize=8)
        bar = figure.colorbar(mesh, ax=axes, pad=0.02)
        bar.set_label(value_title)
        bar.outline.set_linewidth(0.7)
        if isinstance(norm, LogNorm):
            bar.ax.yaxis.set_major_formatter(LogFormatter(minor_thresholds=(2, 1)))
        axes.set_xlabel(axis_title(x))
        axes.set_ylabel(axis_title(y))
        axes.set_title(title, loc="left")
        if best is not None:
            axes.plot(best[0], best[1], marker="*", ms=15, mfc=ACCENT, mec="white", mew=1, ls="none", clip_on=False, zorder=5, label=f"optimum {best[2]:.3g}")
            figure.legend(loc="outside lower center", ncols=3)
    return figure


def _norm(values):
    low, high = float(values.min()), float(values.max())
    return LogNorm(low, high) if low > 0 and high / low > 10 else Normalize(low, high)


def _levels(norm):
    if isinstance(norm, LogNorm):
        return [k * 10.0**e for e in range(-3, 4) for k in (1, 2, 5) if norm.vmin < k * 10.0**e < norm.vmax]
    return None
