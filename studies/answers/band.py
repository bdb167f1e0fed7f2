"""Judging over a band of frequencies, and the sentences that explain why one frequency is not enough."""

from collections.abc import Container
from typing import TYPE_CHECKING

import numpy as np

from damperlab.studies.answers.phrases import RATIOS, Phrases
from damperlab.studies.kinds import kind_of
from damperlab.studies.vocabulary import Objective

if TYPE_CHECKING:
    import xarray as xr

FREQUENCY = "frequency_ratio"

WHY = (
    "A particle that stays on the wall shifts the resonance, so judge a design over a band before building "
    "it."
)


def has_band(cube: "xr.Dataset") -> bool:
    """Whether more than one frequency was computed."""
    return cube.sizes[FREQUENCY] > 1


def default_objective(cube: "xr.Dataset", band: tuple[float, float] | None) -> Objective:
    """Name the default objective: the peak, if the study or the question has a band.

    A design that is superb at r = 1 can be terrible a few per cent away.
    """
    return "peak" if band is not None or has_band(cube) else "resonance"


def worst_by_default(cube: "xr.Dataset", used: Container[str | None]) -> bool:
    """Whether the uncontrolled dimension is reduced to its worst value: if the question does not use it and it has
    several values.

    Parameters
    ----------
    cube : Dataset
        A study's cube.
    used : container of str
        Dimensions that the question fixes, or along which the answer runs.
    """
    name = kind_of(cube.sizes).uncontrolled
    return name not in used and cube.sizes[name] > 1


def say_frequency(cube: "xr.Dataset", r: float, codes: bool = False, phrases: Phrases = RATIOS) -> str:
    """Say that an answer applies to one frequency, and how to change that. If the answer shows `codes`, they have no
    largest value over the band.
    """
    at = phrases.equal(FREQUENCY, r, ".10g")
    if has_band(cube) and codes:
        name = "frequency_hz" if phrases.unit(FREQUENCY) else FREQUENCY
        return (
            f"Shown at {at} alone: a class or a code has no largest value over the band. Name another frequency "
            f"with `{name}`, or ask for a quantity."
        )
    if has_band(cube):
        return f"Judged at {at} alone; leave out the frequency to judge by the largest value over the band."
    return f"Only one frequency was computed, {at}: the judgement applies to that frequency alone. {WHY}"


def say_worst(cube: "xr.Dataset", phrases: Phrases = RATIOS) -> str:
    """Say that an answer is the largest value over the uncontrolled dimension: the study's band, or its records."""
    kind = kind_of(cube.sizes)
    values = sorted(cube[kind.uncontrolled].values.tolist())
    band = phrases.span(FREQUENCY, values[0], values[-1], ".10g") if kind.uncontrolled == FREQUENCY else ""
    words = kind.worst.format(count=len(values), band=band)
    return words


def runs(r: np.ndarray, true: np.ndarray) -> list[list[float]]:
    """First and last value of each run of neighbours that satisfy a condition."""
    edges = np.flatnonzero(np.diff(np.concatenate(([0], true.astype(np.int8), [0]))))
    return [[float(r[start]), float(r[end - 1])] for start, end in zip(edges[::2], edges[1::2], strict=True)]
