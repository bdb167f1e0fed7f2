"""Cubes of one set of dimensions: a study that says nothing of the particle's friction, or of gravity, has 0 of it."""

from collections.abc import Iterable

import xarray as xr

from damperlab.studies.variables import BEFORE, DIMENSION_LONG_NAMES


def alike(cubes: Iterable[xr.Dataset]) -> list[xr.Dataset]:
    """Give harmonic cubes the dimensions that any of them has before the others; cubes of other kinds as they are."""
    every = list(cubes)
    names = [name for name in BEFORE if any(name in cube.sizes for cube in every)]
    return [_with(cube, [name for name in names if name not in cube.sizes]) for cube in every]


def _with(cube: xr.Dataset, names: list[str]) -> xr.Dataset:
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
