"""A section of the report: sentences, figures, and rows that compare numbers with the paper's numbers."""

from collections.abc import Callable
from dataclasses import dataclass, field
from math import inf, isfinite
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from damperlab.studies.definition import Study, parse_harmonic
from damperlab.studies.paper import PaperNumber
from damperlab.studies.reading import named_study

Solve = Callable[[Study], xr.Dataset]
"""A function that returns the cube of a study, computed or found in a store."""

MET = 0.1
"""Largest relative difference at which a computed number agrees with the paper's number."""
QUICK_VALUES = 5
"""Largest number of values of an axis in the short form, in addition to the values that a section names."""


@dataclass(frozen=True)
class Row:
    """One computed number, compared with the number in the paper.

    Parameters
    ----------
    quantity : str
        Name of the quantity.
    paper : PaperNumber or None
        The number printed in the paper; None if the paper prints none.
    ours : float
        The computed number.
    assumption : str
        Assumptions about values that the paper does not state.
    error : float or None
        Uncertainty of `ours`; None if `ours` is exact, or if an uncertainty has no meaning.
    contact : str
        Contact model; empty without impacts.
    """

    quantity: str
    paper: PaperNumber | None
    ours: float
    assumption: str = ""
    error: float | None = None
    contact: str = ""

    @property
    def difference(self) -> float | None:
        """Relative difference of `ours` from the paper's number; None if either number is missing."""
        if self.paper is None or not isfinite(self.ours):
            return None
        return self.ours / self.paper.value - 1

    def document(self) -> dict[str, Any]:
        """Return the row as JSON-able data."""
        return {
            "quantity": self.quantity,
            "paper": None if self.paper is None else self.paper.value,
            "place": None if self.paper is None else self.paper.place,
            "ours": self.ours,
            "error": self.error,
            "difference": self.difference,
            "contact": self.contact,
            "assumption": self.assumption,
        }


@dataclass
class Section:
    """One figure or table of the paper.

    Parameters
    ----------
    title : str
        Name of the figure or table, and its subject.
    verdict : str
        The result, in a sentence or two.
    rows : list of Row
        The compared numbers.
    words : list of str
        Conclusions, one paragraph each.
    figures : dict of Figure
        Figures by file name.
    tables : list
        Further tables, each as column names and rows.
    studies : list of Study
        Studies computed for the section.
    """

    title: str
    verdict: str = ""
    rows: list[Row] = field(default_factory=list)
    words: list[str] = field(default_factory=list)
    figures: dict[str, Figure] = field(default_factory=dict)
    tables: list[tuple[tuple[str, ...], list[tuple[object, ...]]]] = field(default_factory=list)
    studies: list[Study] = field(default_factory=list)

    def solve(self, solve: Solve, study: Study) -> xr.Dataset:
        """Compute a study, and add the study to `studies`."""
        if study not in self.studies:
            self.studies.append(study)
        return solve(study)

    @property
    def met(self) -> tuple[int, int]:
        """Number of values in the paper that are reproduced within `MET`, and number of compared values.

        If several rows compare one value, the row with the smallest difference counts.
        """
        best: dict[tuple[str, float], float] = {}
        for row in self.rows:
            if row.paper is not None and row.difference is not None:
                key = (row.quantity, row.paper.value)
                best[key] = min(best.get(key, inf), abs(row.difference))
        return sum(each <= MET for each in best.values()), len(best)

    def document(self) -> dict[str, Any]:
        """Return the section as JSON-able data."""
        return {
            "title": self.title,
            "verdict": self.verdict,
            "met": self.met,
            "rows": [row.document() for row in self.rows],
            "words": self.words,
            "figures": list(self.figures),
            "tables": [{"columns": head, "rows": rows} for head, rows in self.tables],
            "studies": [
                {"id": study.digest[:12], "name": study.name, "points": study.points}
                for study in self.studies
            ],
        }


def variant(name: str, called: str = "", quick: bool = False, **changes: Any) -> Study:
    """Make a study from a named study, with some changes.

    Parameters
    ----------
    name : str
        Name of a study.
    called : str
        Suffix of the new study's name.
    quick : bool
        Whether to keep only a few values of each axis: the ends, r = 1, and the values in `changes`.
    changes
        Entries of `axes` by their names, or other fields of a study, for example `contact`.
    """
    study = named_study(name)
    document = study.document()
    if called:
        document["name"] = f"{study.name}, {called}"
    if quick:
        document["name"] += ", short form"
        document["steady"] = {**document["steady"], "max_cycles": 400}
        coordinates = study.coordinates
        document["axes"] = {axis: _few(coordinates[axis]) for axis in document["axes"]}
    for key, value in changes.items():
        (document["axes"] if key in document["axes"] else document)[key] = value
    return parse_harmonic(document)


def _few(values: np.ndarray) -> list[float]:
    """Return a few evenly spread values of an axis, and r = 1 if the axis contains it."""
    if values.size <= QUICK_VALUES:
        return [float(value) for value in values]
    places = np.unique(np.linspace(0, values.size - 1, QUICK_VALUES).round().astype(int))
    ones = np.flatnonzero(np.abs(values - 1) < 1e-9)
    return [float(value) for value in values[np.union1d(places, ones)]]


def at(cube: xr.Dataset, name: str, **point: float) -> float:
    """Return the value of a variable at the grid point with the given coordinates, which must agree up to rounding."""
    return float(cube[name].sel(point, method="nearest", tolerance=1e-9).squeeze())
