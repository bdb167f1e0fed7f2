"""The leading design of a study, which an answer shows unless the question names another design."""

from collections.abc import Container
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from damperlab.studies.answers.design_question import design_of
from damperlab.studies.answers.nearness import nearest_place
from damperlab.studies.answers.optimal_designs import optimal_designs
from damperlab.studies.answers.selection import NO_LEAD, Lead, choose, in_ratios
from damperlab.studies.answers.suite import worst_cases
from damperlab.studies.field import At
from damperlab.studies.kinds import HARMONIC, kind_of
from damperlab.studies.questions import Judging, Ranking, Selection

if TYPE_CHECKING:
    import xarray as xr


def leading(ranked: "xr.Dataset") -> dict[str, Any] | None:
    """Return the best design of a ranking or, if friction clamps it, the best design with impacts."""
    if ranked.sizes["rank"] == 0:
        return None
    first = {str(name): array.values[0].item() for name, array in ranked.variables.items()}
    acting = ranked.attrs.get("best_with_impacts")
    return dict(acting) if acting and ranked.attrs.get("clamped") else first


def best_at(cube: "xr.Dataset", at: At, free: Container[str] = (), metric: str | None = None) -> Lead:
    """Return the leading design at the grid points nearest to the values in `at`.

    In a suite and in a study over base amplitudes, the conditions of the design's worst case are returned too: scale,
    structure, base amplitude. Record and frequency are not, since answers take the worst value along them.

    Parameters
    ----------
    cube : Dataset
        A study.
    at : mapping of float or str
        Wanted values along dimensions of the cube.
    free : container of str
        Dimensions along which the answer runs.
    metric : str, optional
        The criterion of a suite, or of a study over base amplitudes. The default is the main metric of the study.

    Returns
    -------
    Lead
        Values along the dimensions of the damper and of its conditions. Dimensions with one value, dimensions in `at`,
        and free dimensions are left out. Empty if no design is computed, or if the ratios of a damper vary with the
        frequency, since such dampers are not ranked.
    """
    kind = kind_of(cube.sizes)
    dimensions = design_of(cube.sizes) if kind is HARMONIC else kind.designs
    if not set(dimensions) <= set(cube.sizes):
        return NO_LEAD
    chosen = dimensions
    if kind is not HARMONIC:
        chosen = tuple(name for name in kind.dimensions if name != kind.uncontrolled)
    open_ones = [name for name in chosen if cube.sizes[name] > 1 and name not in at and name not in free]
    if not open_ones:
        return NO_LEAD
    on_grid = {
        name: float(cube[name].values[nearest_place(cube[name].values, float(at[name]))])
        for name in chosen
        if name in at
    }
    judging = Judging(ranges={name: (value, value) for name, value in on_grid.items()})
    if kind is HARMONIC:
        ranked = optimal_designs(cube, judging, 1)
    else:
        ranked = worst_cases(cube, judging, Ranking(top=1, metric=metric))
    found = leading(ranked)
    if found is None:
        return NO_LEAD
    idle = found["value"] != ranked["value"].values[0]
    called = f"best design{' with impacts' if idle else ''}"
    return Lead({name: float(found[name]) for name in open_ones}, called, ranked.attrs["complete"])


def leading_place(
    cube: "xr.Dataset", at: At, free: tuple[str, ...], metric: str | None = None
) -> tuple[dict[str, int], Lead]:
    """Choose a grid point along every dimension that is not free; by default the grid point of the best design.

    Parameters
    ----------
    cube : Dataset
        A study.
    at, free, metric
        As in `selection.choose` and `best_at`.

    Returns
    -------
    dict of int
        Index by dimension.
    Lead
        The values that were taken from the best design.

    Raises
    ------
    QueryFault
        If `selection.choose` refuses the given values.
    """
    chosen = choose(cube, at, free)
    lead = best_at(cube, at, free, metric)
    return (choose(cube, {**lead.at, **at}, free) if lead.at else chosen), lead


def at_its_place(cube: "xr.Dataset", answer: "xr.Dataset", selection: Selection) -> Selection:
    """Return a selection that names the point of an answer, so that a second study is read at the same point."""
    place = {
        str(name): value.item()
        for name, value in answer.coords.items()
        if value.ndim == 0 and cube.sizes.get(name, 1) > 1
    }
    return replace(selection, at={**place, **in_ratios(cube, selection.at)})
