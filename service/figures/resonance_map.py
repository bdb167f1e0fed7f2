"""A metric over two dimensions: one cell per grid point, contour lines, and the optimum."""

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.collections import PatchCollection
from matplotlib.colors import BoundaryNorm, LogNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Rectangle
from numpy.typing import NDArray

from damperlab.service.figures.contour_labels import label_places
from damperlab.service.figures.style import (
    COLOURS,
    DARK,
    EMPTY,
    SYMBOLS,
    VERMILION,
    drawn,
    fixed_title,
    is_logarithmic,
    norm_of,
    scale,
    styled,
    ticks_1_2_5,
    title_of,
    unit_behind,
)
from damperlab.studies.amplitudes import AMPLITUDE
from damperlab.studies.ground.variables import RECORD
from damperlab.studies.kinds import SUITE
from damperlab.studies.unit_names import AMPLITUDES
from damperlab.studies.variables import VARIABLES, ResponseClass, Status

_RATIOS = ("amplitude_ratio", "amplitude_ratio_max", "amplitude_ratio_rms", "relative_amplitude_ratio")
SMALLER_IS_BETTER = frozenset(
    (
        *_RATIOS,
        *(AMPLITUDES[name] for name in _RATIOS),
        *(name for name in SUITE.variables if name.startswith(("peak_", "rms_"))),
    )
)
"""Metrics whose map has an optimum."""
MET = frozenset(("frequency_ratio", "frequency_hz", AMPLITUDE, RECORD, "scale", "natural_frequency_hz"))
"""Dimensions that a designer cannot choose. The smallest value along one of these is not an optimum."""
ALIKE = 1e-9
"""Relative difference up to which two values count as equal."""
CONTOUR_POINTS = 8
"""Smallest number of points along each axis for contour lines; lines from fewer points would mislead."""
QUIET = (ResponseClass.LINEAR, ResponseClass.LOCKED, ResponseClass.NO_IMPACT)
"""Classes of responses without impacts."""


def draw_map(answer: xr.Dataset, metric: str) -> Figure:
    """Draw a metric over two dimensions: one cell per grid point, contour lines, and a star at the optimum.

    Parameters
    ----------
    answer : Dataset
        The answer of `damperlab.studies.answers.resonance_map`, dimensions (y, x).
    metric : str
        The variable to draw. Each code of a coded variable has a separate colour.
    """
    answer = drawn(answer)
    values = answer[metric]
    y, x = (answer[name] for name in values.dims)
    status = answer["status"].values
    locked = answer["response_class"].values == ResponseClass.LOCKED if "response_class" in answer else None
    shown = np.ma.masked_invalid(values.values.astype(float))
    with styled({"axes.spines.top": True, "axes.spines.right": True}):
        figure = Figure(figsize=(6.6, 4.9), layout="constrained")
        axes = figure.add_subplot()
        axes.set_facecolor(EMPTY)
        if shown.count():
            _fill(figure, axes, values, shown, x.values, y.values)
        handles: list[Patch | Line2D] = []
        judged = metric in SMALLER_IS_BETTER and answer.attrs.get("reduce") != "min"
        if judged and not MET & set(values.dims):
            handles.extend(_stars(axes, answer, values, x, y, shown))
        hatched = (axes, x.values, y.values)
        if locked is not None and locked.any():
            label = f"locked to the base{_where(answer)}"
            handles.append(_hatch(*hatched, locked, "....", "white", DARK, label))
        failed = status > Status.MAX_CYCLES
        if failed.any():
            handles.append(_hatch(*hatched, failed, "xxxx", "black", EMPTY, "failed"))
        if (status == Status.NOT_COMPUTED).any():
            handles.append(Patch(facecolor=EMPTY, edgecolor="black", linewidth=0.5, label="not computed"))
        scale(axes, "x", x.values)
        scale(axes, "y", y.values)
        axes.set(xlabel=title_of(x), ylabel=title_of(y), title=fixed_title(answer))
        if handles:
            _legend(figure, handles)
    return figure


def _legend(figure: Figure, handles: list[Patch | Line2D]) -> None:
    """Put a legend below the axes, in two columns if they fit into the figure."""
    for columns in (2, 1):
        legend = figure.legend(handles=handles, loc="outside lower center", ncols=columns, handletextpad=0.5)
        if columns == 1 or legend.get_window_extent().width <= figure.bbox.width:
            return
        legend.remove()


def _fill(
    figure: Figure,
    axes: Axes,
    values: xr.DataArray,
    shown: np.ma.MaskedArray[Any, Any],
    x: NDArray[np.float64],
    y: NDArray[np.float64],
) -> None:
    """Colour the cells, and draw the colour scale and, if this scale is logarithmic, contour lines."""
    flags = VARIABLES[str(values.name)].flags if values.name in VARIABLES else None
    if flags is not None:
        codes = [flag.value for flag in flags]
        edges = np.arange(codes[0] - 0.5, codes[-1] + 1.0)
        norm: Normalize = BoundaryNorm(edges, 256)
    else:
        norm = norm_of(shown)
    mesh = axes.pcolormesh(cell_edges(x), cell_edges(y), shown, norm=norm, cmap=COLOURS, rasterized=True)
    bar = figure.colorbar(mesh, ax=axes, pad=0.02, aspect=28)
    bar.set_label(title_of(values))
    if flags is not None:
        bar.set_ticks(codes, labels=[flag.name.lower().replace("_", " ") for flag in flags])
        bar.minorticks_off()
    elif isinstance(norm, LogNorm):
        ticks_1_2_5(bar.ax.yaxis)
        _contours(axes, x, y, shown)


def _stars(
    axes: Axes,
    answer: xr.Dataset,
    values: xr.DataArray,
    x: xr.DataArray,
    y: xr.DataArray,
    shown: np.ma.MaskedArray[Any, Any],
) -> list[Line2D]:
    """Mark the smallest nontrivial value by a star.

    If the response at the optimum has no impacts, a second star marks the smallest value with impacts. If the
    map is reduced over a third dimension, each value has the response class of its extremum.
    """
    kinds = answer["response_class"].values if "response_class" in answer else np.full(shown.shape, -1)
    quiet = np.isin(kinds, QUIET) | ~_weighs(answer, shown)
    stars = []
    acting = f"best that strikes{_where(answer)}" if _where(answer) else "best with impacts"
    rounds = (
        ("optimum", kinds == ResponseClass.LOCKED, VERMILION, "white"),
        (acting, quiet, "white", VERMILION),
    )
    for label, excluded, face, edge in rounds:
        candidates = np.ma.masked_where(excluded, shown)
        if candidates.count() < 2:
            continue
        row, column, where = _place(candidates, x, y)
        star = Line2D(
            [x.values[column]], [y.values[row]], marker="*", ms=15, mfc=face, mec=edge, mew=1.2, ls="none"
        )
        least = f"{shown[row, column]:.4g}{_unit(values)}"
        star.set(label=f"{label}: {least} at {where}", clip_on=False, zorder=5)
        axes.add_line(star)
        stars.append(star)
        if not quiet[row, column]:
            break
    return stars


def _where(answer: xr.Dataset) -> str:
    """Return the end of a label about response classes; empty if the map shows no extrema."""
    words = {"max": " where it is largest", "min": " where it is smallest"}
    return words.get(str(answer.attrs.get("reduce")), "")


def _weighs(answer: xr.Dataset, shown: np.ma.MaskedArray[Any, Any]) -> NDArray[np.bool_]:
    """Return whether the particle has mass at each point; True everywhere if the answer has no mass coordinate."""
    for name in ("mass_ratio", "particle_mass_kg"):
        if name in answer.coords:
            return np.asarray(
                (answer[name] > 0).broadcast_like(answer["status"]).transpose(*answer["status"].dims)
            )
    return np.ones(shown.shape, np.bool_)


def _place(candidates: np.ma.MaskedArray[Any, Any], x: xr.DataArray, y: xr.DataArray) -> tuple[int, int, str]:
    """Return the row, the column and, in words, the coordinates of the smallest value."""
    row, column = (int(index) for index in np.unravel_index(int(candidates.argmin()), candidates.shape))
    across, up = SYMBOLS[str(x.name)], SYMBOLS[str(y.name)]
    at_x, at_y = (
        f"{symbol} = {float(each.values[place]):.4g}{_unit(each)}"
        for symbol, each, place in ((across, x, column), (up, y, row))
    )
    as_good = np.ma.filled(candidates <= candidates[row, column] * (1 + ALIKE), False)
    if as_good[row].all():
        return row, 0, f"{at_y}, any {across}"
    if as_good[:, column].all():
        return 0, column, f"{at_x}, any {up}"
    return row, column, f"{at_x}, {at_y}"


def _unit(array: xr.DataArray) -> str:
    return unit_behind(str(array.attrs.get("units", "1")))


def _contours(
    axes: Axes,
    x: NDArray[np.float64],
    y: NDArray[np.float64],
    values: np.ma.MaskedArray[Any, Any],
) -> None:
    """Draw contour lines at 1, 2, 5, 10, … over cells that are coloured on a logarithmic scale."""
    if min(values.shape) < CONTOUR_POINTS:
        return
    low, high = float(values.min()), float(values.max())
    steps = [factor * 10.0**power for power in range(-12, 13) for factor in (1, 2, 5)]
    levels = [level for level in steps if low < level < high]
    if levels:
        lines = axes.contour(x, y, values, levels=levels, colors="white", linewidths=0.7)
        places = label_places(lines, x, y)
        axes.clabel(lines, fmt=lambda level: f"{level:g}", fontsize=9, manual=places)


def _hatch(
    axes: Axes,
    x: NDArray[np.float64],
    y: NDArray[np.float64],
    where: NDArray[np.bool_],
    pattern: str,
    colour: str,
    face: str,
    label: str,
) -> Patch:
    """Hatch the cells in which `where` is True, and return the entry for the legend."""
    across, down = cell_edges(x), cell_edges(y)
    cells = [
        Rectangle((across[j], down[i]), across[j + 1] - across[j], down[i + 1] - down[i])
        for i, j in np.argwhere(where)
    ]
    axes.add_collection(
        PatchCollection(cells, facecolor="none", edgecolor=colour, hatch=pattern, linewidth=0)
    )
    return Patch(facecolor=face, edgecolor=colour, hatch=pattern, linewidth=0, label=label)


def cell_edges(centres: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the edges of cells around ascending `centres`, half-way between the centres on a linear or log axis."""
    if centres.size == 1:
        return np.array([centres[0] - 0.5, centres[0] + 0.5])
    if is_logarithmic(centres):
        return np.asarray(np.exp(_halfway(np.log(centres))))
    return _halfway(centres)


def _halfway(centres: NDArray[np.float64]) -> NDArray[np.float64]:
    inner = (centres[1:] + centres[:-1]) / 2
    first, last = 2 * centres[0] - inner[0], 2 * centres[-1] - inner[-1]
    return np.concatenate(([first], inner, [last]))
