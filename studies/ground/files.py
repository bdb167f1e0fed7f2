"""Records from files: PEER's AT2, and two columns of time and acceleration. Every fault names its line."""

import re
from typing import Literal

import numpy as np

from damperlab.studies.decoded import decoded
from damperlab.studies.equal_steps import TOO_FEW_DIGITS, equal_step, resolution_of
from damperlab.studies.faults import counted, describe, listing, printable
from damperlab.studies.ground.heading import (
    acceleration_unit,
    check_format,
    check_quantity,
    second_of,
    split_heading,
    unit_in_lines,
    unit_of_column,
)
from damperlab.studies.ground.motion import GroundMotion, checked, refused
from damperlab.studies.spelled_numbers import COMMAS_FOUND, WRITE_POINTS, decimal_comma
from damperlab.studies.vocabulary import ACCELERATION_UNITS as UNITS

Layout = Literal["at2", "csv"]

MOST_BYTES = 16 * 1024 * 1024

_NUMBER = r"[+-]?(?:\d+(?:\.\d*)?|\.\d+)(?:[EeDd][+-]?\d{1,3})?"
# Fortran writes columns of fixed width: a minus sign may follow the last digit of the number before it.
_NUMBERS = re.compile(rf"\s*(?:{_NUMBER}(?=[\s+-]|$)\s*)+$")
_ONE = re.compile(_NUMBER)
_MODERN = re.compile(rf"NPTS\s*=\s*(\d+)\s*,?\s*DT\s*=\s*({_NUMBER})", re.IGNORECASE)
_OLD = re.compile(rf"\s*(\d+)\s+({_NUMBER})\s+NPTS\s*,\s*DT", re.IGNORECASE)
_HEADER_LINES = 10
_LONGEST_LINE = 1000


def read_record(text: bytes | str, layout: Layout, name: str = "", units: str | None = None) -> GroundMotion:
    """Read a record.

    Parameters
    ----------
    text : bytes or str
        The file; bytes are UTF-8, UTF-16 with its mark or, as old files are, Latin-1.
    layout : {"at2", "csv"}
        PEER's AT2; or two columns, time and acceleration, apart by comma, semicolon, tab or blanks; times in s, or in ms
        where the heading says so. In place of columns a line with the number of samples and the step [s] may stand before
        one sample a line. Text that announces itself as AT2 is read as such.
    name : str
        Name of the record; by default what an AT2 file calls it.
    units : {"g", "m/s2", "cm/s2"}, optional
        Of the acceleration. Needed where the file does not say: an AT2 file does in its third line, columns may in
        their heading, as in ``time (s), acc (g)``. What the file says may be repeated and not contradicted.

    Raises
    ------
    StudyFaults
        With the line and what is wrong in it.
    """
    if len(text) > MOST_BYTES:
        raise refused(
            "record",
            f"{len(text):,} bytes",
            f"a file of at most {MOST_BYTES:,} bytes",
            "cut or resample the record",
        )
    if units is not None and units not in UNITS:
        raise refused(
            "units", describe(units), f"one of {listing(UNITS)}", "write the unit of the acceleration"
        )
    # Only these end a line: splitlines() would also split at odd characters and miscount.
    lines = decoded(text).replace("\r\n", "\n").replace("\r", "\n").split("\n")
    for number, line in enumerate(lines, start=1):
        if len(line) > _LONGEST_LINE:
            found = f"{len(line):,} characters"
            allowed = f"at most {_LONGEST_LINE:,} characters long"
            raise refused(_at(number), found, allowed, "give a text file of short lines")
    check_format(lines)
    is_at2 = layout == "at2" or any(_MODERN.search(line) for line in lines[:_HEADER_LINES])
    return _read_at2(lines, name, units) if is_at2 else _read_columns(lines, name, units)


def _at(number: int) -> str:
    return f"line {number}"


def _read_at2(lines: list[str], name: str, units: str | None) -> GroundMotion:
    index, found = _header(lines)
    if found is None:
        place = _at(min(4, len(lines)))
        seen = printable(lines[min(3, len(lines) - 1)])
        raise refused(
            place,
            seen,
            "of the form NPTS=<number>, DT=<number>",
            "give a complete PEER file (.AT2), or name the format csv for two columns",
        )
    header, count, step = index + 1, int(found[1][:12]), _float(found[2])
    heading = lines[:index]
    third = _at(min(3, max(1, len(heading))))
    check_quantity(heading, third)
    factor = UNITS[acceleration_unit(unit_in_lines(heading), units, third)]
    samples: list[float] = []
    for number, line in enumerate(lines[index + 1 :], start=header + 1):
        if not line.strip():
            continue
        if not _NUMBERS.match(line):
            raise refused(
                _at(number),
                printable(line.strip()),
                "numbers only",
                "correct the line, or remove it if it is not data",
            )
        samples.extend(_float(one) for one in _ONE.findall(line))
        if len(samples) > count:
            allowed = f"{count:,} samples, as line {header} says"
            told = f"Line {number} holds sample {len(samples):,}, but line {header} announces only {count:,} samples."
            advice = "correct NPTS, or remove the surplus samples"
            raise refused(_at(number), f"sample {len(samples):,}", allowed, advice, told)
    if len(samples) < count:
        found_here = f"the end after {len(samples):,} samples"
        allowed = f"{count:,} samples, as line {header} says"
        told = f"The file ends after {len(samples):,} samples, but line {header} announces {count:,}."
        raise refused(_at(len(lines)), found_here, allowed, "give the complete file, or correct NPTS", told)
    title = ", ".join(line.strip() for line in heading[1:2] if line.strip())
    return checked(
        GroundMotion(name or title[:200] or "record", step, np.array(samples) * factor, title[:200]),
        _at(header),
    )


def _header(lines: list[str]) -> tuple[int, re.Match[str] | None]:
    """Find the line that says how many samples follow, at which step."""
    for index, line in enumerate(lines[:_HEADER_LINES]):
        if found := _MODERN.search(line) or _OLD.match(line):
            return index, found
    return 0, None


def _read_columns(lines: list[str], name: str, units: str | None) -> GroundMotion:
    headings: list[str] = []
    rows: list[list[str]] = []
    places: list[int] = []
    for number, line in enumerate(lines, start=1):
        bare = line.strip()
        if not bare or bare.startswith("#"):
            if bare.strip("# ") and not rows:
                headings.append(bare.lstrip("# "))
            continue
        cells = [cell.strip('"') for cell in re.split(r"[,;\t]|\s+", bare) if cell.strip('"')]
        if not rows and not any(map(_ONE.fullmatch, cells)):
            headings.append(bare)
            continue
        # apart by commas, a line has no cells by the other signs
        apart = [cell for cell in re.split(r"[;\t]|\s+", bare) if cell]
        if len(apart) == 2 and decimal_comma(apart):
            raise refused(_at(number), printable(bare), "decimal points", WRITE_POINTS, COMMAS_FOUND)
        if not all(map(_ONE.fullmatch, cells)):
            allowed = "two numbers, time in s and acceleration"
            raise refused(_at(number), printable(bare), allowed, "correct the line, or remove it")
        rows.append(cells)
        places.append(number)
    if len(rows) < 2:
        raise refused(
            _at(len(lines)),
            f"the end after {len(rows)} rows",
            "two rows or more",
            "give time and acceleration, one sample on each line",
            f"The file has {counted(len(rows), 'row')} of numbers; a record needs at least two.",
        )
    time_heading, other_heading = split_heading(headings[-1] if headings else "")
    check_quantity([other_heading], "acceleration")
    stated = unit_of_column(other_heading) or unit_in_lines(headings[:-1])
    factor = UNITS[acceleration_unit(stated, units)]
    if len(rows[0]) == 2 and all(len(cells) == 1 for cells in rows[1:]):
        step, numbers = _announced(rows, places)
    else:
        _check_width(rows, places)
        step, numbers = _between(rows, places, time_heading), [_float(cells[1]) for cells in rows]
    return checked(
        GroundMotion(name or "record", step, np.array(numbers) * factor, "columns"), _at(places[0])
    )


def _announced(rows: list[list[str]], places: list[int]) -> tuple[float, list[float]]:
    """Give step and samples of one value a line, behind a line with their number and the step."""
    count, step = (_float(cell) for cell in rows[0])
    if count != len(rows) - 1:
        allowed = f"{count:g} samples, as line {places[0]} says"
        told = f"The file has {counted(len(rows) - 1, 'sample')}, but line {places[0]} announces {count:g}."
        raise refused(_at(places[-1]), f"{len(rows) - 1:,} samples", allowed, "give the complete file", told)
    return step, [_float(cells[0]) for cells in rows[1:]]


def _check_width(rows: list[list[str]], places: list[int]) -> None:
    for cells, number in zip(rows, places, strict=True):
        if len(cells) == 2:
            continue
        advice = "correct the line, or remove it"
        if len(cells) > 2:
            advice = "keep the time and the one acceleration that you mean"
        if len(cells) == 1:
            advice = "write the time before it, or begin the file with a line of the number of samples and the step in s"
        found = counted(len(cells), "number")
        raise refused(_at(number), found, "two numbers, time in s and acceleration", advice)


def _between(rows: list[list[str]], places: list[int], heading: str) -> float:
    """Find the step [s] between the times of two columns."""
    second = second_of(heading)
    written = [cells[0] for cells in rows]
    time = np.array([_float(each) for each in written])
    if not re.search(r"\w", heading) and time.size > 2 and _counts(written):
        told = "The first column counts the samples, and nothing says that it is a time."
        advice = "write the times of the samples, or a heading `time (s), ...` where they are seconds"
        raise refused("time", "1, 2, 3, …", "a column of times", advice, told)
    step, wrong = equal_step(second * time, second * resolution_of(written))
    if np.isnan(step):
        advice = (
            "write the times with more digits, or the number of samples and the step above one value a line"
        )
        raise refused("time", f"times such as {written[-1]}", "a known time step", advice, TOO_FEW_DIGITS)
    if wrong is None:
        return step
    if step <= 0.0:
        told = f"The last time, {time[-1]:g} s, is not later than the first; time must increase."
        found = f"the time {time[-1]:g} s at the end"
        raise refused(_at(places[-1]), found, "a time that grows", "order the lines by time", told)
    found = f"a step of {second * (time[wrong] - time[wrong - 1]):.6g} s after steps of {step:.6g} s"
    told = f"Line {places[wrong]} has {found}; all time steps must be equal."
    advice = "write the times with more digits, or resample the record to equal steps"
    raise refused(_at(places[wrong]), found, "equal time steps", advice, told)


def _counts(written: list[str]) -> bool:
    """Whether numbers are 0, 1, 2, … or 1, 2, 3, …"""
    return written == [str(i + int(written[0] == "1")) for i in range(len(written))]


def _float(text: str) -> float:
    return float(text.replace("D", "E").replace("d", "e"))
