"""The fitted response between the measured frequencies."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.fit.fitted import Fitted
from damperlab.studies.plan import Block
from damperlab.worker.block import solve_block

VALUES = 161
ALONE = 0.1
"""Share of the frequency that a curve reaches beyond a single measured frequency."""


@dataclass(frozen=True)
class FittedCurve:
    """A response over frequency.

    Attributes
    ----------
    frequency, amplitude : ndarray, shape (values,)
        In the measurement's units; NaN where a response failed.
    """

    frequency: NDArray[np.float64]
    amplitude: NDArray[np.float64]


def curves_of(fitted: Fitted) -> list[FittedCurve]:
    """Compute the fitted response of each of the question's configurations over the measured band."""
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
