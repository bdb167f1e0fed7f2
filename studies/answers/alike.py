"""Make the cubes of two studies comparable, and join the answers about both studies."""

from collections.abc import Iterable
from typing import TYPE_CHECKING

from damperlab.studies.variables import BEFORE, DIMENSION_LONG_NAMES

if TYPE_CHECKING:
    import xarray as xr


def alike(cubes: "Iterable[xr.Dataset]") -> "list[xr.Dataset]":
    """Give all harmonic cubes the same optional leading dimensions, such as friction of the particle.

    Cubes of other kinds stay unchanged. An added dimension has the single value 0.
    """
    every = list(cubes)
    names = [name for name in BEFORE if any(name in cube.sizes for cube in every)]
    return [_with(cube, [name for name in names if name not in cube.sizes]) for cube in every]


def beside(first: "xr.Dataset", second: "xr.Dataset", metric: str, *names: str) -> "xr.Dataset":
    """Add the metric and further variables of a second study to the answer about the first study.

    The metric is added as `other`, and each variable of `names` with the prefix `other_`. The attributes `points`,
    `points_failed` and `complete` of the result cover both studies.
    """
    answer = first.copy()
    for name, source in {"other": metric, **{f"other_{each}": each for each in names}}.items():
        if source in second:
            attributes = dict(second[source].attrs)
            attributes["long_name"] = f"{attributes.get('long_name', source)}, second study"
            answer[name] = (first[metric].dims, second[source].values, attributes)
    for name in ("points", "points_failed"):
        answer.attrs[name] = first.attrs[name] + second.attrs[name]
    answer.attrs["complete"] = (first.attrs["complete"] + second.attrs["complete"]) / 2
    return answer


def _with(cube: "xr.Dataset", names: list[str]) -> "xr.Dataset":
    if not names or "mass_ratio" not in cube.sizes or "clearance_ratio" not in cube.sizes:
        return cube
    found = cube.expand_dims({name: [0.0] for name in names})
    for name, variable in cube.data_vars.items():
        if chunks := variable.encoding.get("chunks"):
            found[name].encoding["chunks"] = (*(1 for _ in names), *chunks)
    for name in names:
        found[name].attrs = {"units": "1", "long_name": DIMENSION_LONG_NAMES[name]}
    found.attrs = dict(cube.attrs)
    return found
