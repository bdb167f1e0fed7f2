"""Reads lines from text files, in the encodings of spreadsheets and old programs."""

import re
from collections.abc import Sequence

from damperlab.studies.faults import Fault, StudyFaults, printable

_PACKED = (b"PK\x03\x04", b"\x1f\x8b", b"BZh", b"\xfd7zXZ")
"""First bytes of compressed files, including workbooks."""
_OLD_WORKBOOK = b"\xd0\xcf\x11\xe0"
_WORKBOOKS = (b"[Content_Types].xml", b"opendocument")
_MARKS = (b"\xff\xfe", b"\xfe\xff")
_FACTORS = re.compile(
    r"\b(?:scal\w+|conversion|calibration) factor|\b(?:multipl\w+|normali[sz]ed) (?:by|with)\b"
    r"|\bscale\b\s*[:=]?\s*\.?\d(?![\d.]*\s*:)|\btimes\s+\d|\([x×]\s*\d",
    re.IGNORECASE,
)
"""Statements of a factor. A scale such as 1:3 is that of a model."""
_ENOUGH = 10
"""The last number of a table is checked for missing digits only if the table has more numbers than this."""


def lines_in(text: bytes | str, field: str) -> list[str]:
    """Split a text into lines. Bytes may be UTF-16, UTF-8 or Latin-1.

    Raises
    ------
    StudyFaults
        If the bytes are binary; `field` is the field of the fault.
    """
    # splitlines() would also split at other control characters, and so give wrong line numbers
    return _decoded(text, field).replace("\r\n", "\n").replace("\r", "\n").replace("−", "-").split("\n")


def check_end(lines: Sequence[str], numbers: Sequence[str]) -> None:
    """Raise StudyFaults if a file seems to be cut off.

    The last line then lacks a line break, and the last number has fewer digits than all other numbers.
    """
    digits = [len(number.partition(".")[2]) for number in numbers]
    alike = len(numbers) > _ENOUGH and len(set(digits[:-1])) == 1
    if lines[-1] and numbers[-1] and alike and digits[-1] < digits[0]:
        shown = printable(numbers[-1])
        told = f"The file seems to be cut off: its last number, {shown}, has fewer digits than all others."
        advice = "give the complete file, or end its last line with a line break"
        allowed = f"{digits[0]} characters after the point"
        raise StudyFaults([Fault(f"line {len(lines)}", shown, allowed, advice, told)])


def check_factors(lines: Sequence[tuple[int, str]]) -> None:
    """Raise StudyFaults if a line states a factor for the samples. Each item of `lines` is the number and the text of a
    line.
    """
    for number, line in lines:
        if _FACTORS.search(line):
            told = f"Line {number} names a factor: {printable(line)}. The samples must include it already."
            advice = "multiply the samples by the factor and remove the line; if they include it already, only remove the line"
            raise StudyFaults([Fault(f"line {number}", "a factor", "samples that include it", advice, told)])


def _decoded(text: bytes | str, field: str) -> str:
    if isinstance(text, str):
        return text.removeprefix("\ufeff")
    zeros = [text[place:2000:2].count(0) > 0.4 * len(text[place:2000:2]) for place in (0, 1)]
    if text.startswith(_MARKS) or zeros[0] != zeros[1]:
        wide = "utf-16" if text.startswith(_MARKS) else "utf-16-be" if zeros[0] else "utf-16-le"
        return text.decode(wide, errors="replace")
    if 0 in text:
        found, advice = "a binary file", "write the numbers as text, for example as CSV"
        if text.startswith(_OLD_WORKBOOK) or any(name in text for name in _WORKBOOKS):
            found, advice = "a workbook", "save the sheet as CSV"
        elif text.startswith(_PACKED):
            found, advice = "a compressed file", "unpack it, and give the file within"
        raise StudyFaults([Fault(field, found, "a text file", advice)])
    try:
        return text.decode("utf-8-sig")
    except UnicodeDecodeError:
        return text.decode("latin-1")
