"""JSON documents: the answers of all routes. JSON has no NaN and no infinity, so both become null."""

import json
import math
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from starlette.responses import JSONResponse

AT_ONCE = 10_000
"""Numbers written in one step, in which the interpreter does nothing else for some milliseconds."""


_ENCODER = json.JSONEncoder(ensure_ascii=False, allow_nan=False, separators=(",", ":"))


def plain(value: object) -> Any:
    """Convert `value` to JSON-able data.

    Parameters
    ----------
    value : object
        Mappings, sequences, numpy arrays and scalars, numbers, strings, None, at any depth.

    Returns
    -------
    object
        The same with arrays as lists and every number that is not finite as None.
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
    """Write JSON piece by piece, because a single step would stop every other thread."""
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
    """Estimate the number of values, from the first of each list."""
    if isinstance(value, dict):
        return sum(map(_size, value.values()))
    return len(value) * _size(value[0]) if isinstance(value, list) and value else 1


class Document(JSONResponse):
    """A JSON response in which NaN and infinities are null, and client strings are escaped."""

    def render(self, content: Any) -> bytes:
        """Return the bytes of `content` as JSON in UTF-8."""
        text = "".join(_pieces(plain(content)))
        # A client may send "\ud800", half a character, which UTF-8 cannot encode; JSON can, as the same escape.
        return text.encode("utf-8", errors="backslashreplace")
