"""Decides which errors are only rounding, for the command line, the client and the page."""

from collections.abc import Container, Hashable

ROUNDING = 1e-9
"""An error below this share of its value is floating-point rounding, and cannot be measured."""
ROUNDING_WORD = "rounding"
"""Shown in a table instead of such an error; a sentence omits it."""
VALUES_OF_ERROR = {
    "error": ("value",),
    "amplitude_error": ("amplitude_ratio", "hybrid"),
    "amplitude_error_m": ("amplitude_m",),
    "other_amplitude_error": ("other",),
}
"""For each column of errors, the values whose errors it may hold."""


def value_of_error(name: str, names: Container[Hashable]) -> str | None:
    """Name the value among `names` whose error a column holds; None if it holds no errors, or errors of another
    value.
    """
    return next((value for value in VALUES_OF_ERROR.get(name, ()) if value in names), None)


def is_rounding(value: float, error: float) -> bool:
    """Tell whether an error is rounding; never if the value or the error is unknown.

    Parameters
    ----------
    value, error : float
        In the same unit.
    """
    return error <= ROUNDING * abs(value)
