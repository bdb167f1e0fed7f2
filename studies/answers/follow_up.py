"""Follow-up studies, which compute a few further designs with the structure and the settings of a study."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from damperlab.studies.answers.excited import definition_of
from damperlab.studies.answers.notes import sentences_of
from damperlab.studies.answers.phrases import RATIOS, Phrases
from damperlab.studies.brief import Brief, Note
from damperlab.studies.definition import MAX_NAME, Study, parse_harmonic
from damperlab.studies.units import STRUCTURE
from damperlab.studies.variables import BEFORE, DIMENSIONS
from damperlab.studies.vocabulary import OF_PARTICLE

if TYPE_CHECKING:
    import xarray as xr

WASTE = 1.5
"""Ratio of computed to wanted designs above which a set of designs is split into several grids."""


@dataclass(frozen=True)
class Refinement:
    """The result of one step of a search: the findings so far, and the studies to compute next.

    Parameters
    ----------
    studies : tuple of Study
        The follow-up studies to submit next. Empty once the answer is known or the budget is spent.
    known : bool
        Whether the answer is known to the stated tolerances or confidence.
    found : dict
        The optimum so far (coordinates, `value`, `error`), or the boundary so far (`low`, `high`, and both classes).
    steps : dict of float
        Distance from the optimum to the farther of its two neighbouring grid points, by parameter.
    points : int
        Number of points of the follow-ups.
    fine_points : int
        Number of points of a uniform grid that would give the same answer; 0 if no such grid is known.
    spent : dict
        Cost so far: `points`, and also `cycles` and `seconds` of run time if the studies store these results.
    notes : tuple of Note
        The notes as data, which `say` converts to sentences.
    brief : Brief or None
        The short answer, in the units of the study, if the search has a short answer.
    """

    studies: tuple[Study, ...]
    known: bool
    found: dict[str, Any]
    steps: dict[str, float] = field(default_factory=dict)
    points: int = 0
    fine_points: int = 0
    spent: dict[str, float] = field(default_factory=dict)
    notes: tuple[Note, ...] = ()
    brief: Brief | None = None

    def say(self, phrases: Phrases = RATIOS) -> str:
        """Return the notes as sentences."""
        return sentences_of(self.notes, phrases)


def follow_up(study: Study, axes: Mapping[str, Any], kind: str) -> Study:
    """Make a study with the settings of another study, but with other axes."""
    document = study.document()
    # the axes are ratios, so only the entries of the physical block that convert units are kept
    physical = document.pop("physical", None) or {}
    structure = {name: physical[name] for name in STRUCTURE if isinstance(physical.get(name), int | float)}
    if structure:
        document["physical"] = structure
    document["name"] = named(study, kind)
    kept = [name for name in DIMENSIONS if study.particle or name not in OF_PARTICLE]
    document["damping_ratio"] = axes["damping_ratio"]
    document |= {name: axes[name] for name in BEFORE if name in axes}
    document["axes"] = {name: axes[name] for name in kept if name != "damping_ratio"}
    return parse_harmonic(document)


def named(study: Study, kind: str) -> str:
    """Name a follow-up of a study."""
    return f"{study.name[: MAX_NAME - 15]}, {kind}" if study.name else kind


def cover(designs: np.ndarray, most: int = 8) -> list[list[np.ndarray]]:
    """Return a few grids that contain all given designs and few other designs.

    Parameters
    ----------
    designs : ndarray, (n, parameters)
        Coordinates of the designs, one design per row.
    most : int
        Largest number of grids.

    Returns
    -------
    list of list of ndarray
        The axes of each grid.
    """
    parts = [designs]
    while len(parts) < most:
        sizes = [math.prod(len(axis) for axis in _axes(part)) for part in parts]
        if sum(sizes) <= WASTE * len(designs):
            break
        worst = int(np.argmax([size - len(part) for size, part in zip(sizes, parts, strict=True)]))
        parts[worst : worst + 1] = _halves(parts[worst])
    return [_axes(part) for part in parts]


def _axes(part: np.ndarray) -> list[np.ndarray]:
    return [np.unique(column) for column in part.T]


def _halves(part: np.ndarray) -> list[np.ndarray]:
    """Split the designs into two parts whose grids have the fewest points in total."""
    best: tuple[int, list[np.ndarray]] | None = None
    for column, axis in enumerate(_axes(part)):
        for cut in axis[1:]:
            below = part[:, column] < cut
            halves = [part[below], part[~below]]
            size = sum(math.prod(len(axis) for axis in _axes(half)) for half in halves)
            if best is None or size < best[0]:
                best = size, halves
    assert (
        best is not None
    )  # a grid with more points than designs has a parameter with several values, along which it can be cut
    return best[1]


def tolerance_of(cube: "xr.Dataset", otherwise: float) -> float:
    """Return the tolerance with which a cube was computed."""
    study = definition_of(cube)
    return float(study.get("steady", {}).get("tolerance", otherwise))


def spent_on(cubes: "Mapping[str, xr.Dataset]") -> dict[str, float]:
    """Count the computed points. Also sum up the cycles, and the run time in seconds, if every study stores them.

    A point in several studies with the same settings is counted once, because later studies reuse the result.
    """
    computed = _computed(cubes)
    spent: dict[str, float] = {"points": sum(int(new.sum()) for new in computed)}
    if all("cycles" in cube for cube in cubes.values()):
        spent["cycles"] = sum(
            int(np.maximum(cube["cycles"].values[new], 0).sum(dtype=np.int64))
            for cube, new in zip(cubes.values(), computed, strict=True)
        )
    if all("run_time" in cube for cube in cubes.values()):
        spent["seconds"] = sum(
            float(np.nansum(cube["run_time"].values[new]))
            for cube, new in zip(cubes.values(), computed, strict=True)
        )
    return spent


def _computed(cubes: "Mapping[str, xr.Dataset]") -> list[np.ndarray]:
    """Return for every cube the points that have a result and are in no earlier cube."""
    found: list[np.ndarray] = []
    earlier: list[tuple[Any, dict[Any, np.ndarray]]] = []
    for cube in cubes.values():
        settings = definition_of(cube).get("steady")
        status = cube["status"]
        axes = {name: cube[name].values for name in status.dims}
        new = status.values >= 0
        for theirs, others in earlier:
            if theirs == settings:
                new[np.ix_(*(np.isin(axis, others[name]) for name, axis in axes.items()))] = False
        earlier.append((settings, axes))
        found.append(new)
    return found
