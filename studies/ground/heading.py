"""Reads quantities, units and institution from the lines above the samples of a record."""

import re
from collections.abc import Iterable, Iterator, Sequence

from damperlab.studies.decoded import check_factors
from damperlab.studies.faults import StudyFaults, listing, printable
from damperlab.studies.ground.motion import refused
from damperlab.studies.written_units import (
    ACCELERATIONS,
    BRACKETS,
    OF_PEAK,
    TIMES,
    is_time,
    kind_of,
    taken_apart,
    usual,
)

Line = tuple[int, str]
"""Number of a line, counted from 1, and the text of the line."""
COLUMNS = "`time (s), acceleration (g)`"
WRITE_STEP = "write one value on each line, below the line `NPTS= <number>, DT= <step in s>`"

_UNITS_OF = re.compile(
    r"\bunits?\b\s*(?:(?:of|for)\s+)?(?:time|acc\w*)?\s*(?:of|are|is|in|[:=]|(?=[(\[]))\s*(.+)", re.IGNORECASE
)
_AT_ONCE = re.compile(r"\bacc\w*\.?\s+in\s+$", re.IGNORECASE)
_LIKE_A_UNIT = re.compile(r"/\s*s|[%^²]|\*\*", re.IGNORECASE)
_TELLING = re.compile(r"\bacc(?:el|(?![a-z]))|\btime\b", re.IGNORECASE)
_OF_SAMPLES, _DIRECTIONS = ("an acceleration", "a velocity", "a reading"), ("v",)
"""Kinds of quantity whose units contradict a given unit of acceleration, and unit symbols that are ignored
because they usually name a direction.
"""
_MOTIONS = ("a velocity", "a displacement")
_ACCELERATION = re.compile(r"\bacc(?:el|(?![a-z]))", re.IGNORECASE)
_ACCELERATION_COLUMN = re.compile(rf"^a[xyzgh]?$|{_ACCELERATION.pattern}", re.IGNORECASE)
_COMMA = r',(?=(?:[^"]*"[^"]*")*[^"]*$)(?![^(\[]*[)\]])'
"""Pattern of a comma outside quotation marks and brackets."""
_OVER_TIME = "give the acceleration over time"
_OTHERS = {
    "a spectral density": (
        r"\b[ap]sd\b|spectral density",
        f"{_OVER_TIME}, or generate one with `random_vibration`",
    ),
    "a response spectrum": (
        r"\bp?s[av]\b|\bpseudo\b|spe[ck]tr(?:um|al?|ale|en|o)\b|spettro\b|\bp[eé]r[ií]od\w*",
        f"{_OVER_TIME}: a spectrum does not determine it",
    ),
    "a frequency": (
        r"\bfr[eé][cq]\w*|\bfourier\b|\bfft\b|\bfas\b",
        f"{_OVER_TIME}; `damperlab fit` reads a response over frequency",
    ),
    "a velocity": (
        r"\bvel(?:oc\w*)?\b|\bspeed\b|^v$|vitesse|geschwindigkeit",
        "give the file of the acceleration, or differentiate this one",
    ),
    "a displacement": (
        r"\bdisp(?:l(?:acement)?)?\b|d[eé]placement|desplazamiento|spostamento|verschiebung|^weg$",
        "give the file of the acceleration, or differentiate this one twice",
    ),
    "a list of peak values": (r"^pg[avd]\b", _OVER_TIME),
    "a count of samples": (
        r"^(?:no|nr|num|number|n|i|index|samples?|rows?|points?|steps?|count|#)$",
        WRITE_STEP,
    ),
    "an rms value": (r"\brms\b|root.mean", f"{_OVER_TIME}: an rms value does not determine it"),
    "an envelope": (r"\benvelope\b", f"{_OVER_TIME}: an envelope does not determine it"),
    "a logarithm": (r"^log(?:10)?$|\blog(?:10)?[\s(]*(?:of\s+)?acc", f"{_OVER_TIME}, not its logarithm"),
    "a relative acceleration": (r"\brelative\s+acc", "give the absolute acceleration of the base"),
}
"""Quantities other than a base acceleration: for each quantity, the words that identify it, and advice to the user."""
_OF_ACCELERATION = ("an rms value", "an envelope", "a logarithm", "a relative acceleration")
_NO_SAMPLE = re.compile(
    "|".join(["spectr", "pseudo", *(_OTHERS[what][0] for what in _OF_ACCELERATION)]), re.IGNORECASE
)
"""Pattern of words that, beside the word acceleration, name another quantity."""
_HEADER_LINES = 60
_FORMATS = (
    (
        "K-NET",
        r"^Origin Time\s",
        "multiply the counts by the scale factor, in gal per count, and subtract their mean",
    ),
    ("ESM", r"^EVENT_NAME:", "the values follow the heading, in its UNITS, SAMPLING_INTERVAL_S apart"),
    ("COSMOS", r"\(Format v\d+\.\d+ with \d+ text lines\)", "take the acceleration block, in its units"),
    ("CSMIP", r"^\s*\d+ POINTS OF ACCEL DATA", "take the acceleration block, in its units"),
    (
        "LabVIEW",
        r"^LabVIEW Measurement",
        "the columns follow the last ***End_of_Header***, Y_Unit_Label gives the unit",
    ),
    ("SMC", r"^\s*\d\s+\w+\s+ACCELEROGRAM", "the values follow the comment lines, in cm/s²"),
)
"""Formats that are not supported: name, pattern of an early line, and advice on how to find the acceleration."""


def read_heading(
    lines: Sequence[Line], separator: str | None, given: str | None, remarks: Sequence[Line] = ()
) -> tuple[float | None, float]:
    """Read the units from the lines above the samples, and check that the samples are a base acceleration.

    Parameters
    ----------
    lines : sequence of (int, str)
        Lines above the samples.
    separator : str or None
        Separator of the two columns, empty for blanks; None for consecutive samples.
    given : str or None
        Unit of the acceleration that the caller gave, in the usual spelling, or None.
    remarks : sequence of (int, str)
        Other lines of text, between the samples and below them. These lines may state a unit, but do not name
        columns.

    Returns
    -------
    (float or None, float)
        Factor from the unit of time to s, or None if the file states no unit of time; and the factor from the unit of
        acceleration to m/s².

    Raises
    ------
    StudyFaults
        If the file is not a record, or a unit is missing, unknown or contradicted.
    """
    heading, others = (None, lines) if separator is None else _heading(lines, separator)
    others = [*others, *remarks]
    stated = [(unit, number) for number, line in others for unit in _stated(line)]
    times = [each for each in stated if kind_of(each[0]) == "a time"]
    units = [each for each in stated if each not in times]
    named = False
    if heading:
        of_time, of_acceleration = _of_columns(*heading)
        named = bool(of_acceleration or _ACCELERATION_COLUMN.search(heading[1][1]))
        if taken_apart(heading[1][0])[0].strip() == "T":  # a period, if the file speaks of a spectrum
            for _, line in others:
                if re.search(r"spe[ck]tr", line, re.IGNORECASE):
                    raise _no_record("a response spectrum", heading[0], line)
        times += [(unit, heading[0]) for unit in of_time]
        units += [(unit, heading[0]) for unit in of_acceleration]
    if not named:
        titled = any(_ACCELERATION.search(line) for _, line in others)
        for number, line in others:
            what = _other(line)
            moved = what in _MOTIONS
            sure = moved and re.search(r"\btime\b|histor|series", line, re.IGNORECASE)
            spectral = "spectral acc" in line.lower()
            if sure or spectral or (not titled and (moved or "response spectr" in line.lower())):
                raise _no_record(what, number, line)
    second, unit = _agreed(times, "the time", TIMES), _agreed(units, "the acceleration", ACCELERATIONS)
    check_factors([*lines, *remarks])
    if unit is None and given is None:
        told = "The file does not state the unit of its acceleration."
        known = listing(ACCELERATIONS)
        advice = f"name it with `units`, on the command line `--units` ({known}), or write the heading as {COLUMNS}"
        raise refused("units", "no unit", "the unit of the acceleration", advice, told)
    if unit and given not in (None, unit):
        told = f"`units` is {given}, but the file says {unit} in line {units[0][1]}."
        advice = "leave `units` out (on the command line `--units`), or correct the heading of the file"
        raise refused("units", f"{given} while the file says {unit}", f"{unit}, or nothing", advice, told)
    if unit is None:
        _check_mentioned(others, str(given))
    return TIMES[second] if second else None, ACCELERATIONS[unit or str(given)]


def _check_mentioned(lines: Sequence[Line], given: str) -> None:
    """Refuse a given unit if a line mentions another unit.

    Units in a line with a peak value and units next to a number are ignored.
    """
    for number, line in lines:
        words = ["", *re.split(r"[\s,;:=()\[\]{}'\"]+", line), ""]
        of_peak = OF_PEAK.search(line) is not None
        for before, word, after in zip(words, words[1:], words[2:], strict=False):
            other = kind_of(word) in _OF_SAMPLES and usual(word) != given and word.lower() not in _DIRECTIONS
            if other and not (of_peak or before[-1:].isdigit() or after[:1].isdigit()):
                found = f"{given} while line {number} mentions {printable(word)}"
                told = f"`units` is {given}, but line {number} mentions {printable(word)}: {printable(line)}."
                advice = f"state the unit in a heading, as in {COLUMNS}, or in a line such as `Units: g`"
                raise refused("units", found, "one unit", advice, told)


def _heading(lines: Sequence[Line], separator: str) -> tuple[tuple[int, list[str]] | None, Sequence[Line]]:
    """Return the line that names the columns, and all other lines. The units may be in the line below the names."""
    names, units = ([], [], *(_cells(line) for _, line in lines[-2:]))[-2:]
    if len(names) == len(units) == 2 and all(map(kind_of, units)):
        lines = [*lines[:-2], (lines[-1][0], f"{names[0]} ({units[0]}), {names[1]} ({units[1]})")]
    for at in reversed(range(len(lines))):
        number, line = lines[at]
        cells = _cells(line)
        if line[0] in "#%" and not _is_time(cells[0]):
            continue
        if any(map(_named, cells)) if len(cells) == 2 else len(cells) > 2 and _is_time(cells[0]):
            return (number, cells), [*lines[:at], *lines[at + 1 :]]
        if at == len(lines) - 1 and len(cells) == 2 and separator in line:
            return (number, cells), lines[:-1]
    return None, lines


def _named(cell: str) -> bool:
    """Return whether a cell contains the name or the unit of time, acceleration or a quantity in `_OTHERS`."""
    words, units = taken_apart(cell)
    return _is_time(cell) or bool(_ACCELERATION.search(words) or _other(words) or any(map(kind_of, units)))


def _is_time(cell: str) -> bool:
    words, units = taken_apart(cell)
    return is_time(words) or "a time" in map(kind_of, units)


def _of_columns(number: int, cells: list[str]) -> list[list[str]]:
    """Return the units in the headings of the two columns."""
    read = [taken_apart(cell) for cell in cells]
    if len(cells) == 2:
        kinds = [
            (_other(words) or next((kind for kind in map(kind_of, units) if kind in _OTHERS), ""), cell)
            for cell, (words, units) in zip(cells, read, strict=True)
        ]
        # the second column says what the file holds, but a motion may be given over frequency
        order = kinds if kinds[0][0] == "a frequency" and kinds[1][0] in _MOTIONS else reversed(kinds)
        for what, cell in order:
            if what:
                raise _no_record(what, number, cell)
    if len(cells) != 2 or not _is_time(cells[0]):
        shown = listing(map(printable, cells))
        told = f"The heading names {shown}; a record has two columns, the time first."
        if len(cells) == 2:
            told = told[:-1] + f", and {printable(cells[0])} is not known as a time."
        advice = f"write the heading as {COLUMNS}, and # before a line that is not a heading"
        raise refused(f"line {number}", shown, COLUMNS, advice, told)
    return [units for _, units in read]


def _cells(line: str) -> list[str]:
    """Split a heading into cells, if possible at wide gaps or after brackets, because a cell may contain blanks."""
    bare = line.lstrip("#%*!/ ")
    bare = bare.strip('"') if bare.count('"') == 2 else bare
    for parting in (";", "\t", _COMMA, r"\s{2,}|(?<=[)\]])\s*(?=[^\s)\]])"):
        cells = [cell.strip(' "') for cell in re.split(parting, bare)]
        if len(cells) > 1:
            return [cell for cell in cells if cell]
    return bare.split() if len(bare.split()) == 2 else [bare]


def _stated(line: str) -> Iterator[str]:
    """Yield the units that a line states after `units of`, or near a word for acceleration or time."""
    if found := _UNITS_OF.search(line):
        first, *others = re.split("[,;]", found[1])
        named = taken_apart(first)[1] if _TELLING.search(first) else []
        yield _first_unit(first) or (named or [first.strip()])[0]
        for other in others:
            yield from filter(kind_of, taken_apart(other)[1])
    elif _TELLING.search(line) and not OF_PEAK.search(line):
        yield from (each for each in BRACKETS.findall(line) if kind_of(each) or _LIKE_A_UNIT.search(each))
        for found in re.finditer(r"\bin\s+(?=(\S+))", line, re.IGNORECASE):
            unit = _first_unit(line[found.end() :])
            if unit or _AT_ONCE.search(line[: found.end()]):
                yield unit or found[1]


def _first_unit(text: str) -> str:
    """Return the longest unit at the start of a text.

    The result is empty if the text does not start with a unit, or if a factor follows the unit.
    """
    words = text.split(maxsplit=6)
    for count in range(min(6, len(words)), 0, -1):
        unit = " ".join(words[:count]).strip("(),.;")
        if kind_of(unit):
            return "" if re.match(r"[*/^×·]|x\s*\d", " ".join(words[count:])) else unit
    return ""


def _agreed(stated: Sequence[tuple[str, int]], quantity: str, allowed: Iterable[str]) -> str | None:
    """Return the unit of a quantity, on which all lines must agree, or None if no line states a unit."""
    for written, number in stated:
        shown, place = printable(written), f"line {number}"
        if kind_of(written) in _OTHERS:
            raise _no_record(kind_of(written), number, written)
        if usual(written) not in allowed:
            told = f"Line {number} gives {quantity} in {shown}, which is not supported; allowed are {listing(allowed)}."
            advice = "convert the numbers to one of these, and write it in the heading"
            raise refused(place, shown, f"one of {listing(allowed)}", advice, told)
        if usual(written) != usual(stated[0][0]):
            found = f"{printable(stated[0][0])} in line {stated[0][1]}, but {shown} in {place}"
            told = f"The file gives {quantity} in two units: {found}."
            raise refused(place, found, "one unit", "correct or remove the wrong one", told)
    return usual(stated[0][0]) if stated else None


def _other(words: str) -> str:
    """Return the quantity in `_OTHERS` that the words describe, or an empty text."""
    if _ACCELERATION.search(words) and not _NO_SAMPLE.search(words):
        return ""
    return next((what for what, (said, _) in _OTHERS.items() if re.search(said, words, re.IGNORECASE)), "")


def _no_record(what: str, number: int, shown: str) -> StudyFaults:
    told = f"Line {number} says that this is {what}: {printable(shown.strip())}. A record is an acceleration over time."
    return refused(f"line {number}", what, "an acceleration over time", _OTHERS[what][1], told)


def check_format(lines: Sequence[str]) -> None:
    """Refuse a file in a known format that is not supported, and explain how to convert the file into columns."""
    for name, begins, how in _FORMATS:
        if any(re.search(begins, line) for line in lines[:_HEADER_LINES]):
            told = f"This file has the format of {name}, which is not supported."
            advice = (
                f"write two columns from it, with a heading such as `time (s), acceleration (cm/s2)`: {how}"
            )
            raise refused("record", f"a file of {name}", "AT2, or two columns", advice, told)
