"""What an answer of a study in SI units has beside its ratios: the same values in units, for files and Datasets."""

from collections.abc import Mapping
from typing import Any, TypeVar

import xarray as xr

from damperlab.studies.units import quantities_of

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
"""The result or the dimension that stands under a name of an answer's own."""
_SUFFIXES = {"m": "m", "m s-2": "m_per_s2", "m s-1": "m_per_s", "J": "j", "N": "n", "kg": "kg", "Hz": "hz"}


def with_quantities(answer: D, definition: Mapping[str, Any]) -> D:
    """Add in SI units what an answer has in ratios.

    Parameters
    ----------
    answer : Dataset
        Of one study.
    definition : mapping
        Of the study.

    Returns
    -------
    Dataset
        Of the same type. Coordinates gain coordinates of the same dimensions, as `clearance_m`, and variables variables, as
        `amplitude_m`; of names of the answer's own the unit follows, as in `hybrid_m`. The same where the study is given in
        ratios alone.
    """
    known = {each.source: each for each in quantities_of(definition)}
    meant = dict(MEANT)
    if "metric" in answer.attrs:  # ranked by their worst case, in units
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
