"""Computes the response of a prototype at the rows of a measurement, and fitted response curves."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.fit.fitted import Fitted
from damperlab.studies.fit.question import FitQuestion
from damperlab.studies.plan import Block
from damperlab.studies.variables import Status
from damperlab.worker.block import solve_block
from damperlab.worker.scenes import Scene, scenes

Column = NDArray[np.float64]


@dataclass(frozen=True)
class Responses:
    """Computed results at the rows of a measurement, each of shape (rows,).

    Attributes
    ----------
    amplitude, error : ndarray
        Amplitude and its error in the unit of the measurement; NaN if the response failed or is unbounded.
    impacts_per_cycle, stick_fraction : ndarray
        Number of impacts per cycle, and fraction of time in which the structure sticks.
    response_class : ndarray
        Value of `damperlab.studies.variables.ResponseClass`.
    """

    amplitude: Column
    error: Column
    impacts_per_cycle: Column
    stick_fraction: Column
    response_class: Column


def responses_at(question: FitQuestion, values: Mapping[str, float]) -> Responses:
    """Compute the steady response at every row of a measurement.

    Parameters
    ----------
    question : FitQuestion
        Question with the known values and the measured rows.
    values : mapping of float
        Values of the estimated parameters.
    """
    found = {name: np.full(question.measured.rows, np.nan) for name in Responses.__dataclass_fields__}
    for conditions, rows in question.configurations:
        given = question.given(values, conditions)
        ratios, place = np.unique(question.ratios(given, rows), return_inverse=True)
        study = question.study(given, ratios.tolist())
        block = solve_block(study, Block.whole(study.shape))
        solved = {name: column.reshape(-1)[place] for name, column in block.items()}
        good = np.isfinite(solved["amplitude_ratio"]) & (solved["status"] <= Status.MAX_CYCLES)
        scale = question.scale(given)
        found["amplitude"][rows] = np.where(good, solved["amplitude_ratio"] * scale, np.nan)
        found["error"][rows] = np.where(good, np.nan_to_num(solved["amplitude_error"]) * scale, np.nan)
        for name in ("impacts_per_cycle", "stick_fraction", "response_class"):
            found[name][rows] = solved[name]
    return Responses(**found)


def scenes_of(question: FitQuestion) -> list[Scene]:
    """Return the scenes that a fit may need.

    They are found with all parameters at the lower ends of their ranges, and with all at the upper ends.
    """
    found = set()
    for conditions, rows in question.configurations:
        for share in (0.0, 1.0):
            given = question.given(question.values(np.full(len(question.free), share)), conditions)
            found.update(scenes(question.study(given, [float(question.ratios(given, rows)[0])])))
    return sorted(found)


VALUES = 161
ALONE = 0.1
"""Fraction of a single measured frequency by which a curve extends to either side."""


@dataclass(frozen=True)
class FittedCurve:
    """A fitted response over frequency.

    Attributes
    ----------
    frequency, amplitude : ndarray, shape (values,)
        Frequency and amplitude in the units of the measurement; NaN for the amplitude if a response failed.
    """

    frequency: NDArray[np.float64]
    amplitude: NDArray[np.float64]


def curves_of(fitted: Fitted) -> list[FittedCurve]:
    """Compute the fitted response over the measured band for each configuration of the question."""
    question = fitted.question
    frequency = question.measured.frequency
    low, high = float(frequency.min()), float(frequency.max())
    if high - low < ALONE * low:
        low, high = (1.0 - ALONE) * low, (1.0 + ALONE) * high
    band = np.linspace(low, high, VALUES)
    found = []
    for conditions, _ in question.configurations:
        given = question.given(fitted.values, conditions)
        ratios = band / given["natural_frequency_hz"] if question.measured.in_hertz else band
        study = question.study(given, ratios.tolist())
        block = solve_block(study, Block.whole(study.shape))
        found.append(FittedCurve(band, block["amplitude_ratio"].reshape(-1) * question.scale(given)))
    return found
