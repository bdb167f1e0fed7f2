"""Decide whether designs are judged over a band of frequencies, and explain why one frequency is not enough."""

from collections.abc import Container
from typing import TYPE_CHECKING

import numpy as np

from damperlab.studies.answers.phrases import FREQUENCY, Phrases
from damperlab.studies.kinds import kind_of
from damperlab.studies.vocabulary import Objective

if TYPE_CHECKING:
    import xarray as xr

WHY = (
    "A particle that stays on the wall shifts the resonance, so judge a design over a band before building "
    "it."
)


def has_band(cube: "xr.Dataset") -> bool:
    """Whether more than one frequency was computed."""
    return cube.sizes[FREQUENCY] > 1


def default_objective(cube: "xr.Dataset", band: tuple[float, float] | None) -> Objective:
    """Return the default objective: the peak if the study or the question has a band, otherwise the resonance."""
    return "peak" if band is not None or has_band(cube) else "resonance"


def worst_by_default(cube: "xr.Dataset", used: Container[str | None]) -> bool:
    """Whether an answer takes the worst value over the uncontrolled dimension (frequency or ground-motion record).

    The worst value is taken if the dimension has several values and the question does not use the dimension.

    Parameters
    ----------
    cube : Dataset
        A study's cube.
    used : container of str
        Dimensions that the question fixes, or along which the answer runs.
    """
    name = kind_of(cube.sizes).uncontrolled
    return name not in used and cube.sizes[name] > 1


def say_frequency(cube: "xr.Dataset", r: float, codes: bool, phrases: Phrases) -> str:
    """Say that an answer applies to one frequency. `codes` states whether the answer shows codes, which have no maximum."""
    at = phrases.equal(FREQUENCY, r, ".10g")
    if has_band(cube) and codes:
        name = "frequency_hz" if phrases.unit(FREQUENCY) else FREQUENCY
        return (
            f"Shown at {at} alone: a class or a code has no largest value over the band. Name another frequency "
            f"with `{name}`, or ask for a quantity."
        )
    if has_band(cube):
        return f"Judged at {at} alone; leave out the frequency to judge by the largest value over the band."
    return say_only(r, True, phrases)


def say_only(r: float, computed: bool, phrases: Phrases) -> str:
    """Say that designs are judged at one frequency.

    If `computed` is True, say that the study has only this frequency.
    """
    why = "was computed" if computed else "is judged"
    at = phrases.equal(FREQUENCY, r, ".10g")
    return f"Only one frequency {why}, {at}: the judgement applies to that frequency alone. {WHY}"


def say_worst(cube: "xr.Dataset", phrases: Phrases) -> str:
    """Say that an answer shows the largest values over the band, or over the ground-motion records."""
    kind = kind_of(cube.sizes)
    values = sorted(cube[kind.uncontrolled].values.tolist())
    band = phrases.span(FREQUENCY, values[0], values[-1], ".10g") if kind.uncontrolled == FREQUENCY else ""
    return kind.worst.format(count=len(values), band=band)


def runs(r: np.ndarray, true: np.ndarray) -> list[list[float]]:
    """Return the first and the last value of each run of neighbouring values `r` at which `true` holds."""
    edges = np.flatnonzero(np.diff(np.concatenate(([0], true.astype(np.int8), [0]))))
    return [[float(r[start]), float(r[end - 1])] for start, end in zip(edges[::2], edges[1::2], strict=True)]
