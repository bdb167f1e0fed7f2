"""Convert the Dataset of an answer into a document, and convert the document back into the same Dataset in a client."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

from damperlab.studies.kinds import EVERY_DIMENSION
from damperlab.studies.variables import VARIABLES, ResponseClass, dimensions_of

if TYPE_CHECKING:
    import numpy as np
    import xarray as xr

    Part = tuple[tuple[str, ...], "np.ndarray[Any, Any]", dict[str, Any]]

ENVELOPE = frozenset(
    ("study", "name", "state", "metric", "units", "long_name", "values", "meanings", "at", "columns")
)
"""Keys of a document that are neither names of columns nor attributes of the answer."""


class Parts(NamedTuple):
    """The parts of a Dataset."""

    data: "dict[str, Part]"
    coordinates: "dict[str, Part]"
    attributes: dict[str, Any]


@dataclass(frozen=True)
class Form:
    """The functions that convert the Dataset of an answer into a document, and back.

    Parameters
    ----------
    write : callable
        Function that makes a document from a Dataset. The document contains `columns`, a description of each column,
        so that a program can rebuild the Dataset.
    read : callable
        Function that makes the parts of the Dataset from a document.
    """

    write: "Callable[[xr.Dataset], dict[str, Any]]"
    read: Callable[[Mapping[str, Any]], Parts]


def metric_of(answer: "xr.Dataset") -> str:
    """Return the name of the metric of an answer, which is its first variable."""
    return str(next(iter(answer.data_vars)))


def columns(answer: "xr.Dataset") -> dict[str, dict[str, Any]]:
    """Return the numpy ``dtype`` and the attributes of every variable and coordinate, by name."""
    return {str(name): {"dtype": array.dtype.str, **array.attrs} for name, array in answer.variables.items()}


def _map(answer: "xr.Dataset") -> dict[str, Any]:
    """Return the entries of `_described`, with ``values`` as [y][x], and the grid values ``x`` and ``y``."""
    y, x = (str(name) for name in answer[metric_of(answer)].dims)
    return {
        "x_dimension": x,
        "y_dimension": y,
        "x": answer[x].values,
        "y": answer[y].values,
        **_described(answer),
    }


def _read_map(document: Mapping[str, Any]) -> Parts:
    x, y = document["x_dimension"], document["y_dimension"]
    arrays = {**document, document["metric"]: document["values"], x: document["x"], y: document["y"]}
    return _parts(document, arrays, (y, x), ("x_dimension", "y_dimension", "x", "y"))


def _curve(answer: "xr.Dataset") -> dict[str, Any]:
    """Return the entries of `_described`, with one value per frequency, and ``frequency_ratio``."""
    return {"frequency_ratio": answer["frequency_ratio"].values, **_described(answer)}


def _read_curve(document: Mapping[str, Any]) -> Parts:
    return _parts(document, {**document, document["metric"]: document["values"]}, ("frequency_ratio",))


def _described(answer: "xr.Dataset") -> dict[str, Any]:
    """Return the metric as ``values``, the accompanying variables, and the fixed coordinates as ``at``."""
    metric = metric_of(answer)
    return {
        "metric": metric,
        "units": answer[metric].attrs.get("units", "1"),
        "long_name": answer[metric].attrs.get("long_name", metric),
        "values": answer[metric].values,
        **{str(name): array.values for name, array in answer.data_vars.items() if name != metric},
        "meanings": _meanings(map(str, answer.data_vars)),
        "at": {str(name): value.item() for name, value in answer.coords.items() if value.ndim == 0},
        "columns": columns(answer),
        **answer.attrs,
    }


def _meanings(names: Any) -> dict[str, dict[str, str]]:
    """Return what each code of a variable means, for all variables that hold codes."""
    return {name: _flags(name) for name in names if name in VARIABLES and VARIABLES[name].flags}


def _flags(name: str) -> dict[str, str]:
    flags = VARIABLES[name].flags
    assert flags is not None
    return {str(flag.value): flag.name.lower() for flag in flags}


def _ranking(answer: "xr.Dataset") -> dict[str, Any]:
    """Return the designs with their coordinates and results, the best design first, and the number of designs."""
    said = {str(name): value for name, value in answer.attrs.items()}
    worst = "metric" in said  # whether the dampers are ranked by their worst case
    first = answer.coords if worst else (*dimensions_of(answer.coords), "value", "error", "response_class")
    names = list(dict.fromkeys(map(str, ("rank", *first, *answer.data_vars))))
    rows = zip(*(answer[name].values.tolist() for name in names), strict=True)
    designs = [dict(zip(names, row, strict=True)) for row in rows]
    classes = _flags("response_class")
    for design in designs:
        if "response_class" in design:
            design["response_class"] = classes[str(design["response_class"])]
    said["designs_total"] = said.pop("designs")
    return {
        "units": answer["value"].attrs["units"] if worst else "1",
        "long_name": answer["value"].attrs["long_name"],
        "designs": designs,
        "columns": columns(answer),
        **said,
    }


def _read_ranking(document: Mapping[str, Any]) -> Parts:
    designs = document["designs"]
    arrays: dict[str, Any] = {name: [design[name] for design in designs] for name in document["columns"]}
    if "response_class" in arrays:
        arrays["response_class"] = [ResponseClass[kind.upper()].value for kind in arrays["response_class"]]
    data, coordinates, attributes = _parts(document, arrays, ("rank",), ("designs", "designs_total"))
    for name in EVERY_DIMENSION:
        if name in data:
            coordinates[name] = data.pop(name)
    return Parts(data, coordinates, {**attributes, "designs": document["designs_total"]})


MAP = Form(_map, _read_map)
"""Form of an answer with one metric over two dimensions."""
CURVE = Form(_curve, _read_curve)
"""Form of an answer with one metric over the frequency ratio."""
RANKING = Form(_ranking, _read_ranking)
"""Form of an answer with designs along ``rank``."""


def along(dimension: str) -> Form:
    """Return the `Form` of an answer with one dimension. Each variable of the answer becomes a list."""

    def write(answer: "xr.Dataset") -> dict[str, Any]:
        names = (dimension, *(str(name) for name in answer.data_vars))
        return {
            **{name: answer[name].values for name in names},
            "columns": columns(answer),
            "at": {str(name): float(value) for name, value in answer.coords.items() if value.ndim == 0},
            "meanings": _meanings(names),
            **answer.attrs,
        }

    return Form(write, lambda document: _parts(document, document, (dimension,)))


def _parts(
    document: Mapping[str, Any],
    arrays: Mapping[str, Any],
    dimensions: tuple[str, ...],
    beside: tuple[str, ...] = (),
) -> Parts:
    """Return the variables, coordinates and attributes of the Dataset that a document describes."""
    found = Parts({}, {}, {})
    for name, described in document["columns"].items():
        attributes = {key: value for key, value in described.items() if key != "dtype"}
        if name in dimensions:
            found.coordinates[name] = ((name,), array_of(arrays[name], described["dtype"]), attributes)
        elif name in document.get("at", {}):
            found.coordinates[name] = ((), array_of(document["at"][name], described["dtype"]), attributes)
        else:
            found.data[name] = (dimensions, array_of(arrays[name], described["dtype"]), attributes)
    ours = {*ENVELOPE, *document["columns"], *beside}
    for name, value in document.items():
        if name not in ours:
            found.attributes[name] = math.nan if value is None else value
    return found


def array_of(values: Any, dtype: str) -> "np.ndarray[Any, Any]":
    """Make an array from a list. JSON has no NaN, but numpy converts null into NaN if `dtype` is a float."""
    import numpy as np

    return np.asarray(values, np.dtype(dtype))
