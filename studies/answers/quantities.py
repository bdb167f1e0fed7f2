"""Add values in SI units and the names of response classes to an answer, beside its ratios and codes."""

from collections.abc import Mapping
from typing import Any, TypeVar

import numpy as np
import xarray as xr

from damperlab.studies.unit_names import ACCELERATIONS, AMPLITUDES, COORDINATE_SOURCES
from damperlab.studies.units import quantities_of
from damperlab.studies.variables import ResponseClass

D = TypeVar("D", bound=xr.Dataset)

MEANT = {
    **dict.fromkeys(
        ("hybrid", "tmd", "no_damper", "value", "amplitude", "lowest", "highest"), "amplitude_ratio"
    ),
    "error": "amplitude_error",
    "impact_speed": "impact_speed_max",
    "mass": "mass_ratio",
    "clearance": "clearance_ratio",
}
"""Result or dimension of a cube that corresponds to each name used only in answers."""
_SUFFIXES = {"m": "m", "m s-2": "m_per_s2", "m s-1": "m_per_s", "J": "j", "N": "n", "kg": "kg", "Hz": "hz"}


def with_quantities(answer: D, definition: Mapping[str, Any]) -> D:
    """Convert the ratios of an answer into quantities in SI units, and add these quantities to the answer.

    Parameters
    ----------
    answer : Dataset
        The answer to a question about one study.
    definition : mapping
        The definition of the study.

    Returns
    -------
    Dataset
        The answer with a further coordinate or variable in SI units for each ratio. Examples are
        `clearance_m` and `amplitude_m`. If a ratio occurs only in answers, the unit is appended to its name,
        as in `hybrid_m`.
        Nothing is added if the study is given in ratios alone.
    """
    known = {each.source: each for each in quantities_of(definition)}
    meant = dict(MEANT)
    if "metric" in answer.attrs:  # a ranking by the worst case: its values are already in units
        del meant["value"], meant["error"]
    for name in [str(name) for name in answer.variables]:
        array = answer[name]
        each = known.get(meant.get(name, name))
        if each is None or array.attrs.get("units") not in (None, "1"):
            continue
        called = each.name if name == each.source else f"{name}_{_SUFFIXES[each.units]}"
        if called in answer.variables:
            continue
        long_name = array.attrs.get("long_name", name) if called != each.name else each.long_name
        added = (array.dims, each.of(array.values), {"units": each.units, "long_name": long_name})
        along = name in answer.coords
        answer = answer.assign_coords({called: added}) if along else answer.assign({called: added})
    return answer


def in_quantities(answer: D, metric: str) -> tuple[D, str]:
    """Return a map with axes in SI units, and the name of the result in SI units.

    Axes and results that the answer contains only as ratios stay ratios.

    Parameters
    ----------
    answer : Dataset
        A map, with or without the additions of `with_quantities`.
    metric : str
        Name of the variable that is shown.
    """
    axes = {
        source: name
        for name, source in COORDINATE_SOURCES.items()
        if source in answer.dims and name in answer.coords
    }
    in_units = (AMPLITUDES | ACCELERATIONS).get(metric, metric)
    return answer.swap_dims(axes), in_units if in_units in answer else metric


SUFFIX = "_words"
_WORDS = {kind.value: kind.name.lower() for kind in ResponseClass}


def with_words(answer: D) -> D:
    """Add to every variable of response classes a coordinate with the names of the classes.

    Parameters
    ----------
    answer : Dataset
        An answer, which may have the variables ``response_class`` and ``other_response_class``.

    Returns
    -------
    Dataset
        The answer with the text coordinate ``response_class_words``, which has the dimensions of ``response_class``.
    """
    words = {}
    for name, codes in answer.data_vars.items():
        if str(name).endswith("response_class"):
            texts = np.asarray([_WORDS[int(code)] for code in codes.values.ravel()], dtype=object)
            attributes = {"long_name": "class of the response, in words"}
            words[f"{name}{SUFFIX}"] = (codes.dims, texts.reshape(codes.shape).astype(str), attributes)
    return answer.assign_coords(words) if words else answer
