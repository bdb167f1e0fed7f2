"""JSON documents: what every route answers with. JSON has no NaN and no infinity, so both become null."""

import json
import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from starlette.responses import JSONResponse


def plain(value: object) -> Any:
    """Turn `value` into what JSON can hold.

    Parameters
    ----------
    value : object
        Mappings, sequences, numpy arrays and scalars, numbers, strings, None, nested as one likes.

    Returns
    -------
    object
        The same with arrays as lists and every number that is not finite as None.
    """
    if isinstance(value, np.ndarray):
        if value.dtype.kind != "f":
            return value.tolist()
        finite = np.isfinite(value)
        # The common case, no gap at all, is one C call; arrays here can hold millions of points.
        if finite.all():
            return value.tolist()
        gapped = value.astype(object)
        gapped[~finite] = None
        return gapped.tolist()
    if isinstance(value, np.generic):
        return plain(value.item())
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    return value


class Document(JSONResponse):
    """A JSON response in which NaN and infinities are null, whatever strings a client has sent."""

    def render(self, content: Any) -> bytes:
        """Return the bytes of `content` as JSON in UTF-8."""
        text = json.dumps(plain(content), ensure_ascii=False, allow_nan=False, separators=(",", ":"))
        # A client may send "\ud800", half a character, which UTF-8 cannot hold; JSON can, as the same escape.
        return text.encode("utf-8", errors="backslashreplace")
