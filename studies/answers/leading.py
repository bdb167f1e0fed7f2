"""The design that a study leads to: the one to look at first."""

from typing import Any

import xarray as xr

from damperlab.studies.answers.design_question import DESIGN
from damperlab.studies.answers.nearness import nearest_place
from damperlab.studies.answers.optimal_designs import optimal_designs
from damperlab.studies.field import At
from damperlab.studies.questions import Judging


def leading(ranked: xr.Dataset) -> dict[str, Any] | None:
    """Give the design that a ranking leads to: the best whose damper does something, as the page and the verdict have it."""
    if ranked.sizes["rank"] == 0:
        return None
    first = {str(name): array.values[0].item() for name, array in ranked.variables.items()}
    acting = ranked.attrs.get("best_with_impacts")
    return dict(acting) if acting and first["impact_share"] == 0 else first


def best_at(cube: xr.Dataset, at: At) -> tuple[dict[str, float], str]:
    """Give what leads among the designs at the grid points nearest to what is named.

    Parameters
    ----------
    cube : Dataset
        A study of the response to a harmonic base.
    at : mapping of float
        Values of design dimensions, in ratios.

    Returns
    -------
    dict of float
        The dimensions of more than one value that are not named; empty where there is none, where no design is computed, and
        for a study whose ratios are others at each frequency, whose dampers are not ranked by them.
    str
        What the design is called.
    """
    if not set(DESIGN) <= set(cube.sizes):
        return {}, ""
    open_ones = [name for name in DESIGN if cube.sizes[name] > 1 and name not in at]
    if not open_ones:
        return {}, ""
    on_grid = {
        name: float(cube[name].values[nearest_place(cube[name].values, float(at[name]))])
        for name in DESIGN
        if name in at
    }
    ranges = {name: (value, value) for name, value in on_grid.items()}
    ranked = optimal_designs(cube, Judging(ranges=ranges), 1)
    found = leading(ranked)
    if found is None:
        return {}, ""
    idle = found["value"] != ranked["value"].values[0]
    return {name: float(found[name]) for name in open_ones}, f"best design{' with impacts' if idle else ''}"
