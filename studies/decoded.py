"""The text of a file in any of the encodings that spreadsheets and old programs write."""


def decoded(text: bytes | str) -> str:
    """Turn bytes into text: UTF-16 where they begin with its mark, else UTF-8 or, as old files are, Latin-1."""
    if isinstance(text, str):
        return text
    if text.startswith((b"\xff\xfe", b"\xfe\xff")):
        return text.decode("utf-16", errors="replace")
    try:
        return text.decode("utf-8-sig")
    except UnicodeDecodeError:
        return text.decode("latin-1")
