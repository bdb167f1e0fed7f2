"""JSON documents with a checksum, such as the description and the list of done-marks of a cube."""

import re

import google_crc32c

PLACEHOLDER = "00000000"
"""Value of the field `crc32c` while the checksum of the document is computed."""

_FIELD = re.compile(rb'"crc32c": "([0-9a-f]{8})"')


def seal(content: bytes) -> bytes:
    """Return a document with its checksum in the field `crc32c`. During the computation of the checksum, this field
    contains the placeholder.
    """
    blank = _FIELD.sub(f'"crc32c": "{PLACEHOLDER}"'.encode(), content)
    if len(_FIELD.findall(blank)) != 1:
        raise ValueError("the document must have exactly one place for its checksum")
    return _FIELD.sub(f'"crc32c": "{google_crc32c.value(blank):08x}"'.encode(), blank)


def is_sealed(content: bytes) -> bool:
    """Whether a document has a checksum."""
    return _FIELD.search(content) is not None


def require_seal(content: bytes) -> None:
    """Raise `ValueError` if a document has no checksum, or its bytes do not match the checksum."""
    if not is_sealed(content) or seal(content) != content:
        raise ValueError("the checksum does not match the contents")
