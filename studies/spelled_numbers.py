"""Advice on texts in place of numbers: the probable meaning, and the correct spelling."""

import math
import re
from collections.abc import Iterable, Sequence

from damperlab.studies.faults import Fault

_NUMBER = r"[-+]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][-+]?[0-9]+)?"
_FORTRAN = re.compile(_NUMBER.replace("eE", "eEdD"))
_PLAIN = re.compile(rf"\s*({_NUMBER})\s*\Z")
_COMMA = re.compile(r"\s*([-+]?[0-9]+),([0-9]+)\s*\Z")
_DECIMAL_COMMA = re.compile(r"\s*\"?[-+]?[0-9]+,[0-9]+(?:[eE][-+]?[0-9]+)?\"?\s*\Z")
_COMMA_OF_THOUSANDS = re.compile(r"\s*\"?[-+]?[0-9]{1,3}(?:,[0-9]{3})+\.[0-9]*\"?\s*\Z")
_PERCENT = re.compile(rf"\s*({_NUMBER})\s*%\s*\Z")
_WITH_UNIT = re.compile(rf"\s*{_NUMBER}\s*([^\W\d_][^\s]{{0,9}}|″|\")\s*\Z")
_SPAN = re.compile(rf"\s*({_NUMBER})\s*(?:-|–|—|\.\.+|…|:|to|bis)\s*({_NUMBER})\s*\Z")
NUMBER_ALONE = "write a plain number"
QUOTED = "write a plain number, without quotation marks"
WRITE_POINTS = (
    "write decimal points, and no separators between thousands; a spreadsheet writes decimal points if its "
    "number format is English"
)
COMMAS_FOUND = "{field} has a number with a decimal comma, or with a comma between thousands."
"""Message about a table, shown once instead of for each number."""
_THOUSANDS = 3
"""Number of digits after a comma that may separate thousands."""
_MARKS = (999.0, 9999.0, 99999.0, 999999.0)
"""Sizes of numbers that mark missing samples in files of measured data."""
_FAR_BEYOND = 10.0
"""Smallest ratio of such a number to the largest other sample."""
_LONGEST = 60
"""Largest length of an examined text; real numbers are shorter."""


def number_advice(raw: object, unit: str | None = None) -> str:
    """Return advice on how to write the number that a text probably means.

    Parameters
    ----------
    raw : object
        The value found.
    unit : str, optional
        The unit of the key; empty for a ratio, None if unknown.
    """
    if not isinstance(raw, str) or len(raw) > _LONGEST:
        return NUMBER_ALONE
    if _PLAIN.match(raw):
        return QUOTED
    if comma := _COMMA.match(raw):
        point = f"use a decimal point, as in {comma[1]}.{comma[2]}"
        if len(comma[2]) == _THOUSANDS and comma[1].lstrip("+-") != "0":
            return f"{point}, or write {comma[1]}{comma[2]} if thousands are meant; a number has no commas"
        return f"{point}; a number has no commas"
    if percent := _PERCENT.match(raw):
        if unit:
            return f"write the number alone, in {unit}"
        return f"write the share as a number: {percent[1]} % is {float(percent[1]) / 100.0:.12g}"
    if _WITH_UNIT.match(raw):
        if unit:
            return f"write the number alone, in {unit}: the key states its unit"
        if unit is None:
            return "write the number alone, without a unit"
        return "write the number alone: it is a ratio, without a unit"
    return NUMBER_ALONE


def read_decimal(text: str) -> float:
    """Read a plain number, or a Fortran number with a D before the exponent; return NaN for other texts."""
    return float(text.lower().replace("d", "e")) if _FORTRAN.fullmatch(text) else math.nan


def decimal_comma(cells: Iterable[str]) -> str | None:
    """Return the first cell that is a number with a decimal comma, or None."""
    return next((cell for cell in cells if _DECIMAL_COMMA.match(cell)), None)


def comma_of_thousands(cells: Iterable[str]) -> str | None:
    """Return the first cell that is a number with a decimal point and commas between thousands, or None."""
    return next((cell for cell in cells if _COMMA_OF_THOUSANDS.match(cell)), None)


def range_advice(raw: object) -> str:
    """Return advice on how to write a range if a text looks like a range, else an empty text."""
    if not isinstance(raw, str) or len(raw) > _LONGEST or not (span := _SPAN.match(raw)):
        return ""
    return f"write a range as {{start: {span[1]}, stop: {span[2]}, num: 11}}, with as many values as you need"


def fault_of_marks(samples: Sequence[float], lines: Sequence[int]) -> Fault | None:
    """Return the fault of the first sample that marks a missing one, such as −9999 far beyond all others.

    Parameters
    ----------
    samples : sequence of float
        The numbers as written.
    lines : sequence of int
        Line of each sample.
    """
    marks = [at for at, sample in enumerate(samples) if abs(sample) in _MARKS]
    largest = max((abs(sample) for sample in samples if abs(sample) not in _MARKS), default=math.inf)
    if not marks or min(abs(samples[at]) for at in marks) < _FAR_BEYOND * largest:
        return None
    found, line = f"{samples[marks[0]]:g}", lines[marks[0]]
    told = f"The number {found} in line {line} is far beyond all others; it seems to mark a missing sample."
    advice = "replace each of these numbers by an interpolated value, or cut the table"
    return Fault(f"line {line}", found, "a measured value", advice, told)
