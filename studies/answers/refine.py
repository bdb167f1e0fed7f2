"""Refinement: a follow-up study around an optimum or a class boundary, so that it is known without a fine grid."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import xarray as xr

from damperlab.studies.answers.design_question import DESIGN, FREQUENCY, DesignQuestion
from damperlab.studies.answers.faults import QueryFault
from damperlab.studies.answers.merged import merged_designs
from damperlab.studies.answers.selection import check_dimension, choose, require_stored
from damperlab.studies.definition import MAX_NAME, Study, parse_harmonic
from damperlab.studies.faults import Fault, counted, describe
from damperlab.studies.variables import DIMENSIONS, ResponseClass, Status

TOLERANCE = 1e-3
"""Step at which a parameter counts as known."""
FINEST = 1e-9
PARTS = {1: 8, 2: 4}
"""Into how many parts a step is cut, by the number of parameters that are refined; 2 for more of them."""
BOUNDARY_PARTS = 16
ROUNDING = 1e-9


@dataclass(frozen=True)
class Refinement:
    """What to compute next, if anything.

    Parameters
    ----------
    study : Study or None
        The follow-up, to be submitted like any other; None once everything is known to the tolerance.
    found : dict
        The optimum (coordinates, `value`, `error`) or the boundary (`low`, `high`, their classes) so far.
    steps : dict of float
        By parameter, the distance to the farther of the neighbours between which it lies.
    points : int
        Of the follow-up, 0 without one.
    fine_points : int
        Of a grid with steps of the tolerance over the whole of the refined axes.
    note : str
        The same in words.
    """

    study: Study | None
    found: dict[str, Any]
    steps: dict[str, float] = field(default_factory=dict)
    points: int = 0
    fine_points: int = 0
    note: str = ""


def refine_optimum(
    study: Study,
    cubes: Mapping[str, xr.Dataset],
    tolerance: float = TOLERANCE,
    objective: str | None = None,
    band: tuple[float, float] | None = None,
    exclude_locked: bool = False,
    max_impact_speed: float | None = None,
    ranges: Mapping[str, tuple[float, float]] | None = None,
) -> Refinement:
    """Make the study that searches between the best design and its neighbours.

    Parameters
    ----------
    study : Study
        The study that is refined.
    cubes : mapping of Dataset
        Its cube first, then those of the follow-ups that are done, by id.
    tolerance : float
        Step to which each parameter shall be known, in the parameter's own unit.
    objective, band, exclude_locked, max_impact_speed, ranges
        As in `optimal_designs`.

    Raises
    ------
    QueryFault
        If an argument is not allowed, or no design qualifies.
    """
    _check_tolerance(tolerance)
    question = (objective, band, 1, exclude_locked, max_impact_speed, ranges)
    best = merged_designs(cubes, *question)
    if best.sizes["rank"] == 0:
        advice = "wait for the study, resume it, or ask for less"
        raise QueryFault(Fault("refine", "no design that qualifies", "a study with a best design", advice))
    parent = next(iter(cubes.values()))
    frequencies = DesignQuestion.ask(
        parent, objective, band, 1, exclude_locked, max_impact_speed, ranges or {}
    ).frequencies
    centre = {name: float(best[name].values[0]) for name in DESIGN}
    found = centre | {name: float(best[name].values[0]) for name in (FREQUENCY, "value", "error")}
    # the design may stand in several studies, and the nearest neighbours in the last of them
    homes = [cube for cube in cubes.values() if all((cube[name] == centre[name]).any() for name in DESIGN)]
    sides = {
        name: _neighbours(
            np.unique(np.concatenate([cube[name].values for cube in homes])),
            parent[name].values,
            centre[name],
        )
        for name in DESIGN
        if parent[name].size > 1
    }
    steps = {name: max(centre[name] - low, high - centre[name]) for name, (low, high) in sides.items()}
    open_ = {name for name, step in steps.items() if step > tolerance * (1 + ROUNDING)}
    fine = _fine(parent, sides, tolerance) * frequencies.size
    if not open_:
        note = f"The optimum is known to {tolerance:g} in every parameter. {_cost(cubes, fine)}"
        return Refinement(None, found, steps, 0, fine, note)
    axes: dict[str, Any] = {}
    for name in DESIGN:
        if name not in open_:
            axes[name] = centre[name]
            continue
        low, high = sides[name]
        parts = min(PARTS.get(len(open_), 2), math.ceil(steps[name] / tolerance - ROUNDING))
        inner = np.concatenate(
            (np.linspace(low, centre[name], parts + 1), np.linspace(centre[name], high, parts + 1))
        )
        axes[name] = np.unique(inner).tolist()
    axes[FREQUENCY] = frequencies.tolist()
    follow_up = _follow_up(study, axes)
    note = (
        f"{counted(follow_up.points, 'point')} around the best design so far, between its neighbours in "
        f"{', '.join(sorted(open_))}. {_cost(cubes, fine, follow_up.points)}"
    )
    return Refinement(follow_up, found, steps, follow_up.points, fine, note)


def refine_boundary(
    study: Study,
    cubes: Mapping[str, xr.Dataset],
    along: str,
    at: Mapping[str, float],
    tolerance: float = TOLERANCE,
) -> Refinement:
    """Make the study that searches where, along one dimension, the class of response changes.

    Parameters
    ----------
    study, cubes, tolerance
        As in `refine_optimum`.
    along : str
        The dimension that is searched.
    at : mapping of float
        The point of the other dimensions, as in `selection.choose`. A value of `along` itself chooses the
        change nearest to it; without one it is the first.

    Raises
    ------
    QueryFault
        If an argument is not allowed, or the class does not change along the line.
    """
    _check_tolerance(tolerance)
    parent = next(iter(cubes.values()))
    check_dimension(parent, "along", along)
    require_stored(parent, "boundary", "response_class", otherwise="")
    others = {name: value for name, value in at.items() if name != along}
    chosen = {name: float(parent[name].values[i]) for name, i in choose(parent, others, (along,)).items()}
    values, classes = _line(cubes, along, chosen)
    change = np.flatnonzero(np.diff(classes))
    if change.size == 0:
        kinds = (
            ", ".join(sorted({ResponseClass(int(kind)).name.lower() for kind in classes}))
            or "nothing computed"
        )
        raise QueryFault(
            Fault(
                "boundary",
                f"{kinds} all along {along}",
                "a line on which the class of response changes",
                "fix the other dimensions elsewhere, or look at a map of response_class",
            )
        )
    middle = (values[change] + values[change + 1]) / 2
    place = int(change[np.abs(middle - at[along]).argmin()] if along in at else change[0])
    low, high = float(values[place]), float(values[place + 1])
    names = [ResponseClass(int(kind)).name.lower() for kind in classes[place : place + 2]]
    found = chosen | {"along": along, "low": low, "high": high, "below": names[0], "above": names[1]}
    span = float(np.ptp(parent[along].values))
    fine = math.ceil(span / tolerance - ROUNDING) + 1
    where = f"{along} changes from {names[0]} to {names[1]} between {low:.10g} and {high:.10g}."
    if high - low <= tolerance * (1 + ROUNDING):
        note = f"The response along {where} {_cost(cubes, fine)}"
        return Refinement(None, found, {along: high - low}, 0, fine, note)
    parts = min(BOUNDARY_PARTS, math.ceil((high - low) / tolerance - ROUNDING))
    inner = np.linspace(low, high, parts + 1)
    follow_up = _follow_up(study, chosen | {along: inner[1:-1].tolist() if parts > 1 else inner.tolist()})
    note = f"The response along {where} {_cost(cubes, fine, follow_up.points)}"
    return Refinement(follow_up, found, {along: high - low}, follow_up.points, fine, note)


def _check_tolerance(tolerance: float) -> None:
    if not FINEST <= tolerance < math.inf:
        raise QueryFault(
            Fault("tolerance", describe(tolerance), f"{FINEST:g} or more", f"the default is {TOLERANCE:g}")
        )


def _neighbours(ranked: np.ndarray, whole: np.ndarray, centre: float) -> tuple[float, float]:
    """Give the values next to `centre`; where it is the last one, as far beyond as the study goes."""
    here = int(np.abs(ranked - centre).argmin())
    low = float(ranked[here - 1]) if here > 0 else None
    high = float(ranked[here + 1]) if here < ranked.size - 1 else None
    step = max(centre - low if low is not None else 0.0, high - centre if high is not None else 0.0)
    if low is None:
        low = max(centre - step, float(whole.min()))
    if high is None:
        high = min(centre + step, float(whole.max()))
    return low, high


def _line(
    cubes: Mapping[str, xr.Dataset], along: str, chosen: Mapping[str, float]
) -> tuple[np.ndarray, np.ndarray]:
    """Values along a line, ascending, and the class at each, of every cube that holds the line."""
    known: dict[float, int] = {}
    for cube in cubes.values():
        index = {name: int(np.abs(cube[name].values - value).argmin()) for name, value in chosen.items()}
        if any(cube[name].values[place] != chosen[name] for name, place in index.items()):
            continue
        kind, status = (cube[name].isel(index).values for name in ("response_class", "status"))
        good = (status >= Status.CONVERGED) & (status <= Status.MAX_CYCLES)
        known |= dict(zip(cube[along].values[good].tolist(), kind[good].tolist(), strict=True))
    values = np.array(sorted(known))
    return values, np.array([known[value] for value in values], np.int64)


def _fine(parent: xr.Dataset, refined: Mapping[str, object], tolerance: float) -> int:
    return math.prod(
        math.ceil(float(np.ptp(parent[name].values)) / tolerance - ROUNDING) + 1 for name in refined
    )


def _cost(cubes: Mapping[str, xr.Dataset], fine: int, more: int = 0) -> str:
    """Say what the search has cost beside a fine grid."""
    spent = more + sum(cube["status"].size for cube in cubes.values())
    if spent >= fine:
        return f"With it {counted(spent, 'point')}; a grid as fine has {counted(fine, 'point')}."
    return (
        f"{counted(spent, 'point')} in all, {fine - spent:,} fewer than the {fine:,} of a grid as fine "
        f"({fine / spent:.3g} times fewer)."
    )


def _follow_up(study: Study, axes: Mapping[str, Any]) -> Study:
    document = study.document()
    # the ratios are given themselves, so the physical block that made them would be a second source
    document.pop("physical", None)
    document["name"] = f"{study.name[: MAX_NAME - 10]}, refined" if study.name else "refined"
    of_particle = ("restitution", "mass_ratio", "clearance_ratio")
    kept = [name for name in DIMENSIONS if study.particle or name not in of_particle]
    document["damping_ratio"] = axes["damping_ratio"]
    document["axes"] = {name: axes[name] for name in kept if name != "damping_ratio"}
    return parse_harmonic(document)
