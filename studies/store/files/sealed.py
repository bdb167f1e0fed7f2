"""JSON pieces with a checksum of all their bytes: a cube's description, and the list of its marks."""

import re

import google_crc32c

PLACEHOLDER = "00000000"
"""Placeholder of the checksum, `"crc32c": "00000000"`, which the document contains once."""

_FIELD = re.compile(rb'"crc32c": "([0-9a-f]{8})"')


def seal(content: bytes) -> bytes:
    """Compute the CRC-32C of a document with the placeholder, and insert it there."""
    blank = _FIELD.sub(f'"crc32c": "{PLACEHOLDER}"'.encode(), content)
    if len(_FIELD.findall(blank)) != 1:
        raise ValueError("the document must have exactly one place for its checksum")
    return _FIELD.sub(f'"crc32c": "{google_crc32c.value(blank):08x}"'.encode(), blank)


def is_sealed(content: bytes) -> bool:
    """Whether a document has a checksum."""
    return _FIELD.search(content) is not None


def require_seal(content: bytes) -> None:
    """Raise `ValueError` unless a document's bytes match its checksum."""
    if not is_sealed(content) or seal(content) != content:
        raise ValueError("its checksum is not that of its contents")
