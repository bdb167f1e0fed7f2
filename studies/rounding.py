"""Recognise errors that are only rounding; used by the command line, the client and the page."""

from collections.abc import Container, Hashable

ROUNDING = 1e-9
"""Relative error up to which an error is attributed to floating-point rounding."""
ROUNDING_WORD = "rounding"
"""Word that tables show instead of an error that is only rounding. Sentences leave out such an error."""
VALUES_OF_ERROR = {
    "error": ("value",),
    "amplitude_error": ("amplitude_ratio", "hybrid"),
    "amplitude_error_m": ("amplitude_m",),
    "other_amplitude_error": ("other",),
}
"""For each error column, the columns that may contain the corresponding values."""


def value_of_error(name: str, names: Container[Hashable]) -> str | None:
    """Return the column in `names` whose errors are in column `name`; None if there is no such column."""
    return next((value for value in VALUES_OF_ERROR.get(name, ()) if value in names), None)


def is_rounding(value: float, error: float) -> bool:
    """Return whether an error is only rounding. Return False if the value or the error is NaN.

    Parameters
    ----------
    value, error : float
        A value and its error, in the same unit.
    """
    return error <= ROUNDING * abs(value)
