"""Response classes as words beside their codes, so that a Dataset or a table tells what it shows."""

from typing import TypeVar

import numpy as np
import xarray as xr

from damperlab.studies.variables import ResponseClass

D = TypeVar("D", bound=xr.Dataset)

SUFFIX = "_words"
_WORDS = {kind.value: kind.name.lower() for kind in ResponseClass}


def with_words(answer: D) -> D:
    """Add to every variable of response classes a coordinate with their names.

    Parameters
    ----------
    answer : Dataset
        With or without ``response_class``, ``other_response_class``.

    Returns
    -------
    Dataset
        Of the same type, with the coordinate ``response_class_words`` (text) of the same dimensions.
    """
    words = {}
    for name, codes in answer.data_vars.items():
        if str(name).endswith("response_class"):
            texts = np.asarray([_WORDS[int(code)] for code in codes.values.ravel()], dtype=object)
            attributes = {"long_name": "class of the response, in words"}
            words[f"{name}{SUFFIX}"] = (codes.dims, texts.reshape(codes.shape).astype(str), attributes)
    return answer.assign_coords(words) if words else answer
