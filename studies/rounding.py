"""Which errors are rounding: what the command line, the client and the page say of them is decided here."""

ROUNDING = 1e-9
"""An error below this share of its value is that of floating-point arithmetic; nobody can measure it."""
ROUNDING_WORD = "rounding"
"""Stands in a table for such an error; in a sentence it is left out."""
VALUE_OF_ERROR = {
    "error": "value",
    "amplitude_error": "amplitude_ratio",
    "amplitude_error_m": "amplitude_m",
    "other_amplitude_error": "other",
}
"""The value beside which each column of errors stands."""


def is_rounding(value: float, error: float) -> bool:
    """Tell whether an error is rounding; never where the value or the error is not known.

    Parameters
    ----------
    value, error : float
        In one unit.
    """
    return error <= ROUNDING * abs(value)
