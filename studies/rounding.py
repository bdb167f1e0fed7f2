"""Which errors are rounding: what the command line, the client and the page say of them is decided here."""

from collections.abc import Container, Hashable

ROUNDING = 1e-9
"""An error below this share of its value is that of floating-point arithmetic; nobody can measure it."""
ROUNDING_WORD = "rounding"
"""Stands in a table for such an error; in a sentence it is left out."""
VALUES_OF_ERROR = {
    "error": ("value",),
    "amplitude_error": ("amplitude_ratio", "hybrid"),
    "amplitude_error_m": ("amplitude_m",),
    "other_amplitude_error": ("other",),
}
"""The values beside which each column of errors may stand, whichever of them an answer has."""


def value_of_error(name: str, names: Container[Hashable]) -> str | None:
    """Name the value among `names` whose error a column holds; None where it holds no errors, or none of that."""
    return next((value for value in VALUES_OF_ERROR.get(name, ()) if value in names), None)


def is_rounding(value: float, error: float) -> bool:
    """Tell whether an error is rounding; never where the value or the error is not known.

    Parameters
    ----------
    value, error : float
        In one unit.
    """
    return error <= ROUNDING * abs(value)
