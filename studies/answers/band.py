"""Judging over a band: why one frequency is not enough, in words that every answer shares."""

from collections.abc import Container

import numpy as np
import xarray as xr

from damperlab.studies.ground.variables import RECORD
from damperlab.studies.registry import is_survey
from damperlab.studies.vocabulary import Objective

FREQUENCY = "frequency_ratio"

WHY = (
    "A particle that rides on the wall moves the resonance, so judge a design over a band before building it."
)


def has_band(cube: xr.Dataset) -> bool:
    """Whether more than one frequency was computed."""
    return cube.sizes[FREQUENCY] > 1


def default_objective(cube: xr.Dataset, band: tuple[float, float] | None) -> Objective:
    """Name what designs are judged by where nobody says: the peak, wherever there is a band or one is asked for.

    A design that is superb at r = 1 can be terrible a few per cent away.
    """
    return "peak" if band is not None or has_band(cube) else "resonance"


def endured(cube: xr.Dataset) -> str:
    """Name the dimension that nobody chooses: the frequency ratio, in a survey the record."""
    return RECORD if is_survey(cube.sizes) else FREQUENCY


def worst_by_default(cube: xr.Dataset, used: Container[str | None]) -> bool:
    """Whether a slice that leaves open what is endured is the worst over it: it is where there is more than one.

    Parameters
    ----------
    cube : Dataset
        A study's cube.
    used : container of str
        Dimensions that the question fixes or runs along.
    """
    return endured(cube) not in used and cube.sizes[endured(cube)] > 1


def say_frequency(cube: xr.Dataset, r: float) -> str:
    """Say that an answer holds at one frequency, and what can be done about it."""
    if has_band(cube):
        return f"Judged at r = {r:.10g} alone; leave frequency_ratio out for the worst over the band."
    return f"Only one frequency was computed, r = {r:.10g}: the judgement holds at that frequency only. {WHY}"


def say_worst(cube: xr.Dataset) -> str:
    """Say that an answer is the largest value over the study's band, or over its records."""
    if is_survey(cube.sizes):
        return (
            f"The largest value over the survey's {cube.sizes[RECORD]} records; record_at says under which."
        )
    values = cube[FREQUENCY].values
    return (
        f"The largest value over the study's {values.size} frequencies from r = {values.min():.10g} to "
        f"{values.max():.10g}; frequency_ratio_at says where."
    )


def runs(r: np.ndarray, true: np.ndarray) -> list[list[float]]:
    """First and last value of each run of neighbours for which something holds."""
    edges = np.flatnonzero(np.diff(np.concatenate(([0], true.astype(np.int8), [0]))))
    return [[float(r[start]), float(r[end - 1])] for start, end in zip(edges[::2], edges[1::2], strict=True)]
