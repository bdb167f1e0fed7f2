"""Check the criteria for ranking designs against the cube of a study."""

import math
from collections.abc import Container, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from damperlab.studies.answers.band import default_objective
from damperlab.studies.answers.nearness import inside, nearest_place
from damperlab.studies.answers.phrases import AMPLITUDE, FREQUENCY
from damperlab.studies.answers.query_fault import QueryFault, check_question, empty_range, refused
from damperlab.studies.answers.selection import check_dimension, require_stored
from damperlab.studies.faults import describe
from damperlab.studies.questions import Judging, Listed
from damperlab.studies.units import coordinates_in_units, results_in_units
from damperlab.studies.variables import DIMENSIONS, VARIABLES, dimensions_of
from damperlab.studies.vocabulary import OBJECTIVES, Objective

if TYPE_CHECKING:
    import xarray as xr

DESIGN: tuple[str, ...] = tuple(name for name in DIMENSIONS if name != FREQUENCY)


def design_of(names: Container[object]) -> tuple[str, ...]:
    """Return the dimensions of a cube that describe a design: all dimensions except the frequency."""
    return tuple(name for name in dimensions_of(names) if name != FREQUENCY)


@dataclass(frozen=True)
class DesignQuestion:
    """Checked criteria for ranking designs.

    Parameters
    ----------
    objective : str
        The criterion; the default criterion if the question names none.
    judging : Judging
        The constraints, in ratios.
    top : int
        Largest number of designs in the answer.
    axes : dict of ndarray
        Grid indices of the designs and of the frequencies to judge.
    frequencies : ndarray
        The frequencies to judge, ascending.
    """

    objective: Objective
    judging: Judging
    top: int
    axes: dict[str, np.ndarray]
    frequencies: np.ndarray

    @cached_property
    def weights(self) -> np.ndarray:
        """Weights of the frequencies in a mean over the band; their sum is 1."""
        weights = trapezoid(self.frequencies)
        return np.asarray(weights / weights.sum())

    @cached_property
    def nearest(self) -> int:
        """Index of the judged frequency nearest r = 1."""
        return nearest_place(self.frequencies, 1.0)

    @property
    def limits(self) -> dict[str, tuple[float, float]]:
        """The range in which a result must lie at each judged frequency, by the name of the result."""
        return {name: limit for name, limit in self.judging.ranges.items() if name in VARIABLES}

    @property
    def design(self) -> tuple[str, ...]:
        """The dimensions of a design."""
        return design_of(self.axes)

    def place_of(self, design: "Mapping[str, Any] | xr.Dataset", cube: "xr.Dataset") -> dict[str, int]:
        """Return the grid index of a design along each of its dimensions."""
        return {name: nearest_place(cube[name].values, float(design[name])) for name in self.design}

    @property
    def long_name(self) -> str:
        """Long name of the objective."""
        return OBJECTIVES[self.objective]

    @classmethod
    def ask(
        cls,
        cube: "xr.Dataset",
        judging: Judging,
        top: int = 1,
    ) -> "DesignQuestion":
        """Make the question for a cube. Raise `QueryFault` if the cube cannot answer the question."""
        require_stored(cube, "objective", AMPLITUDE, otherwise="")
        check_question(judging)
        check_question(Listed(top))
        judging = judging_in_ratios(cube, judging)
        band, ranges = judging.band, judging.ranges
        objective: Objective = judging.objective or default_objective(cube, band)
        if band is not None and objective == "resonance":
            raise refused(
                "band",
                describe(list(band)),
                "no band with objective resonance",
                "leave `band` out, or choose another `objective`",
                "`band` cannot be combined with the objective resonance, which judges the frequency nearest r = 1 alone.",
            )
        if judging.max_impact_speed is not None:
            require_stored(cube, "max_impact_speed", "impact_speed_max")
        if judging.exclude_locked:
            require_stored(cube, "exclude_locked", "response_class")
        for name, limit in ranges.items():
            if name in VARIABLES:
                require_stored(cube, name, name)
                if VARIABLES[name].flags is not None:
                    allowed = "a result that is a quantity, or a design dimension"
                    told = f"`{name}` holds codes, which have no order, so they cannot lie in a range."
                    raise refused(name, "a range of codes", allowed, "leave it out", told)
                _check_limits(name, limit)
            elif name == FREQUENCY:
                allowed, advice = "a range of a design dimension", "give the range as `band`"
                told = f"{FREQUENCY} is not a design dimension: designs are judged over its range."
                raise refused(name, describe(list(limit)), allowed, advice, told)
            else:
                check_dimension(cube, name, name)
        axes = {name: within(cube, name, name, ranges.get(name)) for name in design_of(cube.sizes)}
        counting = within(cube, "band", FREQUENCY, band)
        if objective == "resonance":
            distance = np.abs(cube[FREQUENCY].values[counting] - 1.0)
            counting = counting[[int(distance.argmin())]]
        counting = counting[np.argsort(cube[FREQUENCY].values[counting], kind="stable")]
        axes[FREQUENCY] = counting
        return cls(objective, judging, top, axes, cube[FREQUENCY].values[counting])


def judging_in_ratios(cube: "xr.Dataset", judging: Judging) -> Judging:
    """Convert ranges in SI units into ranges of ratios. A range of frequencies becomes the band."""
    units = {each.name: each for each in (*coordinates_in_units(cube), *results_in_units(cube))}
    if not units.keys() & judging.ranges.keys():
        return judging
    band, ranges = judging.band, dict(judging.ranges)
    for name in [
        name for name in judging.ranges if name in units
    ]:  # in the order of the question, because sentences about the question keep this order
        each = units[name]
        if each.source in cube.sizes:
            values = each.of(cube[each.source].values)
            if not inside(values, *ranges[name]).any():
                _check_limits(name, ranges[name])
                raise QueryFault(empty_range(name, name, *ranges[name], values))
        low, high = (end / each.factor for end in ranges.pop(name))
        if each.source in ranges or (each.source == FREQUENCY and band is not None):
            other = "band" if each.source == FREQUENCY else each.source
            advice = f"give either {name} or {other}"
            told = f"{{field}} and `{other}` are ranges of the same quantity, which may have only one."
            raise refused(name, f"a range beside one of {other}", "one range of a quantity", advice, told)
        if each.source == FREQUENCY:
            band = low, high
        else:
            ranges[each.source] = low, high
    return replace(judging, band=band, ranges=ranges)


def within(cube: "xr.Dataset", field: str, name: str, limits: tuple[float, float] | None) -> np.ndarray:
    """Return the positions at which a dimension has values within `limits`, or all positions if `limits` is None.

    Raise `QueryFault` if no value lies within the limits.
    """
    values = cube[name].values
    if limits is None:
        return np.arange(values.size)
    low, high = limits
    _check_limits(field, limits)
    found = np.flatnonzero(inside(values, low, high))
    if found.size == 0:
        fault = empty_range(field, name, low, high, values)
        for each in coordinates_in_units(cube):
            if each.source == name and inside(each.of(values), low, high).any():
                span = f"{each.name}={low:.10g},{high:.10g}"
                advice = (
                    f"`{field}` is a range of ratios; for a range in {each.units}, write {span} "
                    "(after --within on the command line)"
                )
                fault = replace(fault, advice=advice)
        raise QueryFault(fault)
    return found


def axes_within(cube: "xr.Dataset", ranges: Mapping[str, tuple[float, float]]) -> dict[str, np.ndarray]:
    """Return for every dimension the positions at which its values lie within the ranges.

    Ranges of quantities in SI units are allowed too.
    """
    judging = judging_in_ratios(cube, Judging(ranges=ranges))
    wanted = dict(judging.ranges)
    if judging.band is not None:
        wanted[FREQUENCY] = judging.band
    dimensions = tuple(map(str, cube["status"].dims))
    for name in wanted:
        check_dimension(cube, name, name, [each for each in dimensions if cube[each].dtype.kind == "U"])
    return {name: within(cube, name, name, wanted.get(name)) for name in dimensions}


def _check_limits(field: str, limits: tuple[float, float]) -> None:
    """Raise `QueryFault` if an end of a range is NaN, or if the lower end exceeds the upper end."""
    low, high = limits
    if math.isnan(low) or math.isnan(high) or low > high:
        found = f"{low:.10g} to {high:.10g}"
        raise refused(field, found, "two numbers, the lower one first", "correct the range")


def trapezoid(frequencies: np.ndarray) -> np.ndarray:
    """Return the weights of the trapezoidal rule over ascending frequencies. A single frequency has the weight 1."""
    if frequencies.size == 1:
        return np.ones(1)
    return np.convolve(np.diff(frequencies), [0.5, 0.5])
