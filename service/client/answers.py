"""Answers as xarray Datasets: rebuilt from the service's documents just as `studies.answers` gives them, and drawn."""

import math
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr
from xarray.plot.accessor import DatasetPlotAccessor

from damperlab.service.client.figure import finished
from damperlab.studies.answers.classes import with_words
from damperlab.studies.kinds import EVERY_DIMENSION
from damperlab.studies.variables import ResponseClass

if TYPE_CHECKING:
    from matplotlib.figure import Figure

ENVELOPE = frozenset(
    ("study", "name", "state", "metric", "units", "long_name", "values", "meanings", "at", "columns")
)
"""What stands in a document beside the columns and the attributes of the answer."""


class _Plot(DatasetPlotAccessor):
    """Draws an answer as a whole when it is called; `plot.scatter` and the like are xarray's."""

    def __call__(self, path: str | Path | None = None) -> "Figure":  # type: ignore[override]
        """Draw the answer.

        Parameters
        ----------
        path : path, optional
            Also write the figure there; the suffix says how: .png, .svg, .pdf.

        Returns
        -------
        Figure
            A notebook shows it.
        """
        answer = self._ds
        assert isinstance(answer, Answer)
        return finished(answer._draw(), path)


class Answer(xr.Dataset):
    """A Dataset that knows how it is drawn: ``answer.plot()`` or ``answer.plot("figure.png")``."""

    __slots__ = ()

    @property
    def plot(self) -> _Plot:  # type: ignore[override]
        """Draw the answer as a whole, or parts of it with xarray's own ``plot.scatter`` and others."""
        return _Plot(self)

    def _draw(self) -> "Figure":
        raise NotImplementedError

    @property
    def _metric(self) -> str:
        # every answer of one metric has it in front of what stands beside it
        return str(next(iter(self.data_vars)))


class ResonanceMap(Answer):
    """One metric over two dimensions."""

    __slots__ = ()

    def _draw(self) -> "Figure":
        from damperlab.service.figures.map_difference import draw_difference
        from damperlab.service.figures.resonance_map import draw_map

        if "difference" in self:
            first, second = self.attrs["studies"]
            return draw_difference(self, self._metric, (first, second))
        return draw_map(self, self._metric)


class FrequencyResponse(Answer):
    """One metric over the frequency ratio."""

    __slots__ = ()

    def _draw(self) -> "Figure":
        from damperlab.service.figures.curves import draw_compared, draw_response

        if "differs" in self:
            first, second = self.attrs["studies"]
            return draw_compared(self, self._metric, (first, second))
        return draw_response(self, self._metric)


class Designs(Answer):
    """Designs along ``rank``, the best first."""

    __slots__ = ()

    def _draw(self) -> "Figure":
        from damperlab.service.figures.curves import draw_ranking

        return draw_ranking(self)


class TmdComparison(Answer):
    """A design beside a tuned mass damper over the frequency ratio."""

    __slots__ = ()

    def _draw(self) -> "Figure":
        from damperlab.service.figures.comparison import draw_comparison

        return draw_comparison(self)


class Importance(Answer):
    """Shares of a result's variance along ``dimension``, and the span of the mean."""

    __slots__ = ()

    def _draw(self) -> "Figure":
        from damperlab.service.figures.importance import draw_importance

        return draw_importance(self)


class Fragility(Answer):
    """How likely a damper exceeds a limit along ``scale``."""

    __slots__ = ()

    def _draw(self) -> "Figure":
        from damperlab.service.figures.fragility import draw_fragility

        return draw_fragility(self)


class WorkPrecision(Answer):
    """Error against run time over the points of a study."""

    __slots__ = ()

    def _draw(self) -> "Figure":
        from damperlab.service.figures.curves import draw_precision

        return draw_precision(self)


class DamperComparison(Answer):
    """Dampers along ``case`` under one ground motion."""

    __slots__ = ()

    def _draw(self) -> "Figure":
        from damperlab.service.figures.measures import draw_measures

        return draw_measures(self)


def read_map(document: Mapping[str, Any]) -> ResonanceMap:
    """Rebuild a map, dimensions (y, x); see `damperlab.studies.answers.resonance_map`."""
    x, y = document["x_dimension"], document["y_dimension"]
    arrays = {**document, document["metric"]: document["values"], x: document["x"], y: document["y"]}
    parts = _parts(document, arrays, (y, x), ("x_dimension", "y_dimension", "x", "y"))
    return with_words(ResonanceMap(*parts))


def read_response(document: Mapping[str, Any]) -> FrequencyResponse:
    """Rebuild a frequency response; see `damperlab.studies.answers.frequency_response`."""
    arrays = {**document, document["metric"]: document["values"]}
    return with_words(FrequencyResponse(*_parts(document, arrays, ("frequency_ratio",))))


def read_designs(document: Mapping[str, Any]) -> Designs:
    """Rebuild ranked designs; see `studies.answers.optimal_designs`, of a suite `studies.answers.suite`."""
    designs = document["designs"]
    arrays: dict[str, Any] = {name: [design[name] for design in designs] for name in document["columns"]}
    if "response_class" in arrays:
        arrays["response_class"] = [ResponseClass[kind.upper()].value for kind in arrays["response_class"]]
    data, coordinates, attributes = _parts(document, arrays, ("rank",), ("designs", "designs_total"))
    for name in EVERY_DIMENSION:
        if name in data:
            coordinates[name] = data.pop(name)
    return with_words(Designs(data, coordinates, {**attributes, "designs": document["designs_total"]}))


def read_tmd(document: Mapping[str, Any]) -> TmdComparison:
    """Rebuild a comparison with a tuned mass damper; see `damperlab.studies.answers.tmd_comparison`."""
    return with_words(TmdComparison(*_parts(document, document, ("frequency_ratio",))))


def read_importance(document: Mapping[str, Any]) -> Importance:
    """Rebuild shares of variance; see `damperlab.studies.answers.importance`."""
    return Importance(*_parts(document, document, ("dimension",)))


def read_fragility(document: Mapping[str, Any]) -> Fragility:
    """Rebuild a fragility curve; see `damperlab.studies.answers.fragility`."""
    return Fragility(*_parts(document, document, ("scale",)))


def read_precision(document: Mapping[str, Any]) -> WorkPrecision:
    """Rebuild error against run time; see `damperlab.studies.answers.work_precision`."""
    return WorkPrecision(*_parts(document, document, ("run_time",)))


HISTORY = {
    "time": ("time", "1/ω_n"),
    "u": ("displacement of the mass", "Z"),
    "u_rate": ("velocity of the mass", "Z·ω_n"),
    "v": ("displacement of the mass from its base", "Z"),
    "v_rate": ("velocity of the mass against its base", "Z·ω_n"),
    "p": ("displacement of the particle", "Z"),
    "p_rate": ("velocity of the particle", "Z·ω_n"),
    "impact": ("1 where an impact ends", "1"),
}
"""Columns of a time history: what they are, and their unit."""


def read_history(columns: Mapping[str, Any]) -> xr.Dataset:
    """Put the columns of a time history into a Dataset over ``time``; empty where there are none."""
    arrays = {
        name: (
            ("time",),
            _array(values, {"dtype": "f8"}),
            dict(zip(("long_name", "units"), HISTORY.get(name, (name, "1")), strict=True)),
        )
        for name, values in columns.items()
    }
    return xr.Dataset(arrays).set_coords("time") if arrays else xr.Dataset()


_Part = tuple[tuple[str, ...], np.ndarray, dict[str, Any]]


def _parts(
    document: Mapping[str, Any],
    arrays: Mapping[str, Any],
    dimensions: tuple[str, ...],
    beside: tuple[str, ...] = (),
) -> tuple[dict[str, _Part], dict[str, _Part], dict[str, Any]]:
    """Give variables, coordinates and attributes of a Dataset."""
    data: dict[str, _Part] = {}
    coordinates: dict[str, _Part] = {}
    for name, described in document["columns"].items():
        attributes = {key: value for key, value in described.items() if key != "dtype"}
        if name in dimensions:
            coordinates[name] = ((name,), _array(arrays[name], described), attributes)
        elif name in document.get("at", {}):
            coordinates[name] = ((), _array(document["at"][name], described), attributes)
        else:
            data[name] = (dimensions, _array(arrays[name], described), attributes)
    ours = {*ENVELOPE, *document["columns"], *beside}
    said = {name: _number(value) for name, value in document.items() if name not in ours}
    return data, coordinates, said


def _array(values: Any, described: Mapping[str, Any]) -> np.ndarray:
    # JSON has no NaN, and numpy takes null for it where the type is a float's
    return np.asarray(values, np.dtype(described["dtype"]))


def _number(value: Any) -> Any:
    return math.nan if value is None else value
