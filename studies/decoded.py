"""The lines of a file in any of the encodings of spreadsheets and old programs."""

from damperlab.studies.faults import Fault, StudyFaults

_WORKBOOKS = (b"PK\x03\x04", b"\xd0\xcf\x11\xe0")
_MARKS = (b"\xff\xfe", b"\xfe\xff")


def lines_in(text: bytes | str, field: str) -> list[str]:
    """Split a text into lines; raises StudyFaults for `field` if it has none. Bytes are UTF-16, UTF-8 or Latin-1."""
    # Only these end a line: splitlines() would also split at odd characters and miscount.
    return _decoded(text, field).replace("\r\n", "\n").replace("\r", "\n").replace("−", "-").split("\n")


def _decoded(text: bytes | str, field: str) -> str:
    if isinstance(text, str):
        return text.removeprefix("\ufeff")
    zeros = [text[place:2000:2].count(0) > 0.4 * len(text[place:2000:2]) for place in (0, 1)]
    if text.startswith(_MARKS) or zeros[0] != zeros[1]:
        wide = "utf-16" if text.startswith(_MARKS) else "utf-16-be" if zeros[0] else "utf-16-le"
        return text.decode(wide, errors="replace")
    if 0 in text:
        found = "a workbook" if text.startswith(_WORKBOOKS) else "a binary file"
        raise StudyFaults([Fault(field, found, "a text file", "save the sheet as CSV")])
    try:
        return text.decode("utf-8-sig")
    except UnicodeDecodeError:
        return text.decode("latin-1")
