"""Refinement of an optimum, or of a boundary between response classes, by follow-up studies."""

import math
from collections.abc import Iterable, Mapping
from dataclasses import replace
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from damperlab.studies.answers.cells import Cells, joined
from damperlab.studies.answers.design_question import (
    DesignQuestion,
    design_of,
    judging_in_ratios,
)
from damperlab.studies.answers.flatness import end_of, say_beyond
from damperlab.studies.answers.follow_up import Refinement, follow_up, spent_on
from damperlab.studies.answers.hidden_peak import PEAK_BETWEEN, hidden_peaks
from damperlab.studies.answers.largest_acceleration import acceleration_of, acceleration_rows
from damperlab.studies.answers.nearness import nearest_place
from damperlab.studies.answers.notes import friction_allowed, over_budget, sentence_of, share
from damperlab.studies.answers.optimal_designs import merged_designs
from damperlab.studies.answers.particle_friction import friction_note, study_with_friction
from damperlab.studies.answers.phrases import FREQUENCY, Phrases
from damperlab.studies.answers.query_fault import QueryFault, check_question, refused
from damperlab.studies.answers.selection import check_dimension, choose, in_ratios, require_stored
from damperlab.studies.answers.verdict import is_clamped, none_left
from damperlab.studies.brief import Brief, Note, command, listed
from damperlab.studies.definition import Study
from damperlab.studies.field import At
from damperlab.studies.questions import Judging, Search, Step
from damperlab.studies.understood import unusual_study
from damperlab.studies.variables import ResponseClass, Status

if TYPE_CHECKING:
    import xarray as xr

PARTS = {1: 8, 2: 4}
"""Number of parts into which a cell next to the best design is divided along each parameter, by the number of
parameters. The number is 2 for three or more parameters, and for all cells that are not next to the best
design.
"""
AT_ONCE = 12
"""Largest number of cells away from the best design that are divided in one round."""
BOUNDARY_PARTS = 16
ROUNDING = 1e-9


def refine_optimum(
    study: Study,
    cubes: "Mapping[str, xr.Dataset]",
    search: Search = Search(),
    judging: Judging = Judging(),
) -> Refinement:
    """Make the studies that examine where a better design may lie.

    The grid cells of all studies are examined. The smallest value in a cell is estimated from the values and the
    slopes at its corners. From a corner to the middle of the cell, the value is assumed to fall as steeply as in
    the neighbouring cell. Differences within the errors count as zero. A cell is divided if it can contain a design
    that is better by more than the tolerance, or if it touches the best design. For a study in units, the last
    follow-up computes the optimum with friction of the particle.

    Parameters
    ----------
    study : Study
        The study to refine.
    cubes : mapping of Dataset
        The cube of the study first, then the cubes of finished follow-ups, by the ids of the studies.
    search : Search
        `tolerance` is the step to which each parameter is refined, and `budget` is the largest number of points of
        all follow-ups together. `value_tolerance` is a share of the best value. A cell away from the optimum is
        divided only if it may contain a design that is better by more than this share.
    judging : Judging
        As in `optimal_designs`.

    Raises
    ------
    QueryFault
        If an argument is not allowed, or no design qualifies.
    """
    check_question(search)
    tolerance, value_tolerance, budget = search.tolerance, search.value_tolerance, search.budget
    parent = next(iter(cubes.values()))
    of_parent = design_of(parent.coords)
    others = [cube for cube in cubes.values() if design_of(cube.coords) != of_parent]
    cubes = {name: cube for name, cube in cubes.items() if design_of(cube.coords) == of_parent}
    judging = judging_in_ratios(parent, judging)
    asked = DesignQuestion.ask(parent, judging)
    best = merged_designs(cubes, judging, 1)
    if best.sizes["rank"] == 0:
        raise QueryFault(none_left(parent, asked, best.attrs))
    if (complete := best.attrs["complete"]) < 1:
        told = f"Only {share(complete)} of the designs are computed, so it is not known where a better one may lie."
        raise refused(
            "study", f"{share(complete)} of the designs", "all designs", "compute the rest first", told
        )
    found: dict[str, Any] = {
        name: float(best[name].values[0]) for name in (*asked.design, FREQUENCY, "value", "error")
    }
    varied = [name for name in asked.design if parent[name].size > 1]
    if not varied:
        allowed = "a study that varies at least one design dimension"
        advice = "submit one with an axis of several values"
        told = "The study has only one design, so there is nothing to refine."
        raise refused("refine", "a study of one design", allowed, advice, told)
    cells = Cells.of(cubes, asked, judging.ranges, varied)
    wide = cells.widths > tolerance * (1 + ROUNDING)
    touching = cells.touch([found[name] for name in varied])
    steps = {name: float(cells.widths[touching, d].max(initial=0.0)) for d, name in enumerate(varied)}
    floor = found["value"] * (1 - value_tolerance)
    blurred = touching & cells.flat(found["value"], found["error"])
    near = touching & wide.any(axis=1) & ~blurred
    promising = (cells.promise < floor) & wide.any(axis=1) & ~touching
    spent = spent_on(cubes)
    clamped = is_clamped({name: best[name].values[0] for name in ("value", "locked_share", "impact_share")})
    lead = found | {"study": str(best["study"].values[0])}
    hidden = hidden_peaks(parent, asked, best, lead, cubes)
    short = _brief(study, parent, found, steps, int(spent["points"]), clamped, bool(hidden))
    g = acceleration_of(found, asked, cubes[lead["study"]])
    strikes = bool(best["impact_share"].values[0] > 0.0)
    short = replace(short, rows=tuple(acceleration_rows(g, parent, strikes)))
    answer = Refinement((), False, found, steps, spent=spent, brief=short)
    notes = [
        *hidden,
        _note_search(int(promising.sum()), bool(blurred.any() and not near.any()), steps, search),
    ]
    if not near.any() and not promising.any():
        fine = (
            0 if blurred.any() else _fine(parent, varied, tolerance, judging.ranges) * asked.frequencies.size
        )
        answer = replace(answer, known=True, fine_points=fine, notes=(*notes, _note_cost(spent, fine)))
        rubbing = study_with_friction(study, asked, found) if strikes else None
        if rubbing is None:
            return answer
        return _with_friction(answer, rubbing, others, replace(judging, objective=asked.objective))
    parts = PARTS.get(len(varied), 2)
    chosen = [_grids(cells, np.flatnonzero(near), parts, tolerance, varied)]
    elsewhere = np.flatnonzero(promising)
    elsewhere = elsewhere[np.argsort(cells.promise[elsewhere], kind="stable")][:AT_ONCE]
    chosen.append(_grids(cells, elsewhere, 2, tolerance, varied))
    fixed = {name: found[name] for name in asked.design if name not in varied} | {
        FREQUENCY: asked.frequencies.tolist()
    }
    studies = tuple(follow_up(study, fixed | axes, "refined") for grids in chosen for axes in grids)
    points = sum(each.points for each in studies)
    more = int(spent["points"]) - parent["status"].size + points
    if more > budget:
        short_of = {"points": budget, "left": max(0, budget - more + points), "next_points": points}
        notes.append(Note("budget", "caution", short_of))
        unsettled = (*short.sentences[:2], f"Not settled: {over_budget(short_of)}.")
        enough = f"--budget {max(4 * budget, more)}"
        short = replace(short, sentences=unsettled, next=command("refine", study.name, enough))
        return replace(answer, notes=(*notes, Note("spent", "hint", spent)), brief=short)
    notes.append(Note("follow_ups", "hint", {"points": points, "studies": len(studies)}))
    return replace(answer, studies=studies, points=points, notes=(*notes, Note("spent", "hint", spent)))


def _with_friction(
    answer: Refinement, rubbing: Study, cubes: "Iterable[xr.Dataset]", judging: Judging
) -> Refinement:
    """Add the note of `friction_note` to a known optimum.

    If the results with friction are not computed yet, request the study that computes them instead.
    """
    note = friction_note((rubbing,), cubes, judging, answer.found["value"])
    if note is None:
        return replace(answer, studies=(rubbing,), points=rubbing.points)
    brief = answer.brief and replace(
        answer.brief, rows=(*answer.brief.rows, ("particle friction", *friction_allowed(note)))
    )
    return replace(answer, notes=(*answer.notes, note), brief=brief)


def _brief(
    study: Study,
    cube: "xr.Dataset",
    found: Mapping[str, float],
    steps: Mapping[str, float],
    points: int,
    clamped: bool,
    hides: bool,
) -> Brief:
    """Describe the optimum and its error, and say whether it lies inside the ranges."""
    phrases = Phrases.of(cube)
    design = ", ".join(phrases.equal(name, found[name], ".3g") for name in steps)
    ends = {
        name: [end, found[name]] for name in steps if (end := end_of(cube[name].values, found[name], name))
    }
    inside = "."
    if ends:
        which = "each" if len(ends) == len(steps) > 1 else listed(map(phrases.symbol, ends))
        ranges = "their ranges" if 1 < len(ends) < len(steps) else "its range"
        inside = f": {which} at the end of {ranges}, so no optimum inside."
    value = phrases.measured(found["value"], found["error"], ".3g")
    known = ", ".join(
        f"{phrases.symbol(name)} ± {phrases.value(name, step, '.3g')}" for name, step in steps.items()
    )
    danger = "Friction clamps the structure to its base at this optimum." if clamped else ""
    if cube.sizes[FREQUENCY] == 1:
        only = Note("one_frequency", "danger", {FREQUENCY: found[FREQUENCY], "computed": True})
        danger = sentence_of(only, phrases)
    elif hides:
        danger = PEAK_BETWEEN
    danger = next(iter(unusual_study(study)), danger)
    sentences = (danger, f"{value} at {design}{inside}", f"Known to {known} after {points:,} points.")
    following = say_beyond(ends, phrases) or command("tmd", study.name)
    if clamped:
        following = command("refine", study.name, "--exclude-locked")
    return Brief(None, sentences, (), following)


def _grids(
    cells: Cells, chosen: np.ndarray, parts: int, tolerance: float, varied: list[str]
) -> list[dict[str, list[float]]]:
    """Divide chosen cells into at most `parts` along each parameter, and combine neighbouring cells into one grid."""
    grids = []
    for box in joined(cells, chosen):
        axes = {}
        for name, edges in zip(varied, box, strict=True):
            cut = [
                np.linspace(low, high, max(1, min(parts, math.ceil((high - low) / tolerance - ROUNDING))) + 1)
                for low, high in pairwise(edges)
            ]
            axes[name] = np.unique(np.concatenate(cut)).tolist() if cut else [float(edges[0])]
        grids.append(axes)
    return grids


def _note_search(promising: int, blurred: bool, steps: Mapping[str, float], search: Search) -> Note:
    """Return a note on the search: cells that may contain a better design, or the accuracy of the optimum."""
    better = {"better_by": search.value_tolerance}
    coarse = {name: step for name, step in steps.items() if step > search.tolerance * (1 + ROUNDING)}
    if promising:
        return Note("promising", "hint", {"cells": promising, **better})
    if coarse:
        kind = "place_within_errors" if blurred else "place_not_known"
        return Note(kind, "caution", {"steps": coarse, **better})
    return Note("known", "hint", {"tolerance": search.tolerance, **better})


def refine_boundary(
    study: Study,
    cubes: "Mapping[str, xr.Dataset]",
    along: str,
    at: At,
    tolerance: float = Step.tolerance,
) -> Refinement:
    """Make the study that locates a change of the response class along one dimension.

    Parameters
    ----------
    study, cubes
        As in `refine_optimum`.
    along : str
        The dimension along which the class changes.
    at : mapping of float
        The values along the other dimensions, as in `selection.choose`. If `at` also has the key `along`, the
        change nearest to its value is located, otherwise the first change.
    tolerance : float
        The change is located if it lies between two neighbouring values that differ by at most `tolerance`.

    Raises
    ------
    QueryFault
        If an argument is not allowed, or the class does not change along the line.
    """
    check_question(Step(tolerance=tolerance))
    parent = next(iter(cubes.values()))
    check_dimension(parent, "along", along)
    require_stored(parent, "boundary", "response_class", otherwise="")
    at = in_ratios(parent, at)
    others = {name: value for name, value in at.items() if name != along}
    chosen = {name: float(parent[name].values[i]) for name, i in choose(parent, others, (along,)).items()}
    values, classes = _line(cubes, along, chosen)
    change = np.flatnonzero(np.diff(classes))
    if change.size == 0:
        kinds = (
            ", ".join(sorted({ResponseClass(int(kind)).name.lower() for kind in classes}))
            or "nothing computed"
        )
        raise refused(
            "boundary",
            f"{kinds} all along {along}",
            "a line on which the class of response changes",
            "fix the other dimensions at other values, or look at a map of response_class",
            f"The class of response does not change along {along}: {kinds} everywhere.",
        )
    middle = (values[change] + values[change + 1]) / 2
    place = int(change[np.abs(middle - at[along]).argmin()] if along in at else change[0])
    low, high = float(values[place]), float(values[place + 1])
    names = [ResponseClass(int(kind)).name.lower() for kind in classes[place : place + 2]]
    found = chosen | {"along": along, "low": low, "high": high, "below": names[0], "above": names[1]}
    span = float(np.ptp(parent[along].values))
    fine = math.ceil(span / tolerance - ROUNDING) + 1
    spent = spent_on(cubes)
    change_at = Note(
        "boundary", "hint", {name: found[name] for name in ("along", "low", "high", "below", "above")}
    )
    if high - low <= tolerance * (1 + ROUNDING):
        notes = change_at, _note_cost(spent, fine)
        return Refinement((), True, found, {along: high - low}, 0, fine, spent, notes)
    parts = min(BOUNDARY_PARTS, math.ceil((high - low) / tolerance - ROUNDING))
    inner = np.linspace(low, high, parts + 1)
    more = follow_up(
        study, chosen | {along: inner[1:-1].tolist() if parts > 1 else inner.tolist()}, "refined"
    )
    notes = change_at, _note_cost(spent, fine, more.points)
    return Refinement((more,), False, found, {along: high - low}, more.points, fine, spent, notes)


def _line(
    cubes: "Mapping[str, xr.Dataset]", along: str, chosen: Mapping[str, float]
) -> tuple[np.ndarray, np.ndarray]:
    """Return the ascending values along a line, and the class at each value, from every cube that contains the line."""
    known: dict[float, int] = {}
    for cube in cubes.values():
        index = {name: nearest_place(cube[name].values, value) for name, value in chosen.items()}
        if any(cube[name].values[place] != chosen[name] for name, place in index.items()):
            continue
        kind, status = (cube[name].isel(index).values for name in ("response_class", "status"))
        good = (status >= Status.CONVERGED) & (status <= Status.MAX_CYCLES)
        known |= dict(zip(cube[along].values[good].tolist(), kind[good].tolist(), strict=True))
    values = np.array(sorted(known))
    return values, np.array([known[value] for value in values], np.int64)


def _fine(
    parent: "xr.Dataset", refined: list[str], tolerance: float, ranges: Mapping[str, tuple[float, float]]
) -> int:
    """Count the designs of a grid with steps of `tolerance` over the ranges of the question."""
    spans = []
    for name in refined:
        values = parent[name].values
        low, high = ranges.get(name, (-math.inf, math.inf))
        spans.append(max(0.0, min(high, float(values.max())) - max(low, float(values.min()))))
    return math.prod(math.ceil(span / tolerance - ROUNDING) + 1 for span in spans)


def _note_cost(spent: Mapping[str, float], fine: int, more: int = 0) -> Note:
    """Return a note with the cost of the search and, if known, the cost of a grid with equally small steps."""
    if not fine:
        return Note("spent", "hint", spent)
    return Note("cost", "hint", {"points": int(spent["points"]) + more, "fine_points": fine})
