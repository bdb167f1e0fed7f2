"""Split a table of text into a heading and rows, and find the separator."""

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.decoded import check_end, check_factors, lines_in
from damperlab.studies.faults import Fault, StudyFaults, counted, describe, printable
from damperlab.studies.spelled_numbers import COMMAS_FOUND, WRITE_POINTS, comma_of_thousands, decimal_comma

MOST_BYTES = 4 * 1024 * 1024
_BLANKS = re.compile(r"\s{2,}|(?<=[)\]\d.])\s+(?=\S)")
"""Gap between cells without separators: several blanks, or a single blank after a bracket, a digit or a point."""
LARGEST = 1e12
"""Largest allowed number; the unit of a larger number must be wrong."""
MOST_COLUMNS = 30
"""Largest number of columns of a table, because each heading is compared with all known headings."""


@dataclass(frozen=True)
class Lines:
    """A table of text, before it is interpreted.

    Parameters
    ----------
    separator : str
        Comma, semicolon or tab; a blank if the heading contains none of these.
    heading : (int, str)
        Line number, from 1, and text of the heading.
    rows : list of (int, str)
        Line number and text of every line below the heading, without empty lines.
    comments : list of (int, str)
        Line number and text of every comment.
    """

    separator: str
    heading: tuple[int, str]
    rows: list[tuple[int, str]]
    comments: list[tuple[int, str]]

    def cells(self, text: str) -> list[str]:
        """Split one line into its cells."""
        if self.separator == " ":
            return _BLANKS.split(text.strip())
        return [cell.strip().strip('"').strip() for cell in text.split(self.separator)]


def check_lines(lines: Lines, columns: int) -> None:
    """Raise StudyFaults if numbers contain commas, or if all lines have the same wrong number of cells."""
    cut = [(number, lines.cells(text)) for number, text in lines.rows]
    for number, cells in cut:
        cell = None if lines.separator == "," else decimal_comma(cells) or comma_of_thousands(cells)
        if cell is not None:
            told = COMMAS_FOUND.rstrip(".") + f": {printable(cell)}."
            raise StudyFaults(
                [Fault(f"line {number}", printable(cell), "decimal points", WRITE_POINTS, told)]
            )
    sizes = {len(cells) for _, cells in cut}
    if len(cut) > 1 and len(sizes) == 1 and columns not in sizes:
        (size,) = sizes
        told = f"Each of the {len(cut)} lines after the heading has {counted(size, 'cell')}, but the heading names "
        told += f"{counted(columns, 'column')}."
        advice = "name every column in the heading"
        if lines.separator == "," and size > columns:
            advice += "; if the numbers have decimal commas, write decimal points"
        allowed = f"{columns} cells in each line"
        raise StudyFaults([Fault(f"line {lines.heading[0]}", counted(size, "cell"), allowed, advice, told)])


def columns_of(
    lines: Lines, names: Sequence[str], read: Callable[[str, str], float | Fault], faults: list[Fault]
) -> dict[str, NDArray[np.float64]]:
    """Read the numbers of a table by column. Raise StudyFaults with `faults` and new faults, if there are any."""
    rows: list[list[float]] = []
    for number, line in lines.rows:
        cells = lines.cells(line)
        if len(cells) != len(names):
            found = counted(len(cells), "cell")
            told = f"Line {number} has {found}, but the heading names {counted(len(names), 'column')}."
            advice = "correct the line, or remove it"
            faults.append(Fault(f"line {number}", found, f"{len(names)} cells", advice, told))
            continue
        values = [read(name, cell) for name, cell in zip(names, cells, strict=True)]
        faults += [value.under(f"line {number}") for value in values if isinstance(value, Fault)]
        rows.append([value for value in values if not isinstance(value, Fault)])
    if faults:
        raise StudyFaults(faults)
    return dict(zip(names, np.array(rows).T, strict=True))


def read_bytes(path: Path | str) -> bytes:
    """Read at most `MOST_BYTES` + 1 bytes of a file. Raise StudyFaults if the file cannot be read."""
    try:
        with Path(path).open("rb") as file:
            return file.read(MOST_BYTES + 1)
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) and error.strerror else "not a path"
        told = f"The file {printable(str(path))} cannot be read: {reason}."
        found = f"{describe(str(path))} ({reason})"
        raise StudyFaults([Fault("measured", found, "a readable file", "check the path", told)]) from None


def lines_of(text: bytes | str) -> Lines:
    """Split a table into lines.

    Raise StudyFaults if the table is too large, empty or cut off, or if a comment gives a factor for the
    samples.

    Lines that begin with # or % are comments. If the first line that is not a comment has no words, the
    comment directly above it is the heading.
    """
    if len(text) > MOST_BYTES:
        allowed = f"a file of at most {MOST_BYTES:,} bytes"
        raise StudyFaults([Fault("measured", f"{len(text):,} bytes", allowed, "give fewer rows")])
    written = lines_in(text, "measured")
    all_lines = [(number, line) for number, line in enumerate(written, start=1) if line.strip()]
    lines = [(number, line) for number, line in all_lines if line.lstrip()[0] not in "#%"]
    above = all_lines.index(lines[0]) if lines else 0
    if above and not re.search("[a-zA-Z]{2}", lines[0][1]):
        number, line = all_lines[above - 1]
        lines = [(number, line.lstrip("#% ")), *lines]
    if not lines:
        advice = "write a heading such as `frequency (Hz), amplitude (mm)` and one row for each frequency"
        raise StudyFaults(
            [Fault("measured", "nothing", "a table", advice, "The file holds no table of measured values.")]
        )
    separator = next((one for one in (";", "\t", ",") if one in lines[0][1]), " ")
    columns = lines[0][1].count(separator) + 1
    if columns > MOST_COLUMNS:
        allowed, advice = f"at most {MOST_COLUMNS} columns", "keep only the columns to fit"
        raise StudyFaults([Fault(f"line {lines[0][0]}", counted(columns, "column"), allowed, advice)])
    used = {number for number, _ in lines}
    comments = [(number, line.strip()) for number, line in all_lines if number not in used]
    check_factors(comments)
    table = Lines(separator, lines[0], lines[1:], comments)
    check_end(written, [table.cells(line)[-1] for _, line in table.rows])
    return table
