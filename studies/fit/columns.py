"""Columns of a measured response, with the allowed headings and units."""

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass

from damperlab.studies.answers.design_question import DESIGN
from damperlab.studies.faults import Fault, listing, nearest, printable
from damperlab.studies.written_units import (
    BRACKETS,
    LENGTHS,
    OF_PEAK,
    TIMES,
    is_time,
    kind_of,
    taken_apart,
    usual,
)

FREQUENCIES = {"hz": 1.0, "khz": 1e3, "rad/s": 0.5 / math.pi, "rpm": 1.0 / 60.0}
FORCES = {"n": 1.0, "kn": 1e3, "lbf": 4.4482216152605}
MASSES = {"kg": 1.0, "g": 1e-3, "lb": 0.45359237}
DAMPINGS = {"ns/m": 1.0, "kg/s": 1.0}
RATIO = {"": 1.0, "1": 1.0, "-": 1.0}
SHARES = {"%": 0.01}
"""Factor from each unit to SI units."""

PERCENT = "deviation_share"
"""Name of the column that gives standard deviations as shares of the amplitudes."""


@dataclass(frozen=True)
class Column:
    """A kind of column that a table may have.

    Parameters
    ----------
    names : dict of dict
        For each internal name of the column, the allowed units with factors to SI units. The unit in a heading selects
        the name.
    spellings : tuple of str
        Allowed headings, in lower case, without a unit.
    """

    names: dict[str, dict[str, float]]
    spellings: tuple[str, ...]

    @property
    def units(self) -> tuple[str, ...]:
        """Every unit that the heading may state."""
        return tuple(unit for units in self.names.values() for unit in units if unit not in RATIO)


COLUMNS = (
    Column({"frequency_hz": FREQUENCIES}, ("frequency", "excitation frequency", "f")),
    Column({"frequency_ratio": RATIO}, ("frequency ratio", "r")),
    Column({"amplitude_m": LENGTHS}, ("amplitude", "x")),
    Column({"amplitude_ratio": RATIO}, ("amplitude ratio", "x/z", "transmissibility")),
    Column({"deviation_m": LENGTHS, PERCENT: SHARES}, ("deviation", "standard deviation")),
    Column({"deviation_ratio": RATIO}, ("deviation ratio",)),
    Column({"base_amplitude_m": LENGTHS}, ("base amplitude", "z")),
    Column({"clearance_m": LENGTHS}, ("clearance", "d")),
    Column({"friction_force_n": FORCES}, ("friction force", "friction")),
    Column({"particle_mass_kg": MASSES}, ("particle mass",)),
    Column({"damping_n_s_per_m": DAMPINGS}, ("damping",)),
    *(Column({name: RATIO}, (name.replace("_", " "),)) for name in DESIGN),
)
"""Every known column."""

CONDITIONS = tuple(name for column in COLUMNS[6:] for name in column.names)
"""Columns for quantities, besides the frequency, that differ between rows."""

ACCELERATION = re.compile(
    r"acc(el)?|((absolute|relative) )?acceleration( (amplitude|of the structure))?|amplitude of the acceleration"
)
"""Headings for the signal of an accelerometer on the structure, which is not fitted."""

OF_RESPONSE = (
    "With friction and impacts the motion is not a sine, so its largest displacement is not its largest "
    "acceleration over ω²",
    "integrate the recorded acceleration twice, with a high-pass filter well below the excitation frequency, and give the "
    "largest displacement of a cycle as `amplitude (mm)`",
)
"""Reason why an acceleration of the structure is not fitted, and the remedy."""

_NO_AMPLITUDE = re.compile(
    r"\b(?:rms|pp|p2p|p-p|pk-pk|peak[- ]?to[- ]?peak|double[- ]amplitudes?)\b", re.IGNORECASE
)
_TO_AMPLITUDE = (
    "give the largest displacement of a cycle as `amplitude (mm)`: half of a peak-to-peak value; an rms value does not "
    "determine it, since the motion is not a sine"
)
_COUNTS = re.compile(r"no|nr|num|number|n|i|index|samples?|rows?|points?|steps?|count|#")
_OTHERWISE = {
    "displacement": "amplitude",
    "deflection": "amplitude",
    "response": "amplitude",
    "freq": "frequency",
    "frq": "frequency",
    "disp": "displacement",
    "gap": "clearance",
}
"""Heading to suggest for each common alternative."""


def says_time(heading: str) -> bool:
    """Return whether a heading stands for a column of times."""
    words, units = taken_apart(heading)
    return is_time(words.strip()) or (not words.strip() and "a time" in map(kind_of, units))


def _meant(said: str, unit: str, as_written: str, columns: Sequence[Column]) -> str:
    """Return the heading that was probably meant, from the words or else from the unit; empty if there is none."""
    spellings = {spelling: column for column in columns for spelling in column.spellings}
    near: str | None = said
    while near is not None and near not in spellings:
        near = _OTHERWISE.get(near)
    near = near or nearest(said, spellings)
    if near is None and unit:
        of_unit = (
            column for column in columns if unit in (FREQUENCIES | LENGTHS | TIMES) and unit in column.units
        )
        near = next((column.spellings[0] for column in of_unit), None)
    if near is None:
        return ""
    return f"{near} ({as_written})" if unit in spellings[near].units else near


def read_headings(
    cells: Sequence[str],
    number: int,
    columns: Sequence[Column] = COLUMNS,
    not_fitted: tuple[str, str] = OF_RESPONSE,
) -> tuple[list[str], list[float], list[Fault]]:
    """Read the headings of a table. Return names, factors to SI units, and faults; see `read_heading`."""
    field = f"line {number}"
    read = [read_heading(cell, field, columns, not_fitted) for cell in cells]
    faults = [each for each in read if isinstance(each, Fault)]
    names = [each[0] for each in read if not isinstance(each, Fault)]
    for name in sorted({name for name in names if names.count(name) > 1}):
        told = f"Line {number} names the column {name} twice."
        faults.append(Fault(field, f"{name} twice", "each column once", "remove one of them", told))
    if sum(name.startswith("deviation") for name in names) > 1 and not faults:
        told = "The table has two columns of standard deviations; it may have one."
        faults.append(Fault(field, "two deviations", "one of them", "remove one of the two", told))
    return names, [each[1] for each in read if not isinstance(each, Fault)], faults


def faults_of_comments(comments: Sequence[tuple[int, str]], headings: Sequence[str]) -> list[Fault]:
    """Find comments that mention rms or peak-to-peak amplitudes, or that contradict the unit in a heading."""
    faults = []
    for number, comment in comments:
        field = f"line {number}"
        if _NO_AMPLITUDE.search(comment) and re.search(r"\bamplitudes?\b", comment, re.IGNORECASE):
            told = f"Line {number} mentions rms or peak-to-peak amplitudes: {printable(comment)}."
            advice = f"{_TO_AMPLITUDE}. Remove the line if it is about something else"
            faults.append(Fault(field, printable(comment), "largest displacements", advice, told))
        for heading in headings:
            words, units = taken_apart(heading)
            said = (
                rf"\b{re.escape(words.strip())}s?\s*(?:\b(?:is|are)\s+)?(?:\bin\s+|[(\[/]\s*)([^\s,;()\[\]]+)"
            )
            for unit in re.findall(said, comment, re.IGNORECASE) if words and units else []:
                alike = kind_of(unit) and kind_of(unit) == kind_of(units[0])
                if alike and usual(unit) != usual(units[0]) and not OF_PEAK.search(comment):
                    told = f"Line {number} says {printable(unit)}, but the heading {printable(heading.strip())} says "
                    told += f"{printable(units[0])}."
                    advice = "correct or remove the wrong one"
                    faults.append(Fault(field, printable(unit), printable(units[0]), advice, told))
    return faults


def read_heading(
    text: str, field: str, columns: Sequence[Column] = COLUMNS, not_fitted: tuple[str, str] = OF_RESPONSE
) -> tuple[str, float] | Fault:
    """Read one heading, as in ``amplitude (mm)``, ``X/Z`` or ``amplitude_m``.

    Parameters
    ----------
    text : str
        The heading.
    field : str
        Place of the heading in the table, for the fault.
    columns : sequence of Column
        Columns that the table may have.
    not_fitted : (str, str)
        Reason why an acceleration of the structure is not fitted, and the remedy.

    Returns
    -------
    (str, float) or Fault
        Internal name of the column, and the factor to SI units.
    """
    written = text.strip().strip('"').strip()
    for column in columns:
        for name, units in column.names.items():
            if written.lower() == name:
                return name, 0.01 if units is SHARES else 1.0
    if _NO_AMPLITUDE.search(written.replace("_", " ")):
        told = f"The heading {printable(written)} is not an amplitude."
        return Fault(field, printable(written), "a largest displacement", _TO_AMPLITUDE, told)
    said, as_written = written, ""
    in_brackets = BRACKETS.findall(written)
    if len(in_brackets) == 1:
        said, as_written = BRACKETS.sub("", written), in_brackets[0].strip()
    elif not in_brackets and (apart := taken_apart(written))[1]:
        said, as_written = apart[0], apart[1][0]
    said, unit = re.sub(r"[\s_]+", " ", said).strip().lower(), usual(as_written)
    for column in columns:
        if said not in column.spellings:
            continue
        for name, units in column.names.items():
            if unit in units:
                return name, units[unit]
        allowed = f"one of the units {listing(column.units)}" if column.units else "no unit, as it is a ratio"
        example = f"`{said} ({column.units[0]})`" if column.units else f"`{said}`"
        into = "one of these" if column.units else "a ratio"
        advice = f"convert the numbers to {into}, and write the heading as {example}"
        found = f"the unit {printable(as_written)}" if unit else "no unit"
        told = f"The heading {printable(written)} has {found}; it must have {allowed}."
        if not unit:
            told = f"The heading {printable(written)} states no unit; allowed are {listing(column.units)}."
            forms = " or ".join(f"`{said} ({unit})`" for unit in column.units[:3])
            advice = f"state the unit of the numbers, as in {forms}"
        return Fault(field, found, allowed, advice, told)
    if ACCELERATION.fullmatch(said):
        told = f"The heading {printable(written)} is an acceleration of the structure, which is not fitted. {not_fitted[0]}."
        return Fault(field, printable(written), "a displacement", not_fitted[1], told)
    if _COUNTS.fullmatch(said):
        told = f"The heading {printable(written)} stands for row numbers."
        advice = "remove the column; a time history has `time (s)` in its place"
        return Fault(field, printable(written), "a column of measured values", advice, told)
    if taken_apart(written)[1] == [written] and not kind_of(written):
        told = f"The heading {printable(written)} contains a factor."
        advice = "convert the numbers, and write the heading without the factor, as in `amplitude (mm)`"
        return Fault(field, printable(written), "a heading without a factor", advice, told)
    advice = "name it by one of these; leave the column out only if none of them applies"
    if meant := _meant(said, unit, as_written, columns):
        advice = f"did you mean `{meant}`? Otherwise {advice}"
    allowed = f"one of {listing(column.spellings[0] for column in columns)}"
    told = f"The heading {printable(written)} names no known column; allowed are {allowed.removeprefix('one of ')}."
    return Fault(field, printable(written), allowed, advice, told)
