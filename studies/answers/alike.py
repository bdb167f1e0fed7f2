"""Make the cubes of two studies comparable, and join the answers about both studies."""

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np

from damperlab.studies.answers.nearness import same
from damperlab.studies.answers.phrases import RATIOS, Phrases
from damperlab.studies.answers.query_fault import refused
from damperlab.studies.faults import counted, listing
from damperlab.studies.variables import BEFORE, DIMENSION_LONG_NAMES

if TYPE_CHECKING:
    import xarray as xr
    from numpy.typing import NDArray


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


def require_equal(
    field: str, both: tuple[Phrases, Phrases], ours: "xr.DataArray", theirs: "xr.DataArray", otherwise: str
) -> None:
    """Raise `QueryFault` if a coordinate has different values in two studies.

    `field` names the second study, and `both` are the phrases of the two studies. `otherwise` is
    advice for a user who has no other study to name.
    """
    one, other = np.atleast_1d(ours.values), np.atleast_1d(theirs.values)
    if one.shape == other.shape and np.all(same(one, other) if one.dtype.kind == "f" else one == other):
        return
    of, had, found = _spans_apart(str(ours.name), both, one, other)
    told = f"The studies differ in {of}: {had} in the first, {found} in the second."
    raise refused(field, found, had, f"name a study with the same {of}, or {otherwise}", told)


def _spans_apart(
    name: str, both: tuple[Phrases, Phrases], ours: "NDArray[Any]", theirs: "NDArray[Any]"
) -> tuple[str, str, str]:
    """Name a dimension, and describe its different values in two studies.

    The values are described by their ends, in units if both studies have units. If the two descriptions are equal,
    the ratios are described, and the value with the largest difference is added to each.
    """
    had = found = ""
    for first, second in (both, (RATIOS, RATIOS)):
        had, found = _spanned(name, ours, first), _spanned(name, theirs, second)
        if first.unit(name) == second.unit(name) and had != found:
            return first.label(name), had, found
    most = int(np.abs(ours - theirs).argmax())
    place = f"(value {most + 1} is"
    return RATIOS.label(name), f"{had} {place} {ours[most]:.16g})", f"{found} {place} {theirs[most]:.16g})"


def _spanned(name: str, values: "NDArray[Any]", phrases: Phrases) -> str:
    """Describe the values of a dimension: the only value, the ends, or the names of records."""
    if values.dtype.kind != "f":
        return counted(values.size, "value") + f" ({listing(values.tolist())})"
    if values.size == 1:
        return phrases.value(name, float(values[0]))
    return f"{values.size} values from {phrases.pair(name, float(values[0]), 'to', float(values[-1]))}"


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
