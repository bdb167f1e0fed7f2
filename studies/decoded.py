"""The text of a file in any of the encodings that spreadsheets and old programs write."""

from damperlab.studies.faults import Fault, StudyFaults

_WORKBOOKS = (b"PK\x03\x04", b"\xd0\xcf\x11\xe0")
_MARKS = (b"\xff\xfe", b"\xfe\xff")


def decoded(text: bytes | str, field: str) -> str:
    """Turn bytes into text: UTF-16, UTF-8 or, as old files are, Latin-1; raises StudyFaults where `field` is none."""
    if isinstance(text, str):
        return text.removeprefix("\ufeff")
    if text.startswith(_WORKBOOKS):
        raise StudyFaults([Fault(field, "a workbook", "a text file", "save the sheet as CSV")])
    zeros = [text[place:2000:2].count(0) > 0.4 * len(text[place:2000:2]) for place in (0, 1)]
    if text.startswith(_MARKS) or zeros[0] != zeros[1]:
        wide = "utf-16" if text.startswith(_MARKS) else "utf-16-be" if zeros[0] else "utf-16-le"
        return text.decode(wide, errors="replace")
    if 0 in text:
        raise StudyFaults([Fault(field, "a binary file", "a text file", "export the table as text (CSV)")])
    try:
        return text.decode("utf-8-sig")
    except UnicodeDecodeError:
        return text.decode("latin-1")
