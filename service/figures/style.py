"""The common style of all figures: typeface, colours, scales and names of axes."""

import threading
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.colors import LogNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator
from numpy.typing import NDArray

from damperlab.studies.amplitudes import AMPLITUDE
from damperlab.studies.ground.variables import RECORD
from damperlab.studies.ground.variables import SYMBOLS as SUITE_SYMBOLS
from damperlab.studies.quantity import CAVITY_NAMES
from damperlab.studies.spelling import unit_of
from damperlab.studies.unit_names import COORDINATE_SOURCES, with_what_it_is_over
from damperlab.studies.variables import SYMBOLS as RATIO_SYMBOLS

STYLE: dict[str, Any] = {
    "font.family": "STIXGeneral",
    "mathtext.fontset": "stix",
    "font.size": 10.5,
    "axes.titlesize": 10.5,
    "axes.labelsize": 11.5,
    "axes.linewidth": 0.7,
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "lines.linewidth": 1.1,
    "hatch.linewidth": 0.6,
    "legend.frameon": False,
    "legend.fontsize": 10,
    "svg.fonttype": "none",
    "svg.hashsalt": "damperlab",
    "savefig.dpi": 200,
}
"""Settings of all figures. matplotlib includes the serif typeface, so a figure is the same on every machine."""

COLOURS = "viridis"
"""Colour scale that is uniform in lightness and readable with any colour vision."""
BLUE, VERMILION, GREY = "#0072b2", "#d55e00", "#8c8c8c"
"""Colours of the Okabe-Ito palette, distinguishable with any colour vision; vermilion stands out from viridis."""

MILLIMETRES = 1e3
DARK, EMPTY = "#3b3b6d", "#e6e6e6"
"""Colour behind the hatch of locked points in the legend, and colour of map cells without a value."""

UNITS = {"m s-1": "m/s", "m s-2": "m/s²"} | {
    units: unit_of(name) for name, (_, _, units) in CAVITY_NAMES.items() if units != "1"
}
"""Units as written on an axis, by the units of the CF conventions."""

LOG_FROM = 10.0
"""Ratio of largest to smallest value above which a scale is logarithmic."""


SYMBOLS: dict[str, str] = {
    **{name: f"${symbol}$" for name, symbol in RATIO_SYMBOLS.items()},
    RECORD: "",
    "scale": "scale",
    **{name: f"${symbol}$" for name, symbol in SUITE_SYMBOLS.items()},
    **{name: f"${symbol}$" for name, (_, symbol, _) in CAVITY_NAMES.items()},
    AMPLITUDE: "$Z$",
    "frequency_hz": "$f$",
}
"""Symbols of the dimensions, as in the paper. A ground-motion record has no symbol, because its name is shown."""

_DRAWING = threading.RLock()


@contextmanager
def styled(changes: Mapping[str, Any] | None = None) -> Iterator[None]:
    """Apply the project's style. matplotlib's settings are global, so only one thread draws at a time.

    Parameters
    ----------
    changes : mapping, optional
        Settings of this figure that replace settings of the common style.
    """
    settings: Any = STYLE | dict(changes or {})
    with _DRAWING, rc_context(settings):
        yield


def save(figure: Figure, path: Path) -> None:
    """Write a figure in the format that the suffix of the file gives.

    Parameters
    ----------
    figure : Figure
        The figure.
    path : Path
        The file. No date is written into the file, so the same answer gives the same bytes.
    """
    with styled():
        figure.savefig(path, metadata={"Date": None} if path.suffix == ".svg" else None)


def title_of(array: xr.DataArray) -> str:
    """Return the title of an axis: long name and unit of an array, with symbols typeset as in the paper."""
    name = str(array.attrs.get("long_name", array.name))
    units = str(array.attrs.get("units", "1"))
    if units == "1":
        name = with_what_it_is_over(str(array.name), name)
    for plain, typeset in (
        ("γ_F", "$γ_F$"),
        ("F_f", "$F_f$"),
        ("over Z", "over $Z$"),
        ("ω_n", "$ω_n$"),
        *((symbol, f"${symbol}$") for _, symbol, _ in CAVITY_NAMES.values()),
        ("d/Z", "$d/Z$"),
        ("X/Z", "$X/Z$"),
        ("restitution e", "restitution $e$"),
        ("r = ω/", "$r$ = ω/"),
    ):
        name = name.replace(plain, typeset)
    return name[:1].upper() + name[1:] + ("" if units == "1" else f" [{UNITS.get(units, units)}]")


def told(name: str, value: float | str, units: str = "1") -> str:
    """Return the symbol, the value and the unit of a coordinate for a title."""
    if isinstance(value, str):
        return value
    if units == "m":
        value, units = value * MILLIMETRES, "mm"
    return f"{SYMBOLS.get(name, name)} = {value:.4g}{unit_behind(units)}"


def unit_behind(units: str) -> str:
    """Return a unit with the space that separates it from a number. The text is empty for a ratio."""
    space = "" if units in ("1", "degree", "°") else " "
    return f"{space}{UNITS.get(units, units).strip('1')}"


def fixed_title(answer: xr.Dataset) -> str:
    """Return the title of a slice: the values of the other dimensions, and the reduction over a dimension."""
    in_units = {ratio: name for name, ratio in COORDINATE_SOURCES.items() if name in answer.coords}
    hertz = bool(in_units) and answer.attrs.get("over") == "frequency_ratio"
    here = [
        name for name in SYMBOLS if name in answer.coords and answer[name].ndim == 0 and name not in in_units
    ]
    fixed = ", ".join(
        told(name, answer[name].item(), str(answer[name].attrs.get("units", "1"))) for name in here
    )
    if "over" in answer.attrs:
        over = "frequency_hz" if hertz else answer.attrs["over"]
        fixed += f"; {answer.attrs['reduce']} over {SYMBOLS.get(over) or over}"
    if "worst_over" in answer.attrs:
        worst = answer.attrs["worst_over"]
        fixed += f" of the max over {SYMBOLS.get(worst) or worst}"
    return fixed


def drawn(answer: xr.Dataset) -> xr.Dataset:
    """Convert all lengths of an answer from m to mm."""
    lengths = [str(name) for name, array in answer.variables.items() if array.attrs.get("units") == "m"]
    found = {name: answer[name] * MILLIMETRES for name in lengths}
    scaled = {name: array.variable for name, array in found.items()}
    for name, variable in scaled.items():
        variable.attrs = dict(answer[name].attrs) | {"units": "mm"}
    result = answer.assign_coords({name: one for name, one in scaled.items() if name in answer.coords})
    return result.assign({name: one for name, one in scaled.items() if name in answer.data_vars})


def norm_of(values: np.ma.MaskedArray[Any, Any]) -> Normalize:
    """Return a logarithmic scale if all values are positive and span a decade, otherwise a linear scale."""
    low, high = float(values.min()), float(values.max())
    if low > 0.0 and high >= LOG_FROM * low:
        return LogNorm(low, high)
    return Normalize(low, high)


def ticks_1_2_5(axis: Axis) -> None:
    """Label a logarithmic axis 1, 2, 5, 10, … in plain numbers."""
    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.set_minor_locator(NullLocator())


def is_logarithmic(values: NDArray[np.float64]) -> bool:
    """Whether the logarithms of the values are evenly spaced, and the values span a decade."""
    if values.size < 3 or values[0] <= 0.0 or values[-1] < LOG_FROM * values[0]:
        return False
    steps = np.diff(np.log(values))
    return bool(np.allclose(steps, steps.mean(), rtol=1e-3))


def scale(axes: Axes, which: str, values: NDArray[np.float64]) -> None:
    """Set the scale of an axis, "x" or "y", on which `values` are evenly spaced.

    If there is only one value, the axis has one tick at this value.
    """
    if values.size == 1:
        axes.set(**{f"{which}ticks": values})
    if is_logarithmic(values):
        axes.set(**{f"{which}scale": "log"})
        ticks_1_2_5(axes.xaxis if which == "x" else axes.yaxis)
