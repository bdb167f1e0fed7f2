"""Records from files: PEER's AT2, and two columns of time and acceleration. Every fault names its line."""

import re
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.faults import counted, describe, listing, printable
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
_TIMES = {"s": 1.0, "ms": 1e-3}
_NO_TIMES = ("min", "h", "us", "µs", "μs", "ns", "samples")
_NOT_READ = ("mg", "µg", "μg", "ug", "mm/s2", "in/s2", "ft/s2", "mm/s/s", "in/s/s", "ft/s/s")
"""Units that people write, and that are refused rather than passed over."""
_HEADER_LINES = 10
_LONGEST_LINE = 1000
_UNEVEN = 0.02  # of a step: time stamps are often rounded


def read_record(text: bytes | str, layout: Layout, name: str = "", units: str | None = None) -> GroundMotion:
    """Read a record.

    Parameters
    ----------
    text : bytes or str
        The file; bytes are UTF-8 or, as old files are, Latin-1.
    layout : {"at2", "csv"}
        PEER's AT2; or two columns, time and acceleration, apart by comma, semicolon, tab or blanks; times in s, or in ms
        where the heading says so.
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
    lines = _decoded(text).replace("\r\n", "\n").replace("\r", "\n").split("\n")
    for number, line in enumerate(lines, start=1):
        if len(line) > _LONGEST_LINE:
            found = f"{len(line):,} characters"
            allowed = f"at most {_LONGEST_LINE:,} characters long"
            raise refused(_at(number), found, allowed, "give a text file of short lines")
    return _read_at2(lines, name, units) if layout == "at2" else _read_columns(lines, name, units)


def _decoded(text: bytes | str) -> str:
    if isinstance(text, str):
        return text
    try:
        return text.decode("utf-8-sig")
    except UnicodeDecodeError:
        return text.decode("latin-1")


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
    factor = UNITS[_units_of_header(heading) if units is None else _agreed(units, _stated_in_header(heading))]
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


def _unit(written: str) -> str | None:
    """Give the unit that a file means, None where it is none of an acceleration."""
    unit = re.sub(r"[\s^]", "", written.lower()).replace("²", "2").replace("sec", "s").replace("s/s", "s2")
    unit = "cm/s2" if unit == "gal" else unit
    return unit if unit in UNITS else None


def _agreed(units: str, stated: str | None) -> str:
    """Give the unit that was asked for; the file must not say another."""
    if stated is not None and stated != units:
        found = f"{units} while the file says {stated}"
        raise refused(
            "units",
            found,
            f"{stated}, or nothing",
            "leave `units` out, or correct the heading of the file",
            f"`units` is {units}, but the file says {stated}.",
        )
    return units


def _stated_in_header(heading: list[str]) -> str | None:
    for line in heading:
        said = re.search(r"UNITS?\s+OF\s+([A-Z0-9/^*²]+(?:\s*/\s*[A-Z0-9^²]+)*)", line.upper())
        if said and (unit := _unit(said[1])):
            return unit
    return None


def _units_of_header(heading: list[str]) -> str:
    if unit := _stated_in_header(heading):
        return unit
    raise refused(
        _at(min(3, max(1, len(heading)))),
        printable(heading[2]) if len(heading) > 2 else "no unit",
        "a line with `UNITS OF G`",
        f"name the unit of the acceleration with the file: {listing(UNITS)}",
        "The file does not state the unit of its acceleration.",
    )


def _read_columns(lines: list[str], name: str, units: str | None) -> GroundMotion:
    rows: list[tuple[float, float]] = []
    places: list[int] = []
    heading = ""
    for number, line in enumerate(lines, start=1):
        bare = line.strip()
        if not bare or bare.startswith("#"):
            heading += bare if not rows else ""
            continue
        cells = [cell.strip() for cell in re.split(r"[,;\t]|\s+", bare) if cell.strip()]
        numbers = [cell for cell in cells if _ONE.fullmatch(cell)]
        if not rows and not numbers:
            heading += bare
            continue
        # apart by commas, a line has no cells by the other signs
        apart = [cell for cell in re.split(r"[;\t]|\s+", bare) if cell]
        if len(apart) == 2 and decimal_comma(apart):
            raise refused(_at(number), printable(bare), "decimal points", WRITE_POINTS, COMMAS_FOUND)
        if len(cells) != 2 or len(numbers) != 2:
            allowed = "two numbers, time in s and acceleration"
            raise refused(_at(number), printable(bare), allowed, "correct the line, or remove it")
        rows.append((_float(cells[0]), _float(cells[1])))
        places.append(number)
    if len(rows) < 2:
        raise refused(
            _at(len(lines)),
            f"the end after {len(rows)} rows",
            "two rows or more",
            "give time and acceleration, one sample on each line",
            f"The file has {counted(len(rows), 'row')} of numbers; a record needs at least two.",
        )
    factor = UNITS[
        _units_of_heading(heading) if units is None else _agreed(units, _stated_in_heading(heading))
    ]
    time, acceleration = np.array(rows).T
    time = time * _second_of(heading)
    step = float(time[-1] - time[0]) / (len(rows) - 1)
    _check_steps(time, step, places)
    return checked(GroundMotion(name or "record", step, acceleration * factor, "two columns"), _at(places[0]))


def _brackets(heading: str) -> list[str]:
    return re.findall(r"[(\[]([^)\]]*)[)\]]", heading)


def _units_of_columns(heading: str) -> tuple[str | None, str | None]:
    """Give what stands in brackets behind the time and behind the acceleration."""
    first, *others = re.split(r"[,;\t]", heading)
    if others:
        time, acceleration = ("".join(_brackets(cell)[-1:]) for cell in (first, others[-1]))
    else:  # columns that spaces part: the last brackets belong to the last column
        time, acceleration = ["", "", *_brackets(heading)][-2:]
    return time or None, acceleration or None


def _stated_in_heading(heading: str) -> str | None:
    _, said = _units_of_columns(heading)
    if said and re.sub(r"[\s^]", "", said.lower()).replace("²", "2") in _NOT_READ:
        told = (
            f"The heading gives the acceleration in {said}, which is not read; allowed are {listing(UNITS)}."
        )
        advice = "convert the accelerations to one of these, and write it in the heading"
        raise refused("units", said, f"one of {listing(UNITS)}", advice, told)
    return _unit(said) if said else None


def _second_of(heading: str) -> float:
    """Give what one of the unit of the times is in seconds."""
    said, _ = _units_of_columns(heading)
    unit = said.strip().lower() if said else "s"
    if unit in _NO_TIMES:
        told = f"The heading gives the time in {said}, which is not read; allowed are {listing(_TIMES)}."
        raise refused("time", str(said), f"one of {listing(_TIMES)}", "convert the times to seconds", told)
    return _TIMES.get(unit, 1.0)


def _units_of_heading(heading: str) -> str:
    if unit := _stated_in_heading(heading):
        return unit
    found = printable(heading) if heading else "no heading"
    allowed = f"the unit of the acceleration: {listing(UNITS)}"
    told = "The file does not state the unit of its acceleration."
    advice = "name it with the file, or write the heading as `time (s), acceleration (g)`"
    raise refused("units", found, allowed, advice, told)


def _check_steps(time: NDArray[np.float64], step: float, places: list[int]) -> None:
    if step > 0:
        off = np.abs(time - (time[0] + step * np.arange(time.size))) > _UNEVEN * step
        # rounded stamps do not run on: only a sample beside its neighbours is named
        if not off.any():
            return
        steps = np.diff(time)
        usual = float(np.median(steps))
        wrong = int(np.argmax(np.abs(steps - usual) > _UNEVEN * abs(usual)))
        found = f"a step of {steps[wrong]:.6g} s after steps of {usual:.6g} s"
        told = f"Line {places[wrong + 1]} has {found}; all time steps must be equal."
        advice = "resample the record to equal steps"
        raise refused(_at(places[wrong + 1]), found, "equal time steps", advice, told)
    told = f"The last time, {time[-1]:g} s, is not later than the first; time must increase."
    found = f"the time {time[-1]:g} s at the end"
    raise refused(_at(places[-1]), found, "a time that grows", "order the lines by time", told)


def _float(text: str) -> float:
    return float(text.replace("D", "E").replace("d", "e"))
