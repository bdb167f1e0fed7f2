"""Read a measured frequency response from a table of text. Every fault states the line."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.faults import Fault, StudyFaults, counted, printable
from damperlab.studies.fit.columns import (
    CONDITIONS,
    PERCENT,
    faults_of_comments,
    read_heading,
    read_headings,
    says_time,
)
from damperlab.studies.fit.lines import LARGEST, Lines, check_lines, columns_of, lines_of
from damperlab.studies.quantity import FREQUENCY_RATIO
from damperlab.studies.spelled_numbers import read_decimal

MOST_ROWS = 2_000
"""Largest number of rows. A fit computes the response of each row hundreds of times."""
_FEW_LINES = 30
"""Number of lines among which a heading is sought if the first line is not a heading."""


@dataclass(frozen=True)
class Measurement:
    """A measured frequency response of steady amplitudes.

    Parameters
    ----------
    name : str
        Name of the measurement.
    columns : mapping of ndarray, shape (rows,)
        Columns of the table in SI units or as ratios: `frequency_hz` or `frequency_ratio`; `amplitude_m` or
        `amplitude_ratio`; and the conditions of each row (`CONDITIONS`), NaN if a cell is empty.
    deviation : ndarray, shape (rows,), optional
        Standard deviation of each amplitude, in the unit of the amplitudes; None if the table states none.
    """

    name: str
    columns: Mapping[str, NDArray[np.float64]] = field(repr=False)
    deviation: NDArray[np.float64] | None = field(default=None, repr=False)

    @property
    def in_metres(self) -> bool:
        """Whether the amplitudes are lengths, instead of ratios to the base amplitude."""
        return "amplitude_m" in self.columns

    @property
    def in_hertz(self) -> bool:
        """Whether the frequencies are in Hz, instead of ratios to the natural frequency."""
        return "frequency_hz" in self.columns

    @property
    def amplitude(self) -> NDArray[np.float64]:
        """The measured amplitudes [m, or 1]."""
        return self.columns["amplitude_m" if self.in_metres else "amplitude_ratio"]

    @property
    def frequency(self) -> NDArray[np.float64]:
        """The excitation frequencies [Hz, or 1]."""
        return self.columns["frequency_hz" if self.in_hertz else "frequency_ratio"]

    @property
    def rows(self) -> int:
        """Number of amplitudes."""
        return self.amplitude.size


def parse_measurement(text: bytes | str, name: str = "measurement") -> Measurement:
    """Read a measured response.

    Parameters
    ----------
    text : bytes or str
        A table whose first line names the columns with their units, as in ``frequency (Hz), amplitude (mm)``, separated
        by comma, semicolon or tab; bytes are UTF-8. Lines that begin with # are skipped. Frequencies are in Hz, or
        divided by the natural frequency (`frequency ratio`). Amplitudes are lengths, or divided by the base amplitude
        (`X/Z`). One column may give standard deviations (`deviation (mm)`, `deviation (%)`, `deviation ratio`). Further
        columns hold conditions that differ from row to row, as in ``base amplitude (mm)`` or ``clearance ratio``; an
        empty cell stands for the known value.
    name : str
        Name of the measurement.

    Raises
    ------
    StudyFaults
        If the table is invalid. The exception contains all faults.
    """
    lines = lines_of(text)
    names, factors = _headings(lines)
    check_lines(lines, len(names))
    faults: list[Fault] = []
    if not lines.rows:
        told = "The table has headings and no rows."
        faults.append(Fault("measured", "no rows", "at least one row", "add the measured values", told))
    if len(lines.rows) > MOST_ROWS:
        found = counted(len(lines.rows), "row")
        told = f"The table has {found}; at most {MOST_ROWS:,} are allowed."
        faults.append(Fault("measured", found, f"at most {MOST_ROWS:,} rows", "leave some out", told))
        lines = replace(lines, rows=lines.rows[:MOST_ROWS])
    of = dict(zip(names, factors, strict=True))
    columns = columns_of(lines, names, lambda name, cell: _cell(name, of[name], cell), faults)
    deviation = columns.pop("deviation_m", columns.pop("deviation_ratio", None))
    share = columns.pop(PERCENT, None)
    if share is not None:
        deviation = share * columns["amplitude_m" if "amplitude_m" in columns else "amplitude_ratio"]
    return Measurement(name, columns, deviation)


def _headings(lines: Lines) -> tuple[list[str], list[float]]:
    number, text = lines.heading
    names, factors, faults = read_headings(lines.cells(text), number)
    if faults and not names and (fault := _no_heading(lines)):
        raise StudyFaults([fault])
    if not faults:
        faults = _faults_between(names, number) + faults_of_comments(lines.comments, lines.cells(text))
    if faults:
        raise StudyFaults(faults)
    return names, factors


def _no_heading(lines: Lines) -> Fault | None:
    """Return a fault if the first line is a title or a row of numbers instead of a heading."""
    number, text = lines.heading
    field, found = f"line {number}", printable(text.strip())
    allowed = "a line that names the columns"
    example = "`frequency (Hz), amplitude (mm)`, or `time (s), displacement (mm)` of a time history"
    if all(_is_number(cell) for cell in lines.cells(text)):
        told = f"{{field}} has numbers already; the first line must name the columns, each with its unit, as in {example}."
        return Fault(field, found, allowed, "write such a line above it, with the units of the numbers", told)
    if not lines.rows:
        return None
    told = f"{{field}} is {found}, which names no columns; the first line must name them, each with its unit."
    below = [
        (at, re.split(r"[;\t]" if re.search(r"[;\t]", row) else ",", row))
        for at, row in lines.rows[:_FEW_LINES]
    ]
    for at, cells in below:
        if says_time(cells[0]) or not isinstance(read_heading(cells[0], field), Fault):
            advice = f"remove the lines above line {at}, or write # before them"
            return Fault(field, found, allowed, advice, told)
    if len(lines.cells(text)) == 1 and len(below[0][1]) > 1:
        advice = f"write # before it, and add below it a line that names the columns, as in {example}"
        return Fault(field, found, allowed, advice, told)
    return None


def _is_number(cell: str) -> bool:
    try:
        float(cell.replace(",", "."))
    except ValueError:
        return False
    return True


def _faults_between(names: list[str], number: int) -> list[Fault]:
    faults = []
    for needed, example in ((("frequency_hz", "frequency_ratio"), "frequency (Hz)"),
                            (("amplitude_m", "amplitude_ratio"), "amplitude (mm)")):  # fmt: skip
        there = [name for name in needed if name in names]
        kind = needed[0].split("_")[0]
        if len(there) != 1:
            found = "both" if there else "neither"
            allowed = f"one column of {needed[0]} or {needed[1]}"
            told = f"The table has {'two columns' if there else 'no column'} of {kind}; it must have one."
            advice = f"add a column such as `{example}`" if not there else "remove one of the two"
            faults.append(Fault(f"line {number}", found, allowed, advice, told))
    deviations = [name for name in names if name.startswith("deviation")]
    wrong = {"deviation_m": "amplitude_ratio", "deviation_ratio": "amplitude_m"}
    if deviations and wrong.get(deviations[0]) in names:
        told = "The standard deviation and the amplitude must both be lengths or both be ratios."
        advice = "write `deviation (%)`, or give both in the same way"
        faults.append(Fault(f"line {number}", deviations[0], "the kind of the amplitude", advice, told))
    pairs = (("clearance_m", "clearance_ratio"), ("friction_force_n", "friction_ratio"),
             ("particle_mass_kg", "mass_ratio"), ("damping_n_s_per_m", "damping_ratio"))  # fmt: skip
    for pair in pairs:
        if set(pair) <= set(names):
            told = f"The table has both {pair[0]} and {pair[1]}, which state the same quantity."
            faults.append(Fault(f"line {number}", "both", "one of the two", "remove one of them", told))
    return faults


def _cell(name: str, factor: float, cell: str) -> float | Fault:
    """Read one number and convert it to SI units; NaN for an empty cell of a condition."""
    if not cell and name in CONDITIONS:
        return np.nan
    lowest = 0.0 if name in CONDITIONS else np.nextafter(0.0, 1.0)
    allowed = f"a number {'of at least' if lowest == 0.0 else 'above'} 0"
    advice = "correct the cell, or remove the line"
    value = read_decimal(cell)
    if not lowest <= value <= LARGEST:
        found = printable(cell) if cell else "an empty cell"
        told = f"{{field}} must be {allowed}, not {found}."
        return Fault(name, found, allowed, advice, told)
    if name == "frequency_ratio" and not FREQUENCY_RATIO.admits(value):
        return Fault(name, printable(cell), FREQUENCY_RATIO.allowed, FREQUENCY_RATIO.advice)
    return value * factor
