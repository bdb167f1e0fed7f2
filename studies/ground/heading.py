"""What the headings of a record say: the quantity, its unit, and whose file it is. What they say is never overruled."""

import re
from collections.abc import Sequence

from damperlab.studies.faults import describe, listing, printable
from damperlab.studies.ground.motion import refused
from damperlab.studies.vocabulary import ACCELERATION_UNITS as UNITS

_SPELLINGS = {
    "g": "g",
    "gs": "g",
    "gal": "cm/s2",
    "gals": "cm/s2",
    **{f"{length}{way}": f"{length}/s2" for length in ("m", "cm") for way in ("/s2", "/s/s", "s-2", "/ss")},
}
"""How a unit may be written, without blanks and signs of powers."""
_TIMES = {
    **dict.fromkeys(("s", "sec", "secs", "second", "seconds"), 1.0),
    **dict.fromkeys(("ms", "msec", "millisec", "millisecond", "milliseconds"), 1e-3),
}
_UNIT = r"[(\[]?\s*([a-z%µμ][a-z0-9/^*²'%.µμ-]*(?:\s*/\s*[a-z0-9^*²]+)*(?:\s+s(?:ec)?\s*\^?-2)?)"
_STATED = tuple(
    re.compile(pattern + _UNIT, re.IGNORECASE)
    for pattern in (r"units?\s+(?:of|are|is)\s*", r"units?\s*[:=]\s*")
)
_SAID = (
    re.compile(r"\bin\s+" + _UNIT + r"(?=\s*(?:[,;.]|$))", re.IGNORECASE),
    re.compile(r"[(\[]([^)\]]+)[)\]]"),
)
"""Where a line about acceleration may name its unit."""
_LIKE_A_UNIT = re.compile(r"[/%]|s\s*\^?-2|^[mµμu]g$", re.IGNORECASE)
_ACCELERATION = re.compile(r"\bacc", re.IGNORECASE)
_OTHER = re.compile(r"\b(vel(?:ocity)?|disp(?:l(?:acement)?)?)\b", re.IGNORECASE)
_COUNTS = re.compile(
    r"(?:no|nr|num|number|n|i|index|sample|samples|row|point|points|step|steps|count|#)\.?", re.IGNORECASE
)
_FORMATS = (
    ("K-NET", re.compile(r"^Origin Time\s"), "multiply the counts by the scale factor, in gal a count"),
    (
        "ESM",
        re.compile(r"^EVENT_NAME:"),
        "the values follow the heading, in its UNITS, SAMPLING_INTERVAL_S apart",
    ),
    (
        "COSMOS",
        re.compile(r"\(Format v\d+\.\d+ with \d+ text lines\)"),
        "take the acceleration block, in its units",
    ),
    ("SMC", re.compile(r"^\s*\d\s+\w+\s+ACCELEROGRAM"), "the values follow the comment lines, in cm/s²"),
)
"""Files of others: what they are called, how they begin, and how the acceleration is found in them."""


def acceleration_unit(stated: str | None, given: str | None, place: str = "units") -> str:
    """Give the unit of an acceleration: what the file states, or where it states none, what was given with it.

    Parameters
    ----------
    stated : str or None
        As the file writes it; None where it says nothing.
    given : str or None
        One of `UNITS`, named with the file.
    place : str
        Field or line of a fault.

    Raises
    ------
    StudyFaults
        Where no unit is known, the file's is not read, or the two differ.
    """
    if stated is None:
        if given is not None:
            return given
        told = "The file does not state the unit of its acceleration."
        advice = (
            f"name it with the file ({listing(UNITS)}), or write the heading as `time (s), acceleration (g)`"
        )
        raise refused(place, "no unit", "the unit of the acceleration", advice, told)
    unit = _SPELLINGS.get(_bare(stated))
    if unit is None:
        told = f"The heading gives the acceleration in {stated}, which is not read; allowed are {listing(UNITS)}."
        advice = "convert the accelerations to one of these, and write it in the heading"
        raise refused(place, stated, f"one of {listing(UNITS)}", advice, told)
    if given is not None and unit != given:
        told = f"`units` is {given}, but the file says {unit}."
        advice = "leave `units` out, or correct the heading of the file"
        raise refused("units", f"{given} while the file says {unit}", f"{unit}, or nothing", advice, told)
    return unit


def unit_in_lines(lines: Sequence[str]) -> str | None:
    """Give the unit that lines of text state, as they write it: behind `units of`, or in one about acceleration."""
    for line in lines:
        for pattern in _STATED:
            if found := pattern.search(line):
                return found[1].rstrip(".")
    about = [line.strip() for line in lines if _ACCELERATION.search(line)]
    said = (found[1] for line in about for pattern in _SAID for found in pattern.finditer(line))
    return next((each for each in said if _bare(each) in _SPELLINGS or _LIKE_A_UNIT.search(each)), None)


def unit_of_column(heading: str) -> str | None:
    """Give the unit in the heading of a column of accelerations: whatever stands in its brackets, or behind `in`."""
    stated = re.search(r"[(\[]([^)\]]+)[)\]]\s*$", heading)
    return stated[1] if stated else unit_in_lines([f"acc {heading}"])


def _bare(unit: str) -> str:
    """Write a unit without blanks, brackets and signs of powers."""
    return re.sub(r"[\s^*'’().\[\]]", "", unit.lower()).replace("²", "2").replace("sec", "s")


def check_quantity(lines: Sequence[str], place: str) -> None:
    """Refuse a velocity or a displacement, which is no record of acceleration."""
    if any(_ACCELERATION.search(line) for line in lines):
        return
    for line in lines:
        if found := _OTHER.search(line):
            what = "velocity" if found[1].lower().startswith("vel") else "displacement"
            told = f"The file holds a {what}: {printable(line.strip())}. A record is an acceleration."
            advice = "give the file of the acceleration, or differentiate this one"
            raise refused(place, f"a {what}", "an acceleration", advice, told)


def check_format(lines: Sequence[str]) -> None:
    """Refuse the file of another institution by its name, and say how to make columns of it."""
    for name, begins, how in _FORMATS:
        if any(begins.search(line) for line in lines[:3]):
            told = f"This is a file of {name}, which is not read."
            advice = f"write two columns `time (s), acceleration (cm/s2)` from it: {how}"
            raise refused("record", f"a file of {name}", "AT2, or two columns", advice, told)


def split_heading(heading: str) -> tuple[str, str]:
    """Part a heading of two columns into what it says of the time and of the acceleration."""
    cells = [cell.strip().strip('"') for cell in re.split(r"[,;\t]", heading)]
    if len(cells) > 1:
        return cells[0], cells[-1]
    parts = re.findall(r"[^()\[\]]+[(\[][^)\]]*[)\]]", heading)
    if len(parts) > 1:
        return parts[0].strip(), parts[-1].strip()
    words = heading.split()
    return (words[0], " ".join(words[1:])) if words else ("", "")


def second_of(heading: str) -> float:
    """Give what one of the unit of a column of times is in seconds; of none stated, 1.

    Raises
    ------
    StudyFaults
        Where the column is none of times, or its unit is not read.
    """
    bare = re.sub(r"[(\[].*", "", heading).strip().strip('"')
    if _COUNTS.fullmatch(bare):
        told = f"The first column is {describe(bare)}, which counts samples and is no time."
        raise refused("time", bare, "a column of times", "write the times of the samples, in seconds", told)
    stated = re.search(r"[(\[]([^)\]]*)[)\]]|\bin\s+(\w+)\s*$", heading)
    if not stated:
        return 1.0
    unit = (stated[1] or stated[2] or "").strip().lower().rstrip(".")
    if unit in _TIMES:
        return _TIMES[unit]
    told = f"The heading gives the time in {unit}, which is not read; allowed are s and ms."
    raise refused("time", unit, "s or ms", "convert the times to seconds", told)
