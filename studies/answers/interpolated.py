"""Values between grid points: linear, only on request, and never across a change of response class."""

from itertools import product

import numpy as np
import xarray as xr

from damperlab.studies.answers.nearness import same
from damperlab.studies.answers.phrases import RATIOS, Phrases
from damperlab.studies.answers.query_fault import refused
from damperlab.studies.answers.selection import (
    NO_LEAD,
    Lead,
    as_float,
    choose,
    coded,
    read,
    require_stored,
    say,
)
from damperlab.studies.field import At

INTERPOLATED = {
    "units": "1",
    "long_name": "whether the value was interpolated; where not, it is that of the nearest grid point",
}


class Interpolated:
    """Positions of wanted values between grid points, and the weights of the corners around them.

    Parameters
    ----------
    cube : Dataset
        A study's cube; it must store the response class.
    metric : str
        A quantity, not a code.
    at : mapping of float
        The wanted values. A value beyond the end of its axis is taken at the end: there is no extrapolation.
    free : tuple of str
        The dimensions of the slice.

    Raises
    ------
    QueryFault
        If the metric has codes, or the cube stores no class, so that a change of class could not be detected.
    """

    def __init__(self, cube: xr.Dataset, metric: str, at: At, free: tuple[str, ...]) -> None:
        if coded(cube, metric):
            told = f"{metric} holds codes, so there is nothing to interpolate between them."
            advice = "leave `interpolate` out, or choose a metric that is a quantity"
            raise refused("interpolate", "true", "a metric that is a quantity", advice, told)
        require_stored(cube, "interpolate", "response_class")
        self._cube, self._metric, self._free = cube, metric, free
        self.nearest = choose(cube, at, free)
        self.sides: dict[str, tuple[int, int, float]] = {}
        for name in at:
            wanted = float(at[name])
            axis = cube[name].values
            order = np.argsort(axis)
            place = int(np.searchsorted(axis[order], wanted))
            if 0 < place < axis.size and not same(axis, wanted).any():
                low, high = int(order[place - 1]), int(order[place])
                self.sides[name] = low, high, float((wanted - axis[low]) / (axis[high] - axis[low]))

    def read(self, companions: list[str]) -> dict[str, np.ndarray]:
        """Read the slice.

        Returns
        -------
        dict of ndarray
            The metric; every companion at the nearest grid point, except `amplitude_error`, which covers the corners
            by their largest error and their largest distance from the value; and `interpolated`.
        """
        values = {
            name: read(self._cube, name, self.nearest, self._free) for name in (self._metric, *companions)
        }
        values[self._metric] = as_float(values[self._metric])
        kind = values["response_class"]
        same = np.full(kind.shape, bool(self.sides))
        total = np.zeros(kind.shape)
        corners, doubts = [], []
        for pick in product((0, 1), repeat=len(self.sides)):
            index = dict(self.nearest)
            weight = 1.0
            for (name, (low, high, share)), upper in zip(self.sides.items(), pick, strict=True):
                index[name] = high if upper else low
                weight *= share if upper else 1 - share
            corner = as_float(read(self._cube, self._metric, index, self._free))
            same &= read(self._cube, "response_class", index, self._free) == kind
            same &= np.isfinite(corner)
            total += weight * np.where(np.isfinite(corner), corner, 0.0)
            corners.append(corner)
            if "amplitude_error" in values:
                doubts.append(read(self._cube, "amplitude_error", index, self._free))
        values[self._metric] = np.where(same, total, values[self._metric])
        if doubts and self.sides:
            spread = np.max([np.abs(np.where(same, corner - total, 0.0)) for corner in corners], axis=0)
            covered = np.max(np.where(same, doubts, 0.0), axis=0) + spread
            values["amplitude_error"] = np.where(same, covered, values["amplitude_error"])
        values["interpolated"] = same.astype(np.int8)
        return values

    def say(self, at: At, phrases: Phrases = RATIOS, lead: Lead = NO_LEAD) -> str:
        """Say which grid points were taken, and between which the value was interpolated."""
        there = {name: place for name, place in self.nearest.items() if name not in self.sides}
        taken = say(self._cube, there, at, phrases, lead)
        if not self.sides:
            return f"{taken} Nothing was interpolated: every asked value is on the grid or beyond its end."
        spans = [
            f"to {phrases.label(name)} = {phrases.value(name, float(at[name]), '.10g')} between "
            f"{phrases.number(name, self._cube[name].values[low], '.10g')} and "
            f"{phrases.value(name, self._cube[name].values[high], '.10g')}"
            for name, (low, high, _) in self.sides.items()
        ]
        return (
            f"{taken} Interpolated linearly {', '.join(spans)}, where all grid points around are of one response class; "
            "elsewhere the value is that of the nearest grid point."
        ).strip()

    def scalars(self, at: At) -> dict[str, xr.DataArray]:
        """Give the wanted values as scalar coordinates; the grid's where nothing is interpolated."""
        found = {name: self._cube[name].isel({name: place}) for name, place in self.nearest.items()}
        for name in self.sides:
            found[name] = found[name].copy(data=np.float64(at[name]))
        return found
