"""The step between times that are equally spaced and were rounded when they were written."""

import math
import re
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

UNEVEN = 0.02
"""Largest difference of a time from equal steps, over a step. Times with few digits may differ by more."""
TOO_FEW_DIGITS = "The times have too few digits: they leave open how far apart the samples are."
"""What is said where the step is NaN."""
KNOWN = 1e-3
"""Largest uncertainty of a step, over the step."""


def resolution_of(written: Iterable[str]) -> float:
    """Give the last digit of numbers as they are written: 0.01 of 0.25; 0 where one has an exponent."""
    decimals = 0
    for text in written:
        if re.search(r"[eEdD]", text):
            return 0.0
        decimals = max(decimals, len(text.partition(".")[2]))
    return 10.0**-decimals


def equal_step(time: NDArray[np.float64], resolution: float) -> tuple[float, int | None]:
    """Find the step between times that were rounded to a resolution.

    Parameters
    ----------
    time : ndarray, shape (samples,)
        As written.
    resolution : float
        In the unit of the times.

    Returns
    -------
    step : float
        In the unit of the times. Where the digits leave it open, that of the one whole number of samples a second (or per
        unit) which agrees, NaN where several do; 0 or less where the times do not rise.
    wrong : int or None
        Sample that does not follow the others; None where all steps are equal.
    """
    count = time.size - 1
    step = float(time[-1] - time[0]) / count
    if step <= 0.0:
        return step, int(np.argmax(np.diff(time) <= 0.0)) + 1
    open_by = resolution / count
    off = np.abs(time - (time[0] + step * np.arange(time.size)))
    wrong = off > max(UNEVEN * step, 1.01 * resolution)
    if wrong.any():
        steps = np.diff(time)
        usual = float(np.median(steps))
        return step, int(np.argmax(np.abs(steps - usual) > max(UNEVEN * abs(usual), 1.01 * resolution))) + 1
    if off.max() <= UNEVEN * step:
        return step, None
    low, high = 1.0 / (step + open_by), 1.0 / max(step - open_by, 1e-300)
    rates = np.arange(np.ceil(low), np.floor(high) + 1.0) if high - low < 3.0 else np.empty(0)
    if rates.size == 1:
        return float(1.0 / rates[0]), None
    return (step if open_by <= KNOWN * step else math.nan), None
