"""Writes the answers of all routes as JSON. NaN and infinities become null, because JSON has no such numbers."""

import json
import math
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from starlette.responses import JSONResponse

AT_ONCE = 10_000
"""Largest number of values converted in one step. A step blocks all other threads for some milliseconds."""


_ENCODER = json.JSONEncoder(ensure_ascii=False, allow_nan=False, separators=(",", ":"))


def plain(value: object) -> Any:
    """Convert a value to data that JSON can represent.

    Parameters
    ----------
    value : object
        Nested mappings, sequences, NumPy arrays, numbers, strings and None.

    Returns
    -------
    object
        Copy of `value` in which arrays are lists, and NaN and infinities are None.
    """
    if isinstance(value, np.ndarray):
        if value.ndim == 0:
            return plain(value.item())
        rows = max(1, AT_ONCE * len(value) // max(1, value.size))
        return [item for start in range(0, len(value), rows) for item in _listed(value[start : start + rows])]
    if isinstance(value, np.generic):
        return plain(value.item())
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    return value


def _listed(array: np.ndarray) -> list[Any]:
    listed: list[Any]
    if array.dtype.kind == "f" and not (finite := np.isfinite(array)).all():
        gapped = array.astype(object)
        gapped[~finite] = None
        listed = gapped.tolist()
    else:
        listed = array.tolist()
    return listed


def _pieces(value: Any) -> Iterator[str]:
    """Yield JSON in pieces. Writing it in one piece would block all other threads for too long."""
    if _size(value) <= AT_ONCE:
        yield _ENCODER.encode(value)
    elif isinstance(value, dict):
        between = "{"
        for key, item in value.items():
            yield f"{between}{_ENCODER.encode(key)}:"
            yield from _pieces(item)
            between = ","
        yield "}"
    elif isinstance(value[0], list | dict):
        between = "["
        for item in value:
            yield between
            yield from _pieces(item)
            between = ","
        yield "]"
    else:
        between = "["
        for start in range(0, len(value), AT_ONCE):
            yield between
            yield _ENCODER.encode(value[start : start + AT_ONCE])[1:-1]
            between = ","
        yield "]"


def _size(value: Any) -> int:
    """Estimate the number of values, assuming that all items of a list have the size of the first item."""
    if isinstance(value, dict):
        return sum(map(_size, value.values()))
    return len(value) * _size(value[0]) if isinstance(value, list) and value else 1


class Document(JSONResponse):
    """JSON response in which NaN and infinities are null."""

    def render(self, content: Any) -> bytes:
        """Return the bytes of `content` as JSON in UTF-8."""
        text = "".join(_pieces(plain(content)))
        # a lone surrogate such as "\ud800" in a string from a client has no UTF-8 encoding, and is written as an escape
        return text.encode("utf-8", errors="backslashreplace")
