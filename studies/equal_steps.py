"""The step between equally spaced times, which a file contains in rounded form."""

import math
import re
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

UNEVEN = 0.02
"""Largest deviation of a time from equal steps, as a fraction of the step. For times with few digits,
rounding may cause a larger deviation, which is allowed.
"""
TOO_FEW_DIGITS = "The times have too few digits: the step between the samples cannot be determined."
"""Message for a step of NaN from `equal_step`."""
KNOWN = 1e-3
"""Steps with a whole number of samples in ten seconds, and steps of whole milliseconds, are tried only if the
relative uncertainty of the step is at most this value.
"""
MOST_LIKELY = 3.0
"""Whole sampling rates are tried if the possible sampling rates differ by less than this value [1/s]."""
LEAST_ROUNDED = 3
"""Smallest number of unequal steps that is attributed to rounding.

One or two unequal steps may mean missing samples.
"""


def resolution_of(written: Iterable[str]) -> float:
    """Return the place value of the last digit of the written numbers: 0.01 for 0.25. Return 0 if a number has an exponent."""
    decimals = 0
    for text in written:
        if re.search(r"[eEdD]", text):
            return 0.0
        decimals = max(decimals, len(text.partition(".")[2]))
    return 10.0**-decimals


def wrong_step(line: int, before: float, at: float, usual: float) -> tuple[str, str]:
    """Return a message and a remedy for a time [s] that breaks the equal steps.

    Parameters
    ----------
    line : int
        Number of the line with the time.
    before, at : float
        Time in the previous line, and time in this line.
    usual : float
        The median step.
    """
    if at <= before:
        told = (
            f"The time {at:g} s in line {line} is not later than {before:g} s before it; time must increase."
        )
        return told, "order the lines by time, remove repeated lines, and keep one record in a file"
    told = f"Line {line} has a step of {at - before:.6g} s, but the usual step is {usual:.6g} s; all time steps must be equal."
    if abs(at - before - usual) <= UNEVEN * usual:  # no step is wrong, but small deviations add up
        told = f"The time {at:.9g} s in line {line} is off by more than {100 * UNEVEN:g} % of a step; "
        told += "all time steps must be equal."
    return (
        told,
        "add the samples that are missing, write the times with more digits, or resample to equal steps",
    )


def equal_step(time: NDArray[np.float64], resolution: float) -> tuple[float, int | None]:
    """Find the step between times that were rounded to a resolution.

    Parameters
    ----------
    time : ndarray, shape (samples,)
        Times as written.
    resolution : float
        Value of the last digit of the times, in the unit of the times.

    Returns
    -------
    step : float
        Step in the unit of the times. If rounding made the steps unequal, three kinds of steps are tried in this order:
        whole samples per unit, whole samples in ten units, and whole thousandths of the unit. The step must agree with
        all times. The result is NaN if no step agrees, or if several steps of one kind agree. If a sample breaks the
        equal steps, the result is the median step.
    wrong : int or None
        Index of the first sample that breaks the equal steps; None if the steps are equal.
    """
    counts = np.arange(time.size)
    steps = np.diff(time)
    step = float(time[-1] - time[0]) / steps.size
    usual = float(np.median(steps))
    if step <= 0.0:
        return usual, int(np.argmin(steps)) + 1
    off = np.abs(time - (time[0] + step * counts))
    if off.max() <= UNEVEN * step:
        return step, None
    odd = np.abs(steps - usual) > UNEVEN * usual
    beyond = (np.abs(steps - usual) > max(UNEVEN * usual, 1.01 * resolution)) | (steps < 0.0)
    if beyond.any() or odd.sum() < LEAST_ROUNDED:
        wrong = beyond if beyond.any() else odd if odd.any() else off[1:] > UNEVEN * step
        return usual, int(np.argmax(wrong)) + 1
    open_by = resolution / steps.size
    low, high = 1.0 / (step + open_by), 1.0 / max(step - open_by, 1e-300)
    likely = [1.0 / np.arange(np.ceil(low), np.floor(high) + 1.0)] if high - low < MOST_LIKELY else []
    if open_by <= KNOWN * step:
        likely += [
            10.0 / np.arange(np.ceil(10.0 * low), np.floor(10.0 * high) + 1.0),
            1e-3 * np.round([1e3 * step]),
        ]
    for steps_of in likely:
        agree = [float(one) for one in steps_of if np.ptp(time - one * counts) <= 1.01 * resolution]
        if agree:
            return agree[0] if len(agree) == 1 else math.nan, None
    return math.nan, None
