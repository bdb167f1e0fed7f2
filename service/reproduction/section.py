"""A section of the report: rows of numbers with the paper's, sentences, figures."""

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
"""Computes a study, or finds it stored, and gives its cube."""

MET = 0.1
"""Relative difference within which a number agrees with the paper's."""
QUICK_VALUES = 5
"""Largest number of values of an axis in the short form, in addition to those that a section names."""


@dataclass(frozen=True)
class Row:
    """One number, compared with the paper's.

    Parameters
    ----------
    quantity : str
        Its name.
    paper : PaperNumber or None
        As printed; None if the paper prints none.
    ours : float
        Computed now.
    assumption : str
        The reading of the paper's open choices.
    error : float or None
        Uncertainty of `ours`; None if it is exact or has no meaning.
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
        """Share by which ours is larger than the paper's."""
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
        Its name in the paper.
    verdict : str
        The result, in a sentence or two.
    rows : list of Row
        Numbers.
    words : list of str
        Conclusions, a paragraph each.
    figures : dict of Figure
        By file name.
    tables : list
        Further tables, each a head and rows of text or numbers.
    studies : list of Study
        Studies computed for it.
    """

    title: str
    verdict: str = ""
    rows: list[Row] = field(default_factory=list)
    words: list[str] = field(default_factory=list)
    figures: dict[str, Figure] = field(default_factory=dict)
    tables: list[tuple[tuple[str, ...], list[tuple[object, ...]]]] = field(default_factory=list)
    studies: list[Study] = field(default_factory=list)

    def solve(self, solve: Solve, study: Study) -> xr.Dataset:
        """Compute a study, and record it once for the section."""
        if study not in self.studies:
            self.studies.append(study)
        return solve(study)

    @property
    def met(self) -> tuple[int, int]:
        """How many of the paper's numbers agree within `MET` under some reading, and their total."""
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
    """Make a study from a named one with some changes.

    Parameters
    ----------
    name : str
        Name of a study.
    called : str
        Suffix of the new study's name.
    quick : bool
        Keep a few values of each axis: the ends, r = 1, and those in `changes`.
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
    """Keep evenly spread values, and r = 1 where the axis has it."""
    if values.size <= QUICK_VALUES:
        return [float(value) for value in values]
    places = np.unique(np.linspace(0, values.size - 1, QUICK_VALUES).round().astype(int))
    ones = np.flatnonzero(np.abs(values - 1) < 1e-9)
    return [float(value) for value in values[np.union1d(places, ones)]]


def at(cube: xr.Dataset, name: str, **point: float) -> float:
    """Value of a variable at a grid point, which must exist up to rounding."""
    return float(cube[name].sel(point, method="nearest", tolerance=1e-9).squeeze())
