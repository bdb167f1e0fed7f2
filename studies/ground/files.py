"""Reads records from AT2 files of PEER, or from files with two columns, time and acceleration."""

import re
from collections.abc import Sequence
from itertools import pairwise
from math import isclose
from typing import Literal

import numpy as np

from damperlab.studies.decoded import check_end, lines_in
from damperlab.studies.equal_steps import TOO_FEW_DIGITS, UNEVEN, equal_step, resolution_of, wrong_step
from damperlab.studies.faults import StudyFaults, counted, describe, listing, printable
from damperlab.studies.ground.heading import COLUMNS, WRITE_STEP, Line, check_format, read_heading
from damperlab.studies.ground.motion import GroundMotion, checked, refused
from damperlab.studies.spelled_numbers import (
    COMMAS_FOUND,
    WRITE_POINTS,
    decimal_comma,
    fault_of_marks,
    read_decimal,
)
from damperlab.studies.written_units import ACCELERATIONS, TIMES, kind_of, usual

Layout = Literal["at2", "csv"]
Row = tuple[int, list[str]]
"""Number of a line, and the text of each number in the line."""

MOST_BYTES = 16 * 1024 * 1024

_NUMBER = r"[+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[EeDd][+-]?[0-9]{1,3})?"
# Fortran writes columns of fixed width: a minus sign may directly follow the previous number.
_NUMBERS = re.compile(rf"\s*(?:{_NUMBER}(?=[\s+-]|$)\s*)+$")
_ONE = re.compile(_NUMBER)
_BEGIN = re.compile(
    rf"NPTS\s*[=:]\s*(\d+)\s*[,;]?\s*DT\s*[=:]\s*({_NUMBER})[ \t]*\(?([a-zµμ]*)|(\d+)\s+({_NUMBER})\s+NPTS\s*,\s*DT",
    re.IGNORECASE,
)
"""Pattern of the line of an AT2 file that states the number of samples and the step."""
_NO_STEP = re.compile(rf"DT[ \t]*[=:][ \t]*(?>{_NUMBER})[ \t]*(?:[/×*^+-]|x\b|,?\d).*", re.IGNORECASE)
"""Pattern of a time step that is more than one number, such as 1/200."""
_ANNOUNCING = re.compile(r"^.*\bNPTS\b.*$", re.IGNORECASE | re.MULTILINE)
_NO_EXPONENT = re.compile(r"([+-]?\d*\.\d*)([+-]\d{2,3})")
"""Pattern of a number that lacks the E before its exponent, as Fortran may write it."""
_NO_WORD = re.compile(rf"{_NUMBER}|[+-]?(?:nan|inf)|n/?a|null|none|-+|\*+", re.IGNORECASE)
"""Pattern of a cell that holds a number or marks a missing value."""
_BEFORE_THOUSANDS, _THOUSANDS = re.compile(r"[+-]?[1-9][0-9]{0,2}"), re.compile(r"[0-9]{3}(?![0-9])")
_HEADER_LINES = 10
_LONGEST_LINE = 1000
_LONG_STEP_S = 0.1
"""Smallest time step [s] that is refused if the file states no unit of time: the column may contain row
numbers or milliseconds.
"""


def read_record(text: bytes | str, layout: Layout, name: str = "", units: str | None = None) -> GroundMotion:
    """Read a record.

    Parameters
    ----------
    text : bytes or str
        Content of the file. Bytes are decoded as UTF-8, UTF-16 or, in old files, Latin-1.
    layout : {"at2", "csv"}
        ``"at2"`` is the format of PEER. ``"csv"`` has two columns, time and acceleration, separated by comma,
        semicolon, tab or blanks. Times are in s, or in the unit that the heading states. In a file without times, a
        line with the number of samples and the step [s] precedes the samples. Text with the heading of an AT2 file is
        always read as AT2.
    name : str
        Name of the record; by default the title in an AT2 file.
    units : str, optional
        Unit of the acceleration in any spelling, required if the file does not state the unit. An AT2 file states the
        unit in line 3; columns may have a heading with the unit, as in ``time (s), acc (g)``. `units` must not
        contradict the file.

    Raises
    ------
    StudyFaults
        If the file is invalid; the fault names the line.
    """
    if len(text) > MOST_BYTES:
        allowed = f"a file of at most {MOST_BYTES:,} bytes"
        raise refused("record", f"{len(text):,} bytes", allowed, "cut or resample the record")
    if units is not None and kind_of(units) != "an acceleration":
        allowed = f"one of {listing(ACCELERATIONS)}"
        raise refused("units", describe(units), allowed, "write the unit of the acceleration")
    lines = lines_in(text, "record")
    for number, line in enumerate(lines, start=1):
        if len(line) > _LONGEST_LINE:
            found = f"{len(line):,} characters"
            allowed = f"at most {_LONGEST_LINE:,} characters long"
            raise refused(_at(number), found, allowed, "give a text file of short lines")
    check_format(lines)
    top = "\n".join(lines[:_HEADER_LINES])
    begin = _BEGIN.search(top)
    if layout == "at2" and not begin:
        seen = printable(lines[min(3, len(lines) - 1)])
        advice = "correct the line; if the file has two columns, name it .csv, or over HTTP send `format=csv`"
        raise refused(_at(min(4, len(lines))), seen, "of the form NPTS=<number>, DT=<number>", advice)
    place = top.count("\n", 0, begin.end()) + 1 if begin else 0
    if begin and (more := _NO_STEP.search(top)):
        told = f"Line {place} does not give the time step as one number: {printable(more[0])}."
        raise refused(_at(place), printable(more[0]), "one number", "write `DT= <step in s>`", told)
    head, rows, remarks = _cut(lines, place)
    if begin:
        count, step = int((begin[1] or begin[4])[:12]), begin[2] or begin[5]
    elif _is_announcement(rows):
        place, (written, step) = rows.pop(0)
        count = int(written[:12])
    else:
        count, step = 0, ""
    if len(rows) < (1 if step else 2):
        told = f"The file has {counted(len(rows), 'row')} of numbers; a record needs at least two."
        advice = "give time in s and acceleration, one sample on each line, with a comma, semicolon, tab or blank between them"
        if begin and not rows:
            below = next((line for line in lines[place:] if line.strip()), "")
            told = f"No line below line {place} consists of numbers; the first is {printable(below)}."
            advice = "give the complete file, with blanks between the numbers"
        elif not rows and head:
            told = f"No line consists of two numbers; the last line is {printable(head[-1][1])}."
        raise refused(_at(len(lines)), f"the end after {len(rows)} rows", "two rows or more", advice, told)
    sizes = {len(cells) for _, cells in rows}
    pairs = sizes == {2} and (2 * len(rows) != count or (len(rows) > 2 and _counts_time(rows, step)))
    table = pairs or (len(rows) == count and sizes != {1})
    series = bool(step) and not table
    check_end(lines, [cell for _, cells in rows for cell in (cells if series else cells[-1:])])
    sign = next((each for each in ";\t," if each in lines[rows[0][0] - 1]), "")
    if not step and sizes != {2} and (announcing := _ANNOUNCING.search(top)):
        place = top.count("\n", 0, announcing.start()) + 1
        seen, advice = printable(announcing[0]), "write the line as `NPTS= <number>, DT= <step in s>`"
        raise refused(_at(place), seen, "of the form NPTS=<number>, DT=<number>", advice)
    if not series:
        _check_width(rows)
    second, factor = read_heading(head, None if series else sign, units and usual(units), remarks)
    announced = 0.0
    if step:
        unit = begin[3] or "" if begin else ""
        if kind_of(unit) in ("a time", "a frequency") and usual(unit) not in TIMES:
            allowed = f"one of {listing(TIMES)}"
            told = f"Line {place} gives the step in {printable(unit)}, which is not supported; "
            told += f"allowed are {listing(TIMES)}."
            raise refused(_at(place), printable(unit), allowed, "write the step in s", told)
        announced = read_decimal(step) * TIMES.get(usual(unit), second or 1.0)
    if series:
        numbers = _in_series(rows, place, count, len(lines))
        step_s = announced
    else:
        step_s, numbers = _between(rows, second), [read_decimal(cells[1]) for _, cells in rows]
        if step and (len(rows) != count or abs(announced - step_s) > UNEVEN * step_s):
            found = f"{counted(count, 'sample')}, {announced:g} s apart"
            seen = f"{counted(len(rows), 'line')} of two numbers, {step_s:g} s apart"
            told = f"Line {place} announces {found}, but the file has {seen}."
            raise refused(_at(place), found, seen, "correct the line, or give the complete file", told)
    places = [number for number, cells in rows for _ in (cells if series else cells[1:])]
    if fault := fault_of_marks(numbers, places):
        raise StudyFaults([fault])
    title = lines[1].strip()[:200] if begin and place > 2 else ""
    source = title if begin else "columns"
    motion = GroundMotion(name or title or "record", step_s, np.array(numbers) * factor, source)
    return checked(motion, _at(place or rows[0][0]))


def _at(number: int) -> str:
    return f"line {number}"


def _cut(lines: Sequence[str], begin: int) -> tuple[list[Line], list[Row], list[Line]]:
    """Separate a file into the lines above the samples, the samples, and remarks.

    `begin` is the number of the line that announces the samples, or 0 if no line announces them. Remarks are
    comments below the first sample, and further words in the line that announces the samples.
    """
    head: list[Line] = []
    rows: list[Row] = []
    remarks: list[Line] = []
    for number, line in enumerate(lines, start=1):
        bare = line.strip()
        if not bare:
            continue
        if number == begin or (rows and bare.startswith("#")):
            remarks.append((number, _BEGIN.sub(" ", bare).strip(" ,;")))
            continue
        cells = [cell.strip('"') for cell in re.split(r"[,;\t]|\s+", bare) if cell.strip('"')]
        if begin and _NUMBERS.match(bare):
            cells = _ONE.findall(bare)
        numbers = all(map(_ONE.fullmatch, cells))
        sample = (begin or len(cells) == 2) and any(map(_NO_WORD.fullmatch, cells[:1]))
        if number < begin or not (rows or numbers or sample):
            head.append((number, bare))
            continue
        # if a separator other than commas is present, a comma between two digits is a decimal comma
        apart = [cell for cell in re.split(r"[;\t]|\s+", bare) if cell]
        whole = "," in bare and len(cells) == 4 and all(cell.lstrip("+-").isdigit() for cell in cells)
        if whole or ((begin or len(apart) > 1) and decimal_comma(apart)):
            raise refused(_at(number), printable(bare), "decimal points", WRITE_POINTS, COMMAS_FOUND)
        if short := next(filter(None, map(_NO_EXPONENT.fullmatch, re.split(r"[,;\t]|\s+", bare))), None):
            told = f"Line {number} has an exponent without E: {short[0]}."
            raise refused(
                _at(number), short[0], "numbers", f"write such a number as {short[1]}E{short[2]}", told
            )
        if not numbers and begin and any(map(_BEGIN.search, lines[number - 1 : number + _HEADER_LINES])):
            told = f"Line {number} begins a second record: {printable(bare)}."
            raise refused(
                _at(number), "a second record", "one record", "write each record into its own file", told
            )
        if not numbers:
            advice = "correct the line, or remove it if it is not data"
            raise refused(_at(number), printable(bare), "numbers only", advice)
        rows.append((number, cells))
    return head, rows, remarks


def _counts_time(rows: Sequence[Row], step: str) -> bool:
    """Return whether the first column increases by the announced step."""
    first, second, last = (read_decimal(rows[k][1][0]) for k in (0, 1, -1))
    span = (len(rows) - 1) * read_decimal(step)
    return isclose(second - first, read_decimal(step), rel_tol=0.1) and isclose(
        last - first, span, rel_tol=0.1
    )


def _is_announcement(rows: Sequence[Row]) -> bool:
    """Return whether the first line holds the number of samples and the time step."""
    if len(rows) < 2 or len(rows[0][1]) != 2 or not rows[0][1][0].isdigit():
        return False
    count, below = int(rows[0][1][0][:12]), [cells for _, cells in rows[1:]]
    if all(len(cells) == 1 for cells in below):
        return True
    # if the first line held a time and an acceleration, the second line would begin with a later time
    return 1 < count > read_decimal(below[0][0]) and count in (len(below), sum(map(len, below)))


def _in_series(rows: Sequence[Row], place: int, count: int, end: int) -> list[float]:
    """Return the samples of all rows in sequence. Raise `StudyFaults` unless there are `count` samples."""
    allowed = f"{count:,} samples, as line {place} says"
    samples: list[float] = []
    for number, cells in rows:
        samples.extend(map(read_decimal, cells))
        if len(samples) > count:
            told = f"Line {number} holds sample {len(samples):,}, but line {place} announces only {count:,} samples."
            advice = "correct NPTS, or remove the surplus samples"
            raise refused(_at(number), f"sample {len(samples):,}", allowed, advice, told)
    if len(samples) < count:
        told = f"The file ends after {len(samples):,} samples, but line {place} announces {count:,}."
        advice = "give the complete file, or correct NPTS"
        raise refused(_at(end), f"the end after {len(samples):,} samples", allowed, advice, told)
    return samples


def _check_width(rows: Sequence[Row]) -> None:
    for number, cells in rows:
        if len(cells) == 2:
            continue
        advice = f"write the time before it, or {WRITE_STEP}"
        if 2 * sum(len(each) == 2 for _, each in rows) > len(rows):
            advice = "complete the line, or remove what is no sample"
            if any(_BEFORE_THOUSANDS.fullmatch(a) and _THOUSANDS.match(b) for a, b in pairwise(cells)):
                told = f"Line {number} has a number with a comma or a blank between thousands."
                raise refused(
                    _at(number),
                    counted(len(cells), "number"),
                    "two numbers",
                    "write numbers without it",
                    told,
                )
        elif len(cells) > 2:
            advice = (
                "keep the time and the one acceleration that you mean; if all are consecutive samples, write "
            )
            advice += "the line `NPTS= <number>, DT= <step in s>` above them"
        found = counted(len(cells), "number")
        raise refused(_at(number), found, "two numbers, time in s and acceleration", advice)


def _between(rows: Sequence[Row], stated: float | None) -> float:
    """Return the time step [s], computed from the times in the first column."""
    second = stated or 1.0
    written = [cells[0] for _, cells in rows]
    time = np.array([read_decimal(each) for each in written])
    step, wrong = equal_step(second * time, second * resolution_of(written))
    if wrong is not None:
        number, before, at = rows[wrong][0], second * time[wrong - 1], second * time[wrong]
        told, advice = wrong_step(number, before, at, step)
        if at <= before and all(cell.lstrip("+-").isdigit() for _, cells in rows for cell in cells):
            advice = f"if the commas are decimal commas, {WRITE_POINTS}; otherwise {advice}"
        elif stated is None and 2 * np.count_nonzero(np.diff(time) > 0) < len(rows):
            told = "The first column does not increase from line to line, as times do."
            advice = f"give the time first, below the heading {COLUMNS}, or {WRITE_STEP}"
        if at <= before:
            raise refused(_at(number), f"the time {at:g} s", f"a time after {before:g} s", advice, told)
        raise refused(_at(number), f"a step of {at - before:.6g} s", "equal time steps", advice, told)
    if np.isnan(step):
        advice = f"write the times with more digits, or {WRITE_STEP}"
        raise refused("time", f"times such as {written[-1]}", "a known time step", advice, TOO_FEW_DIGITS)
    if stated is None and step >= _LONG_STEP_S:
        told = f"The first column counts by {step:g} without a unit; it seems to contain row numbers or milliseconds."
        advice = f"write the heading as {COLUMNS} if they are seconds; otherwise {WRITE_STEP}"
        raise refused("time", f"{written[0]}, {written[1]}, …", "a column of times", advice, told)
    return step
