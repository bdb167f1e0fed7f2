"""Responses over the band under the largest amplitude of what binds: of the damper as drawn, and of others beside it."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.design.absorber import curve as absorber_curve
from damperlab.studies.design.build import Build
from damperlab.studies.design.found import Found
from damperlab.studies.tmd.absorber import Absorber

SAMPLES = 301
"""Frequencies of a response in closed form."""
NO_DAMPER = Absorber(0.0, 1.0, 1.0)


def response_document(found: Found, build: Build) -> dict[str, Any]:
    """Give the response of a damper as drawn at every frequency computed, with its error; empty without a band."""
    asked = found.asked
    if not asked.excitations:
        return {}
    curve = found.book.curve(build, found.binding.largest)
    return _over(found, curve.r, curve.measured) | {"error": curve.errors.tolist()}


def closed_form_document(found: Found, absorber: Absorber) -> dict[str, Any]:
    """Give the response with a tuned mass damper, or with none, on the nominal structure; empty without a band."""
    if not found.asked.excitations:
        return {}
    r = np.linspace(
        found.binding.low, found.binding.high, SAMPLES if found.binding.high > found.binding.low else 1
    )
    return _over(found, r, absorber_curve(found.asked, found.binding.largest, absorber, r))


def _over(found: Found, r: NDArray[np.float64], values: NDArray[np.float64]) -> dict[str, Any]:
    known: dict[str, Any] = {"frequency_ratio": r.tolist(), "value": values.tolist()}
    if found.asked.in_units:
        known["frequency_hz"] = (r * found.asked.structure.natural_frequency_hz).tolist()
    return known
