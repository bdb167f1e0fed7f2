"""The leading design of a study: the one to show first."""

from collections.abc import Container
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from damperlab.studies.amplitudes import AMPLITUDE
from damperlab.studies.answers.design_question import design_of
from damperlab.studies.answers.nearness import nearest_place
from damperlab.studies.answers.optimal_designs import optimal_designs
from damperlab.studies.answers.selection import NO_LEAD, Lead, choose, in_ratios
from damperlab.studies.answers.suite import worst_cases
from damperlab.studies.field import At
from damperlab.studies.kinds import AMPLITUDES, HARMONIC, kind_of
from damperlab.studies.questions import Judging, Selection

if TYPE_CHECKING:
    import xarray as xr


def leading(ranked: "xr.Dataset") -> dict[str, Any] | None:
    """Give the recommended design of a ranking: the best, or the best with impacts if the best clamps the structure."""
    if ranked.sizes["rank"] == 0:
        return None
    first = {str(name): array.values[0].item() for name, array in ranked.variables.items()}
    acting = ranked.attrs.get("best_with_impacts")
    return dict(acting) if acting and ranked.attrs.get("clamped") else first


def best_at(cube: "xr.Dataset", at: At, free: Container[str] = (), metric: str | None = None) -> Lead:
    """Give the leading design at the grid points nearest to the named values; over base amplitudes also its worst one.

    Parameters
    ----------
    cube : Dataset
        A study.
    at : mapping of float or str
        Values of dimensions of the cube.
    free : container of str
        Dimensions along which the answer runs.
    metric : str, optional
        The criterion of a suite, or of a study over base amplitudes; by default its main metric.

    Returns
    -------
    Lead
        The dimensions of the damper that have more than one value and are neither named nor free, and likewise the base
        amplitude. Empty if there is none, if no design is computed, or if the ratios of a damper vary with the
        frequency, since such dampers are not ranked.
    """
    kind = kind_of(cube.sizes)
    dimensions = design_of(cube.sizes) if kind is HARMONIC else kind.designs
    if not set(dimensions) <= set(cube.sizes):
        return NO_LEAD
    chosen = (*dimensions, AMPLITUDE) if kind is AMPLITUDES else dimensions
    open_ones = [name for name in chosen if cube.sizes[name] > 1 and name not in at and name not in free]
    if not open_ones:
        return NO_LEAD
    on_grid = {
        name: float(cube[name].values[nearest_place(cube[name].values, float(at[name]))])
        for name in chosen
        if name in at
    }
    ranges = {name: (value, value) for name, value in on_grid.items()}
    if kind is HARMONIC:
        ranked = optimal_designs(cube, Judging(ranges=ranges), 1)
    else:
        ranked = worst_cases(cube, metric, 1, ranges=ranges)
    found = leading(ranked)
    if found is None:
        return NO_LEAD
    idle = found["value"] != ranked["value"].values[0]
    called = f"best design{' with impacts' if idle else ''}"
    return Lead({name: float(found[name]) for name in open_ones}, called, ranked.attrs["complete"])


def leading_place(
    cube: "xr.Dataset", at: At, free: tuple[str, ...], metric: str | None = None
) -> tuple[dict[str, int], Lead]:
    """Choose a grid point for every dimension that is not free: by default that of the best design.

    Parameters
    ----------
    cube : Dataset
        A study.
    at, free, metric
        As for `selection.choose` and `best_at`.

    Returns
    -------
    dict of int
        Index by dimension.
    Lead
        What was taken from the best design.

    Raises
    ------
    QueryFault
        As `selection.choose`.
    """
    chosen = choose(cube, at, free)
    lead = best_at(cube, at, free, metric)
    return (choose(cube, {**lead.at, **at}, free) if lead.at else chosen), lead


def at_its_place(cube: "xr.Dataset", answer: "xr.Dataset", selection: Selection) -> Selection:
    """Name the point of a cube's answer explicitly, because the best design of a second study may differ."""
    place = {
        str(name): value.item()
        for name, value in answer.coords.items()
        if value.ndim == 0 and cube.sizes.get(name, 1) > 1
    }
    return replace(selection, at={**place, **in_ratios(cube, selection.at)})
